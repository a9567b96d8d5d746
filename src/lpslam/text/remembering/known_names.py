"""What known names tell of a text that is none of them: whether it is whole, and whether it is spelt as names are.

The end of the view, or something nearer, may have cut a text anywhere. Of all places in known names where the letters
at such an end stand, some are where a name begins or ends, and the others are within one: “书店” ends names and hardly
begins one, and “ill & Ink” begins as no name does.
"""

from functools import lru_cache
from math import log

from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.tables.spelling import is_ideograph
from lpslam.text.remembering.ends import begins_by_case

LINE_ENDS = 0.4
"""Heights of a box by which the view must go on beyond an end for the line to end there: a space is a third of one."""

WORD_ENDS = 0.15
"""The same for a word to end there, if not the line: wider than the gap between two letters. Ideographs have none."""

_LONGEST = 8
"""Letters at an end that are looked up together, at most: longer ones are in one name only, if in any."""

_WEIGHT = 3.0
"""Places in names that what fewer letters say counts for."""

_LETTERS = 30.0
"""As one of so many letters, each as likely as any other, a pattern is read."""

_SPELT = 0.32
"""Mean log odds of a letter, given the two before it, from which a text is spelt as names are: nine of ten known names
and words of signs have more when they are left out, four of five brands alone; runes and loops mostly less."""

_UNSEEN = 5.0
"""Places in names that the frequency of a letter counts for where two others stand before it."""

_APART = "\n"


def ends_are_there(text: str, room: tuple[float, float]) -> tuple[float, float]:
    """The probabilities, 0 to 1, that nothing more is painted before a text, and behind it.

    Args:
        text: not empty.
        room: how far the view went on before and behind it, in heights of its box.
    """
    key = " ".join(text.casefold().split())
    is_word = begins_by_case(text.strip())
    return _end_is_there(key, room[0], is_word, False), _end_is_there(key[::-1], room[1], False, True)


def _end_is_there(letters: str, room: float, is_word: bool, is_end: bool) -> float:
    if room >= LINE_ENDS or not letters:
        return 1.0
    is_word |= room >= WORD_ENDS
    return _share_at_rim(letters[:_LONGEST], is_word and not is_ideograph(letters[0]), is_end)


@lru_cache(maxsize=4096)
def is_spelt_as_names(text: str) -> bool:
    """Whether the letters of a text follow each other as in names, rather than as those of a pattern do."""
    key = " ".join("".join(letter for letter in text.casefold() if letter.isalnum() or letter.isspace()).split())
    if not key:
        return False
    names, odds = _names(False), 0.0
    line = _APART + key + _APART
    for at in range(1, len(line)):
        letter, before = line[at], line[max(at - 2, 0) : at]
        usual = names.count(letter) / len(names)
        share = (names.count(before + letter) + _UNSEEN * usual) / (names.count(before) + _UNSEEN)
        odds += log(max(share, 1.0 / len(names)) * _LETTERS)
    return odds / (len(line) - 1) >= _SPELT


@lru_cache(maxsize=4096)
def _share_at_rim(letters: str, is_word: bool, is_end: bool) -> float:
    """Of the places in names where letters stand, the share at which a name begins, or ends (letters reversed).

    Args:
        letters: from the rim inwards.
        is_word: whether a word begins or ends there: then only such places count.
        is_end: which rim.
    """
    names = _names(is_end)
    count = names.count(_APART) - 1
    places = count + names.count(" ") if is_word else len(names) - count
    share, before = count / places, 0
    for length in range(1, len(letters) + 1):
        part = letters[:length]
        at_rim = names.count(_APART + part)
        there = at_rim + names.count(" " + part) if is_word else names.count(part)
        if not there:
            break
        # The same places say no more by one letter more.
        if there != before:
            share, before = (at_rim + _WEIGHT * share) / (there + _WEIGHT), there
    return share


@lru_cache(maxsize=2)
def _names(is_reversed: bool) -> str:
    """All known names, one a line."""
    names = sorted({each.painted.casefold() for each in load_knowledge().known.values()})
    lines = _APART + _APART.join(names) + _APART
    return lines[::-1] if is_reversed else lines
