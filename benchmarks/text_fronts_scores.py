"""What a map's landmarks make of shop fronts: names, lines, roles, merged and split boards, inventions."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from rapidfuzz import fuzz

from lpslam.camera import transform_points
from lpslam.config import EvaluationConfig
from lpslam.evaluation.signs import TrueLine, TrueSign
from lpslam.simulation.boards.street import Distractor
from lpslam.text.remembering.similarity import comparison_key, similarity
from lpslam.text.types import Landmark, LandmarkLine
from text_rows import RowLine, likenesses

Array = NDArray[np.float64]
BESIDE = 0.35  # metres beside a board's ink at which a landmark is still its own: half of a shop's margin and more
BEFORE = 0.5  # metres before or behind its face: what depth from the wall around it is off by
ON_ORNAMENT = 0.15  # metres beside an ornament
NEIGHBOUR = 2.5  # metres between a landmark and the boards that it may have merged: one board and a half
SHORTEST = 3  # letters of a line that tell a merged board: shorter ones are in other words by chance
MISREAD = 0.5  # similarity from which a landmark on a board is a line of it, misread
Fate = Literal["real", "merged", "misread", "misplaced", "ornament", "invented"]


@dataclass(frozen=True)
class Judged:
    """One landmark.

    Attributes:
        mark: the landmark.
        fate: what it is.
        sign: whose line or lines it says, or the nearest; None without signs.
        lines: those that it says, with all its own.
        named: those that its name says.
        stray: how many of its own lines say none of the sign's.
        roles: what it takes each of the sign's lines for that one of its own says, and what that is.
        distance: metres from the middle of these, or from the sign's middle.
        merged: the signs whose lines it says together, if there are several.
    """

    mark: Landmark
    fate: Fate
    sign: TrueSign | None
    lines: tuple[TrueLine, ...]
    distance: float = 0.0
    named: tuple[TrueLine, ...] = ()
    stray: int = 0
    roles: tuple[tuple[str, str], ...] = ()
    merged: tuple[TrueSign, ...] = ()

    def is_of(self, sign: TrueSign) -> bool:
        """Whether it comes of a sign."""
        return sign is self.sign or any(sign is each for each in self.merged)


@dataclass
class SignScore:
    """One sign and the landmarks that are its."""

    sign: TrueSign
    expected: bool
    marks: list[Judged] = field(default_factory=list)
    merged: bool = False

    @property
    def name_marks(self) -> list[Judged]:
        """Landmarks that say its name."""
        return [each for each in self.marks if self.sign.lines[0] in each.lines]

    @property
    def found(self) -> bool:
        """Whether its name is in the map where it hangs."""
        return bool(self.name_marks)

    @property
    def called(self) -> bool:
        """Whether a landmark is called by its name, rather than having it as one of its lines."""
        return any(self.sign.lines[0] in each.named for each in self.marks)

    @property
    def exact(self) -> bool:
        """Whether it is so to the letter, but for case, spaces and marks."""
        key = comparison_key(self.sign.text)
        texts = [text for each in self.name_marks for text in texts_of(each.mark)]
        return any(key in comparison_key(text) for text in texts)

    @property
    def split(self) -> bool:
        """Whether different lines of it are different landmarks."""
        return len({each.lines for each in self.marks}) > 1

    @property
    def doubles(self) -> int:
        """Landmarks too many that say the same lines."""
        return sum(count - 1 for count in Counter(each.lines for each in self.marks).values())

    def expected_lines(self, frames: int) -> list[TrueLine]:
        """Those that could be read for so many frames."""
        return [line for line in self.sign.lines if (line.readable_frames or 0) >= frames]

    def said(self, line: TrueLine) -> bool:
        """Whether a landmark says a line."""
        return any(line in each.lines for each in self.marks)


def judge(
    marks: Sequence[Landmark],
    signs: Sequence[TrueSign],
    distractors: Sequence[Distractor],
    truth_from_map: Array,
    config: EvaluationConfig,
) -> tuple[list[Judged], list[SignScore]]:
    """Say what every landmark is, and what became of every sign."""
    scores = [SignScore(sign, (sign.readable_frames or 0) >= config.readable_frames) for sign in signs]
    judged = []
    for mark in marks:
        place = transform_points(truth_from_map, mark.position[None])[0]
        one = _judge_one(mark, place, scores, distractors, config.name_similarity)
        judged.append(one)
        if one.fate == "real":
            next(each for each in scores if each.sign is one.sign).marks.append(one)
    return judged, scores


def stated_and_exact(
    marks: Sequence[Landmark], signs: Sequence[TrueSign], truth_from_map: Array
) -> list[tuple[float, bool]]:
    """How surely every line is said to be exact, and whether a line, or a row, of its board is just so."""
    stated = []
    for mark in marks:
        places = [transform_points(truth_from_map, line.position[None])[0] for line in mark.lines]
        exact = [False] * len(places)
        for sign in signs:
            on = [row for row, place in enumerate(places) if _is_on(sign, place)]
            said = [_row_line(sign, mark.lines[row], places[row]) for row in on]
            painted = [_row_line(sign, true, np.array(true.centre)) for true in sign.lines]
            for row, like in zip(on, likenesses(said, painted, np.inf), strict=True):
                exact[row] |= like >= 1.0
        stated += [(line.confidence, one) for line, one in zip(mark.lines, exact, strict=True)]
    return stated


def _row_line(sign: TrueSign, line: TrueLine | LandmarkLine, place: Array) -> RowLine:
    return RowLine(line.text, _local(sign, place), min(line.width, line.height))


def pictures_of(marks: Sequence[Landmark], signs: Sequence[TrueSign], truth_from_map: Array) -> list[str]:
    """On which board every line of `stated_and_exact` stands: the file of its picture, or nothing."""
    places = [transform_points(truth_from_map, line.position[None])[0] for mark in marks for line in mark.lines]
    on = [[sign for sign in signs if _is_on(sign, place)] for place in places]
    return [each[0].features.get("file", str(each[0].id)) if each else "" for each in on]


def _judge_one(
    mark: Landmark, place: Array, scores: Sequence[SignScore], distractors: Sequence[Distractor], like: float
) -> Judged:
    near = [each for each in scores if _is_on(each.sign, place)]
    told = {id(each): [_told(text, each.sign.lines, like) for text in texts_of(mark)] for each in near}
    for each in sorted(near, key=lambda each: -sum(map(bool, told[id(each)]))):
        named = _told(mark.name, each.sign.lines, like)
        if not named:
            continue
        others = [other for other in near if other is not each and _has_more(told[id(other)], told[id(each)])]
        if others:
            for one in (each, *others):
                one.merged = True
            signs = tuple(one.sign for one in (each, *others))
            return Judged(mark, "merged", each.sign, named, 0.0, named, merged=signs)
        return _real(mark, place, each.sign, told[id(each)], named)
    said = {id(each): lines_said(mark.name, each.sign.lines, like) for each in near}
    around = [each for each in scores if np.linalg.norm(_local(each.sign, place)) <= NEIGHBOUR]
    speaking = [each for each in around if _long(lines_said(mark.name, each.sign.lines, like))]
    if len(speaking) > 1:
        for each in speaking:
            each.merged = True
        signs = tuple(each.sign for each in speaking)
        return Judged(mark, "merged", signs[0], lines_said(mark.name, signs[0].lines, like), merged=signs)
    for each in scores:
        lines = _told(mark.name, each.sign.lines, like)
        if each not in near and lines:
            return Judged(mark, "misplaced", each.sign, lines, _distance(each.sign, lines, place))
    likest = max(near, key=lambda each: _likeness(mark.name, each.sign), default=None)
    if likest is not None and (said[id(likest)] or _likeness(mark.name, likest.sign) >= MISREAD):
        return Judged(mark, "misread", likest.sign, said[id(likest)])
    closest = min(scores, key=lambda each: float(np.linalg.norm(np.array(each.sign.centre) - place)), default=None)
    on_board = any(_is_on(each.sign, place, 0.0) for each in near)
    fate: Fate = "ornament" if not on_board and any(_is_ornament(each, place) for each in distractors) else "invented"
    return Judged(mark, fate, closest.sign if closest else None, ())


def alike(first: str, second: str) -> float:
    """Eq. 3 similarity but for case and spaces."""
    return similarity(comparison_key(first), comparison_key(second))


def texts_of(mark: Landmark) -> list[str]:
    """All that a landmark says, line by line."""
    return [line.text for line in mark.lines] or [mark.name]


def _told(text: str, lines: Sequence[TrueLine], like: float) -> tuple[TrueLine, ...]:
    """The lines that a text says, if it says no more than these."""
    said = lines_said(text, lines, like)
    whole = max(lines, key=lambda line: similarity(comparison_key(text), comparison_key(line.text)), default=None)
    if whole is not None and similarity(comparison_key(text), comparison_key(whole.text)) >= like:
        # A word of the name may be a line of its own: Norah's Ironmongers, IRONMONGERS.
        return (whole,)
    return said if said and similarity(text, " ".join(line.text for line in said)) >= like else ()


def _has_more(other: Sequence[tuple[TrueLine, ...]], own: Sequence[tuple[TrueLine, ...]]) -> bool:
    """Whether a line of a landmark is another sign's and not this one's."""
    return any(theirs and not ours for theirs, ours in zip(other, own, strict=True))


def _real(
    mark: Landmark,
    place: Array,
    sign: TrueSign,
    told: Sequence[tuple[TrueLine, ...]],
    named: tuple[TrueLine, ...],
) -> Judged:
    lines = tuple(line for line in sign.lines if any(line in each for each in told))
    roles = [
        (own.role, each[0].role)
        for own, each in zip(mark.lines, told, strict=bool(mark.lines))
        if len(each) == 1 and each[0].role
    ]
    stray = sum(not each for each in told)
    return Judged(mark, "real", sign, lines, _distance(sign, lines, place), named, stray, tuple(roles))


def lines_said(name: str, lines: Sequence[TrueLine], like: float) -> tuple[TrueLine, ...]:
    """The lines that a name has in it, in the order in which it says them."""
    key, found = comparison_key(name), []
    for line in lines:
        wanted = comparison_key(line.text)
        if not wanted or len(key) < like * len(wanted):
            continue
        if len(wanted) <= 2 or len(key) <= len(wanted):
            start, is_in = key.find(wanted), (wanted in key or alike(name, line.text) >= like)
        else:
            part = fuzz.partial_ratio_alignment(wanted, key)
            start = part.dest_start if part else 0
            is_in = part is not None and similarity(wanted, key[start : part.dest_end]) >= like
        if is_in:
            found.append((start, line))
    return tuple(line for _, line in sorted(found, key=lambda each: each[0]))


def explained(name: str, lines: Sequence[TrueLine], like: float) -> tuple[TrueLine, ...]:
    """Of lines that a name has in it, those that are all of it: all together, else the one that is likest."""
    whole = tuple(lines)
    choices = [whole, *((line,) for line in lines)]
    best = max(choices, key=lambda some: alike(name, " ".join(line.text for line in some)))
    return best if best and alike(name, " ".join(line.text for line in best)) >= like else ()


def _long(lines: Sequence[TrueLine]) -> bool:
    return any(len(comparison_key(line.text)) >= SHORTEST for line in lines)


def _likeness(name: str, sign: TrueSign) -> float:
    return max(alike(name, each) for each in (*sign.names, *(line.text for line in sign.lines)))


def _distance(sign: TrueSign, lines: Sequence[TrueLine], place: Array) -> float:
    reach = [_local(sign, np.array(line.centre)) for line in lines]
    halves = np.array([[line.width / 2, line.height / 2, 0.0] for line in lines])
    middle = ((np.array(reach) - halves).min(axis=0) + (np.array(reach) + halves).max(axis=0)) / 2
    return float(np.linalg.norm(_local(sign, place) - middle))


def _local(sign: TrueSign, place: Array) -> Array:
    """To the right, up and out of a sign's face, metres from its name's middle."""
    normal = np.array(sign.normal if sign.normal is not None else (0.0, -1.0, 0.0))
    right = np.cross([0.0, 0.0, 1.0], normal)
    return np.array([right, [0.0, 0.0, 1.0], normal]) @ (place - np.array(sign.centre))


def _is_on(sign: TrueSign, place: Array, beside: float = BESIDE) -> bool:
    x, y, out = _local(sign, place)
    lefts, tops = [], []
    for line in sign.lines:
        u, v, _ = _local(sign, np.array(line.centre))
        lefts += [u - line.width / 2, u + line.width / 2]
        tops += [v - line.height / 2, v + line.height / 2]
    inside = min(lefts) - beside <= x <= max(lefts) + beside and min(tops) - beside <= y <= max(tops) + beside
    return bool(inside and abs(out) <= BEFORE)


def _is_ornament(each: Distractor, place: Array) -> bool:
    low, high = each.corners.min(axis=0) - ON_ORNAMENT, each.corners.max(axis=0) + ON_ORNAMENT
    low[1], high[1] = low[1] - BEFORE, high[1] + BEFORE
    return bool(((place >= low) & (place <= high)).all())
