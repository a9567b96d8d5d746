"""How probable it is that a reading is exactly what is painted, by how the text was seen and how sure its letters are.

A logistic model with few terms. Its coefficients are fitted to lettering drawn in many fonts, kinds, sizes, angles,
blurs and noises (`benchmarks/text_calibration.py`; the command stands beside them).
"""

from dataclasses import dataclass
from math import exp, log

from lpslam.language.model import Slots
from lpslam.language.tables.spelling import is_ideograph

# Box heights, pixels, between which height tells: below, all is guessed; above, the recogniser sees no more than 48.
_LOW, _HIGH = 8.0, 72.0
# Box height at which the term of height is nought.
_USUAL = 24.0
# Largest logit of a letter's probability; what is surer is so by rounding.
_SUREST = 7.0
# What stands for the sharpness of a line that nobody looked at, and the least that is believed.
_USUAL_SHARPNESS, _LEAST_SHARPNESS = 0.25, 0.02

# What a reading with room for one more ideograph is worth: one in seventeen is right; some names stand in two groups.
_WITH_HOLE = 0.25


@dataclass(frozen=True, slots=True)
class Certainty:
    """Coefficients of the logistic model: one a term of `terms`, in that order."""

    bias: float
    height: float
    aslant: float
    sharpness: float
    confidence: float
    weakest: float
    length: float
    ideographs: float
    small_ideographs: float
    nearly_read: float

    def probability(self, terms: tuple[float, ...]) -> float:
        """The probability, 0 to 1, that a reading with such terms is exactly right."""
        own = (self.height, self.aslant, self.sharpness, self.confidence, self.weakest)
        rest = (self.length, self.ideographs, self.small_ideographs, self.nearly_read)
        return 1.0 / (1.0 + exp(-self.bias - sum(a * b for a, b in zip((*own, *rest), terms, strict=True))))


# python benchmarks/text_calibration.py fit --rows DIR (docs/benchmarks/text.md has how well it holds)
READING = Certainty(-1.259, 0.354, -0.350, 0.015, 0.621, 0.442, -0.243, -0.283, -0.021, -1.019)


def terms(
    text: str, confidence: float, slots: Slots, sharpness: float | None, letter_height: float, frontal: float
) -> tuple[float, ...]:
    """What the probability rests on, one number for each coefficient of `Certainty` but the bias.

    Args:
        text, confidence, slots, sharpness: of the `Recognition`.
        letter_height: pixels, of the box.
        frontal: cosine of the viewing angle.
    """
    letters = max(sum(not ch.isspace() for ch in text), 1)
    taken = [slot[0][1] for slot in slots if slot[0][0]]
    # Without slots: no letter can be weaker than this, the mean being what it is.
    weakest = min(taken) if taken else max(1.0 - letters * (1.0 - confidence), 0.5 * confidence)
    height = log(min(max(letter_height, _LOW), _HIGH) / _USUAL)
    ideographs = sum(map(is_ideograph, text)) / letters
    return (
        height,
        1.0 - min(max(frontal, 0.0), 1.0),
        log(max(sharpness or _USUAL_SHARPNESS, _LEAST_SHARPNESS) / _USUAL_SHARPNESS),
        _logit(confidence),
        _logit(weakest),
        log(letters),
        ideographs,
        ideographs * height,
        float(sum(not slot[0][0] for slot in slots)),
    )


def probability_right(
    text: str,
    confidence: float,
    slots: Slots = (),
    sharpness: float | None = None,
    letter_height: float = _USUAL,
    frontal: float = 1.0,
    has_hole: bool = False,
) -> float:
    """The probability, 0 to 1, that a reading is exactly what is painted; arguments as of `terms` and `Recognition`."""
    right = READING.probability(terms(text, confidence, slots, sharpness, letter_height, frontal))
    return right * _WITH_HOLE if has_hole else right


def _logit(probability: float) -> float:
    odds = max(probability, 1e-6) / max(1.0 - probability, 1e-6)
    return min(max(log(odds), -_SUREST), _SUREST)
