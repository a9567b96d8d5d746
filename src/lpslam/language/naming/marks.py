"""Where marks stand in what is painted: one that stands elsewhere is a letter, or a gap, that was misread."""

from collections.abc import Container, Iterator

from lpslam.language.tables.knowledge import load_chinese_words
from lpslam.language.tables.spelling import is_ideograph

_PAUSES, _BEHIND, _NEVER = frozenset(",;"), frozenset(",;:!?."), frozenset("|\\^~")
_PAIRS = {"(": ")", "[": "]", "{": "}", "（": "）", "【": "】", "「": "」"}
_CLOSING = {closing: opening for opening, closing in _PAIRS.items()}

_DASHES = "-–—"

ODD_MARK = 5.0
"""Log odds by which a name with a mark where none is painted is less likely exact: one in 10,000 known names has such a
mark, and of misread names a few in a hundred."""
_LETTERS = range(4, 1, -1)
"""Ideographs of listed words, the longest first."""


def odd_marks(text: str) -> list[int]:
    """Where in a text marks stand where signs have none.

    Of 52,000 known names none has a comma with a Latin letter right behind it, two have a point between a digit and a
    letter, two a dash with a space before and a letter behind it, one a bar, none half a pair of brackets, and none a
    colon, point or the like with a space before and a letter behind it.
    """
    found = []
    for at, mark in enumerate(text):
        if mark.isalnum() or mark.isspace():
            continue
        before, behind = text[at - 1 : at] if at else "", text[at + 1 : at + 2]
        if _is_odd(mark, before, behind) or _is_alone(mark, text):
            found.append(at)
    return found


def misread_letters(text: str) -> list[int]:
    """Where in a text odd marks stand for letters; a comma right between two may be their gap."""
    return [at for at in odd_marks(text) if text[at] not in _PAUSES or text[at - 1].isspace()]


def _is_odd(mark: str, before: str, behind: str) -> bool:
    if mark in _BEHIND and before.isspace() and behind.isalpha():
        return True
    if mark in _PAUSES:
        # A comma of 20,000 has no space, nor has Chinese.
        return before.isalnum() and behind.isalpha() and not is_ideograph(before) and not is_ideograph(behind)
    if mark == ".":
        return before.isdigit() and behind.isalpha()
    if mark == "-":
        return before.isspace() and behind.isalpha()
    return mark in _NEVER


def _is_alone(mark: str, text: str) -> bool:
    """Whether a bracket lacks the other one."""
    other = _PAIRS.get(mark) or _CLOSING.get(mark)
    return other is not None and other not in text


def with_gaps(text: str, words: Container[str]) -> str:
    """A text with a space for each odd mark that parts two known words, and without dashes at its ends.

    As dashes the edges of a board are read; one in 52,000 known names ends with one.
    """
    text = text.strip(_DASHES).strip() or text
    for at in odd_marks(text):
        first, second = text[:at].split(), text[at + 1 :].split()
        if first and second and all(len(each) > 1 and each.casefold() in words for each in (first[-1], second[0])):
            text = f"{text[:at]} {text[at + 1 :]}"
    return text


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
