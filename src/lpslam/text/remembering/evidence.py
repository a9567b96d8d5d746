"""What was read of a class, view by view: readings of one view repeat each other's slips and count for little more.

A view is a size, an angle and a visit. Its readings, whatever they say, are worth their number to a power; a spelling
has its share of every view that read it, by how many of its readings are likely right.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import exp, log

from lpslam.config import MemoryConfig
from lpslam.language.model import Reading, Slot, Slots
from lpslam.text.reading.certainty import probability_right
from lpslam.text.types import TextObservation

View = tuple[int, int, int]
"""A visit (or a keyframe), a step of size and a step of angle."""

# Sizes of one view differ by this factor at most, and cosines of its angles by so much.
_SIZE_STEP, _ANGLE_STEP = 1.3, 0.2
# Steps of size and angle of what has no place, and what such a view is worth: its slips are mostly those of the next
# visit. Of 0.2, 0.5, 0.7 and 1 this and 1 make names of drawn lettering, held to have no place, the most probable.
_NO_VIEW, _NO_VIEW_WORTH = (-1, -1), 0.7
# Letters kept of one place: of the readings' own four, and what other views held for possible.
_KEPT_LETTERS = 6
# Spellings of views kept for one class; those that are least likely right go first.
_KEPT = 192


@dataclass(frozen=True, slots=True)
class Glance:
    """How one reading came about.

    Attributes:
        height: pixels, of the box.
        frontal: cosine of the viewing angle.
        right: probability, 0 to 1, that the reading is exactly what is painted.
        slots: the letters' runners-up.
        is_placed: whether it is known where the text stands. Beyond the depth sensor's reach and all but edge-on slips
            repeat themselves: all such readings of a visit are one view.
    """

    height: float
    frontal: float
    right: float
    slots: Slots = ()
    is_placed: bool = True


@dataclass(slots=True)
class Look:
    """One spelling in one view.

    Attributes:
        text, view: what was read, and where from.
        count: how often.
        confidence, odds: sums of the readings' confidences, and of the log odds that they are right.
        best: the largest of those.
        slots: the letters' runners-up, the mean of its readings.
    """

    text: str
    view: View
    count: int = 0
    confidence: float = 0.0
    odds: float = 0.0
    best: float = float("-inf")
    slots: Slots = ()

    @property
    def likely_right(self) -> float:
        """How many of its readings are likely right."""
        return self.count / (1.0 + exp(-self.odds / self.count))

    def add(self, confidence: float, right: float, slots: Slots = ()) -> None:
        """Note one more reading."""
        odds = log(max(right, 1e-4) / max(1.0 - right, 1e-4))
        self.count += 1
        self.confidence += confidence
        self.odds += odds
        first, second = (slots, self.slots) if odds > self.best else (self.slots, slots)
        share = 1.0 / self.count if first is slots else 1.0 - 1.0 / self.count
        self.slots = pooled(first, second, share)
        self.best = max(self.best, odds)


def pooled(first: Slots, second: Slots, share: float) -> Slots:
    """The mean of what two readings of one spelling held for possible, the first one's by its share.

    Which of two letters is painted is told by what all views held of each. Gaps are those of the first.
    """
    letters = [slot for slot in second if slot[0][0]]
    if [slot[0][0] for slot in letters] != [slot[0][0] for slot in first if slot[0][0]]:
        return first
    following = iter(letters)
    return tuple(_mean(slot, next(following), share) if slot[0][0] else slot for slot in first)


def _mean(first: Slot, second: Slot, share: float) -> Slot:
    mean: dict[str, float] = {}
    for slot, part in ((first, share), (second, 1.0 - share)):
        for letter, probability in slot:
            mean[letter] = mean.get(letter, 0.0) + part * probability
    # What was read is what every reading has for likeliest, and stays first.
    likeliest = sorted(mean.items(), key=lambda each: (each[0] != first[0][0], -each[1], each[0]))
    return tuple((letter, round(probability, 4)) for letter, probability in likeliest[:_KEPT_LETTERS])


def view_of(visit: int, height: float, frontal: float) -> View:
    """The view that a box of so many pixels, seen at such a cosine, belongs to."""
    return visit, round(log(max(height, 1.0)) / log(_SIZE_STEP)), round(frontal / _ANGLE_STEP)


def note(looks: list[Look], text: str, confidence: float, visit: int, glance: Glance) -> None:
    """Add a reading to the looks of its class."""
    view = view_of(visit, glance.height, glance.frontal) if glance.is_placed else (visit, *_NO_VIEW)
    own = next((each for each in reversed(looks) if each.view == view and each.text == text), None)
    if own is None:
        own = Look(text, view)
        looks.append(own)
    own.add(confidence, glance.right, glance.slots)
    if len(looks) > _KEPT:
        looks.remove(min(looks[:-1], key=lambda each: each.odds / each.count))


def readings_of(
    looks: Iterable[Look], config: MemoryConfig, wholes: Mapping[str, tuple[float, float]] | None = None
) -> list[Reading]:
    """The spellings as evidence, weightiest first; `wholes` are those of `wholes_of`."""
    looks = list(looks)
    in_view: dict[View, tuple[int, float]] = {}
    for each in looks:
        count, right = in_view.get(each.view, (0, 0.0))
        in_view[each.view] = count + each.count, right + each.likely_right
    by_text: dict[str, list[Look]] = {}
    for each in looks:
        by_text.setdefault(each.text, []).append(each)
    readings = []
    for text, own in by_text.items():
        shares = [_share(each, *in_view[each.view], config.repetition) for each in own]
        odds = sum(share * each.odds / each.count for share, each in zip(shares, own, strict=True)) / sum(shares)
        count = sum(each.count for each in own)
        own.sort(key=lambda each: -each.best)
        slots, told = own[0].slots, own[0].count
        for each in own[1:]:
            told += each.count
            slots = pooled(slots, each.slots, 1.0 - each.count / told)
        confidence = sum(each.confidence for each in own) / count
        whole = (wholes or {}).get(text, (1.0, 1.0))
        right = 1.0 / (1.0 + exp(-odds))
        readings.append(Reading(text, count, confidence, right, sum(shares), slots, whole))
    return sorted(readings, key=lambda each: (-(each.looks or 0.0) * (each.right or 0.0), each.text))


def _share(look: Look, count: int, right: float, repetition: float) -> float:
    """What a spelling has of its view's worth: of so many readings, so many of which are likely right."""
    worth: float = count**repetition * (_NO_VIEW_WORTH if look.view[1:] == _NO_VIEW else 1.0)
    return worth * look.likely_right / right


def wholes_of(observations: Iterable[TextObservation]) -> dict[str, tuple[float, float]]:
    """By spelling, how probably nothing more stands before and behind it, by the view that shows most."""
    wholes: dict[str, tuple[float, float]] = {}
    for each in observations:
        before, behind = each.whole or (1.0, 1.0)
        most = wholes.get(each.text, (0.0, 0.0))
        wholes[each.text] = max(before, most[0]), max(behind, most[1])
    return wholes


def looks_of(observations: Sequence[TextObservation]) -> list[Look]:
    """The looks that placed sightings are; those of one keyframe and size are one view."""
    looks: dict[tuple[str, View], Look] = {}
    for each in observations:
        view = view_of(each.keyframe, each.letter_height, 1.0)
        right = each.right
        if right is None:
            right = probability_right(each.text, each.confidence, letter_height=each.letter_height)
        looks.setdefault((each.text, view), Look(each.text, view)).add(each.confidence, right)
    return list(looks.values())
