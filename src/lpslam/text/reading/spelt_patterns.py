"""What a reader makes of a pattern: few shapes, over and over.

Motifs are read as the letters that look like them, and come again after one, two or three places. How much likelier a
spelling is that way than as a word's or a number's, is evidence beside the picture's own.
"""

from collections.abc import Sequence
from functools import lru_cache
from math import log

from lpslam.language.tables.forms import load_folder
from lpslam.language.tables.knowledge import load_chinese_words, load_words
from lpslam.language.tables.spelling import is_ideograph

SUSPECT = 2.0
"""Log odds from which a spelling is one of a pattern where the picture too is more like a pattern than words are."""

CLEAR = 8.0
"""The same from which the spelling is enough: XOXOXO and XXXX have more, LILLI, BANANA, 0000 and 888 less."""

# Logarithms of the probability of a letter, a digit, a digit again, an ideograph and one again of a text: how much
# signs tell by each. Telephone numbers and years repeat their digits; of 100 characters in Chinese words one or so
# says the one before it again.
_LETTER, _DIGIT, _DIGIT_AGAIN, _IDEOGRAPH, _IDEOGRAPH_AGAIN = -2.8, -2.3, -1.2, -6.0, -4.5
# Of a pattern: its first motif; the same motif again, as far back as its period reaches; the same motif seen otherwise,
# as one of about four letters of its shape; and another motif, of about a dozen.
_FIRST, _AGAIN, _SHAPE, _OTHER, _PERIOD = log(0.08), log(0.8), log(0.03), log(0.007), 3
# Letters as which one shape is read: rings, strokes, crosses, zigzags, combs, frames.
_SHAPES = ("o0QCGDU@869", "il1|TtJHj!4", "xKkYy+vV×", "mMwWnNaAuZz7", "eEFfBPpRr", "口日目田回凸凹囗吕品□")
_SHAPE_OF = {
    letter: shape for shape, letters in enumerate(_SHAPES) for each in letters for letter in (each, each.upper())
}


def shapes_of(text: str) -> frozenset[int | str]:
    """The shapes that the letters of a text are: one for all letters as which one shape is read."""
    return frozenset(_SHAPE_OF.get(letter, letter) for letter in text if letter.isalnum())


@lru_cache(maxsize=4096)
def pattern_odds(text: str) -> float:
    """How much likelier, in log odds, a spelling is as a pattern's than as a text's; a known word is no pattern's."""
    letters = [ch for ch in text if not ch.isspace()]
    if not letters or _is_word(text):
        return float("-inf")
    odds = 0.0
    for at, letter in enumerate(letters):
        before = letters[max(at - _PERIOD, 0) : at]
        as_text = _as_text(letter, before)
        odds += _as_motif(letter, before, as_text) - as_text
    return odds


def _is_word(text: str) -> bool:
    # A row of frames is read as a word as well: 日日, 凹凸.
    is_framed = all(letter in _SHAPE_OF for letter in text)
    return text.casefold() in load_words() or (not is_framed and load_folder().key(text) in load_chinese_words())


def _as_text(letter: str, before: Sequence[str]) -> float:
    """Logarithm of the probability that a text's next letter is this one."""
    if is_ideograph(letter):
        return _IDEOGRAPH_AGAIN if letter in before else _IDEOGRAPH
    if letter.isdigit():
        return _DIGIT_AGAIN if letter in before else _DIGIT
    return _LETTER


def _as_motif(letter: str, before: Sequence[str], as_text: float) -> float:
    """Logarithm of the probability that a pattern's next motif is read so, those before it being given."""
    shape = _SHAPE_OF.get(letter)
    if letter in before:
        return _AGAIN
    if shape is not None and any(_SHAPE_OF.get(each) == shape for each in before):
        return _SHAPE
    # As which of thousands of characters a motif is read is as surprising as of a text.
    return min(_OTHER if before else _FIRST, as_text - 1.0 if shape is None else 0.0)
