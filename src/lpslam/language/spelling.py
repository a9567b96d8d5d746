"""Which spelling best explains a class of misread strings: readers as a noisy channel (text clustering, III-E).

Every reading is taken for the painted text sent through a reader that cuts ends off, confuses letters that look alike,
and now and then anything else. What explains all readings at the least cost wins; a known name gets an advance on
those costs, the longer it is the more, since few unknown names come so near to it by chance.
"""

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from importlib.resources import files

from rapidfuzz.distance import Levenshtein

# Costs of a reader's slips, in natural logarithms of how much rarer they are than a right letter.
_WRONG_LETTER = 3.0
_LOOK_ALIKE = 1.5
# There are thousands of ideographs: one that does not even look like the other is hardly read in its place twice.
_WRONG_IDEOGRAPH = 4.5
# Confident wrong readings are mostly cut off: at a pillar, at the end of a box.
_CUT_END, _CUT_LETTER = 2.0, 0.3
# A round or square logo beside Chinese is read as a letter of another script, again and again.
_LOGO = 0.8
# Letters of the shortest word that is replaced by a known one: shorter ones have too many neighbours.
_LEAST_RESPELLED = 4
# Repeated readings repeat their slips, the view being the same: n of them are worth n to this power.
_REPETITION = 0.75


def weigh(readings: Iterable[tuple[str, int, float]]) -> dict[str, float]:
    """Weight of each key from (key, count, confidence 0 to 1)."""
    counts: dict[str, float] = {}
    sums: dict[str, float] = {}
    for key, count, confidence in readings:
        if key and count > 0:
            counts[key] = counts.get(key, 0.0) + count
            sums[key] = sums.get(key, 0.0) + count * min(max(confidence, 0.0), 1.0)
    return {key: sums[key] / counts[key] * counts[key] ** _REPETITION for key in counts}


def misreading_cost(painted: str, read: str, looks: Callable[[str], str]) -> float:
    """Cost of reading `painted` as `read`; 0 when they are equal.

    Args:
        painted, read: keys, not empty.
        looks: takes a letter to what it looks like.
    """
    if painted == read:
        return 0.0
    steps = Levenshtein.editops(painted, read)
    lost = {step.src_pos for step in steps if step.tag == "delete"}
    first = next(position for position in range(len(painted) + 1) if position not in lost)
    last = next(position for position in range(len(painted) - 1, -2, -1) if position not in lost)
    cost = sum(_CUT_END + _CUT_LETTER * (missing - 1) for missing in (first, len(painted) - 1 - last) if missing > 0)
    for step in steps:
        if step.tag == "insert" and _is_logo(painted, read, step.dest_pos):
            cost += _LOGO
        elif step.tag == "replace" and _is_alike(painted[step.src_pos], read[step.dest_pos], looks):
            cost += _LOOK_ALIKE
        elif step.tag != "delete" or first <= step.src_pos <= last:
            is_other = (
                step.tag == "replace" and is_ideograph(painted[step.src_pos]) and is_ideograph(read[step.dest_pos])
            )
            cost += _WRONG_IDEOGRAPH if is_other else _WRONG_LETTER
    return min(cost, _LOOK_ALIKE) if looks(painted) == looks(read) else cost


def is_ideograph(letter: str) -> bool:
    """Whether a letter is a Chinese character: a word, or a part of one, by itself."""
    return "\u4e00" <= letter <= "\u9fff"


def _is_logo(painted: str, read: str, at: int) -> bool:
    """Whether a letter that was read, but not painted, is the only one of its script and stands at an end."""
    return at in (0, len(read) - 1) and read[at].isascii() and read[at].isalpha() and not any(map(str.isascii, painted))


def respelled(text: str, words: frozenset[str]) -> list[str]:
    """Texts in which one unknown word is replaced by a known one that is a single slip away.

    Args:
        text: without case and accents, words separated by spaces.
        words: the known ones.
    """
    parts = text.split()
    return [
        " ".join([*parts[:at], known, *parts[at + 1 :]])
        for at, word in enumerate(parts)
        if len(word) >= _LEAST_RESPELLED and word.isascii() and word.isalpha() and word not in words
        for known in sorted(_one_slip_from(word) & words)
    ]


def _one_slip_from(word: str) -> set[str]:
    splits = [(word[:at], word[at:]) for at in range(len(word) + 1)]
    letters = "abcdefghijklmnopqrstuvwxyz"
    return (
        {head + tail[1:] for head, tail in splits if tail}
        | {head + letter + tail[1:] for head, tail in splits if tail for letter in letters}
        | {head + letter + tail for head, tail in splits for letter in letters}
    )


def _is_alike(letter: str, other: str, looks: Callable[[str], str]) -> bool:
    return letter + other in _near() or looks(letter) == looks(other)


@lru_cache(maxsize=1)
def _near() -> frozenset[str]:
    """Pairs of letters, beside those that look the same, that blur and distance turn into each other; both ways.

    They are found by drawing every letter small (`tools/build_lookalikes.py`).
    """
    table = (files("lpslam.language") / "data" / "lookalikes.txt").read_text(encoding="utf-8")
    return frozenset(pair for both in table.split() for pair in (both, both[::-1]))


def explanation_cost(painted: str, weights: Sequence[tuple[str, float]], looks: Callable[[str], str]) -> float:
    """Cost at which a painted key explains all readings, (key, weight) each."""
    return sum(weight * misreading_cost(painted, read, looks) for read, weight in weights)
