"""Common Chinese words in what was read: where no space parts words, a list of them tells likely strings."""

from collections.abc import Iterator

from lpslam.language.tables.knowledge import load_chinese_words

_LETTERS = range(4, 1, -1)
"""Ideographs of listed words, the longest first."""


def words_in(key: str) -> list[str]:
    """Cut a key into listed words, so that they cover as many of its letters as they can, and the fewest words do.

    Args:
        key: of `Folder.key`.
    """
    known = load_chinese_words()
    # The best cut of the letters before each place: how many it covers, less a tenth a word, and its words.
    best: list[tuple[float, list[str]]] = [(0.0, [])]
    for end in range(1, len(key) + 1):
        begins = (end - letters for letters in _LETTERS if letters <= end)
        ways = [
            (best[begin][0] + end - begin - 0.1, [*best[begin][1], key[begin:end]])
            for begin in begins
            if key[begin:end] in known
        ]
        best.append(max([best[end - 1], *ways], key=lambda way: way[0]))
    return best[-1][1]


def is_in_a_word(key: str, at: int) -> bool:
    """Whether a listed word of a key covers the letter in place `at`."""
    return any(word in load_chinese_words() for word in _around(key, at))


def _around(key: str, at: int) -> Iterator[str]:
    for letters in _LETTERS:
        for begin in range(max(at - letters + 1, 0), min(at, len(key) - letters) + 1):
            yield key[begin : begin + letters]
