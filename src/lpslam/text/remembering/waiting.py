"""Texts that the end of the view cuts off wait for the rest (paper, Fig. 11); if it never comes, they are all there is.

Of a text that an image's border or something nearer cuts, a reading shows a part, and other views cut it elsewhere: its
end moves with the view. The longest spelling that was read again is all of it where both of its ends stay where they
are, and at each of them the view went on or a word ends; else there is more that nobody saw. A text that was read as
a whole needs none.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.text.placing.spots import in_world
from lpslam.text.remembering.ends import ends_as_words_do, says_little
from lpslam.text.remembering.evidence import Glance
from lpslam.text.remembering.similarity import comparison_key, is_fragment, similarity
from lpslam.text.types import Placement, SpottedText, TextObservation

Array = NDArray[np.float64]

_TWICE = 1.5
"""Sum of the probabilities that readings of a spelling, or slips of it, are right from which it was read again."""

_SLIPS = 0.75
"""Eq. 3 similarity from which another spelling of no more letters is a slip of the longest one, and no part of it."""

_SHORTER = 0.25
"""What a spelling that lacks letters of the longest one is worth: it was seen, and is hardly all that is painted."""

_LETTERS = 2
"""Different letters that a part must have: the piece of a frieze that is in view looks like one letter, repeated."""

_LONGER = 0.5
"""Probability that a reading is right from which its letters beyond a spelling were seen, and so are no slip."""

_STRAY, _STRAY_SHARE = 0.15, 0.01
"""Letter heights, and shares of the length, by which a detected end that stays strays at most from the farthest."""

_STAYS = 1.0 / 3.0
"""Share of the readings of a spelling that reach so far where its end stays. Where it moves, it passes a letter's width
of about 0.65 heights while the same is read: a quarter of them do."""

_IN_VIEW = 0.1
"""Letter heights by which the view must go on beyond an end, in two readings, for it to be the text that ends there and
not the view: a camera that stands still sees the same end again and again. Boxes are grown by about as much."""

_ACROSS = 0.6
"""Share of the higher text's height within which parts stand on one line."""

_CAPACITY = 256
"""Readings kept of one text; then those that are least likely right go."""


@dataclass(frozen=True, slots=True, eq=False)
class CutText:
    """One reading of a text that may go on where the view ends.

    Attributes:
        text, placement, glance, observation: as of any other reading.
        world_from_keyframe: 4×4, when it was read.
        room: letter heights of the image before and behind its box.
    """

    text: SpottedText
    placement: Placement
    glance: Glance
    observation: TextObservation
    world_from_keyframe: Array
    room: tuple[float, float]


@dataclass(slots=True)
class _Line:
    """What was read of one text: where its last readings stood, and all of them."""

    last_seen: float
    cuts: list[CutText] = field(default_factory=list)

    def holds(self, cut: CutText) -> bool:
        return any(_overlap(cut, each) for each in self.cuts[-3:])


class WaitingTexts:
    """Cut readings by where they stand, until what they are parts of has gone out of view."""

    def __init__(self, patience: float) -> None:
        self._patience = patience
        self._lines: list[_Line] = []

    def add(self, cut: CutText) -> int:
        """Keep a reading; returns how often the same was read there."""
        timestamp = cut.observation.timestamp
        line = next((each for each in self._lines if each.holds(cut)), None)
        if line is None:
            line = _Line(timestamp)
            self._lines.append(line)
        line.last_seen = timestamp
        line.cuts.append(cut)
        if len(line.cuts) > _CAPACITY:
            line.cuts.remove(min(line.cuts, key=lambda each: each.glance.right))
        key = comparison_key(cut.text.text)
        return sum(comparison_key(each.text.text) == key for each in line.cuts)

    def gone(
        self,
        timestamp: float | None,
        names_at: Callable[[Placement, Array], list[str]],
        is_remembered: Callable[[str], bool] = lambda text: False,
    ) -> list[list[CutText]]:
        """Give up, text by text, the readings of what has gone out of view and is known by nothing better.

        Args:
            timestamp: seconds, now; None at the end, when all has.
            names_at: what texts that were read as a whole say where a reading stands.
            is_remembered: whether a text in memory says nearly the same: then it need not be the whole of it.
        """
        gone = [each for each in self._lines if timestamp is None or timestamp - each.last_seen > self._patience]
        self._lines = [each for each in self._lines if each not in gone]
        found = (_longest(each.cuts, is_remembered) for each in gone)
        return [cuts for cuts in found if cuts and not _is_told(cuts, names_at)]


def _longest(cuts: list[CutText], is_remembered: Callable[[str], bool]) -> list[CutText]:
    """The readings of the longest spelling and its slips, in order of time; none where it goes on, or was read once."""
    keys = [comparison_key(each.text.text) for each in cuts]
    weights: dict[str, float] = defaultdict(float)
    for key in set(keys):
        for other, cut in zip(keys, cuts, strict=True):
            is_slip = len(other) >= len(key) and similarity(key, other) >= _SLIPS
            weights[key] += cut.glance.right if is_slip else 0.0
    sure = [key for key, weight in weights.items() if weight >= _TWICE and len(set(key)) >= min(len(key), _LETTERS)]
    if not sure:
        return []
    longest = max(sure, key=lambda key: (len(key), weights[key]))
    whole = [each for key, each in zip(keys, cuts, strict=True) if key == longest]
    longer = [
        each for key, each in zip(keys, cuts, strict=True) if len(key) > len(longest) and each.glance.right >= _LONGER
    ]
    if longer and _reach_beyond(longer, whole):
        return []
    alike = [(key, each) for key, each in zip(keys, cuts, strict=True) if similarity(key, longest) >= _SLIPS]
    is_enough = not says_little(longest) and is_remembered(longest)
    if not _has_ends([each for key, each in alike if len(key) >= len(longest)], says_little(longest), is_enough):
        return []
    return [
        cut if len(key) >= len(longest) else replace(cut, glance=replace(cut.glance, right=_SHORTER * cut.glance.right))
        for key, cut in alike
    ]


def _has_ends(cuts: list[CutText], is_piece: bool, is_enough: bool) -> bool:
    """Whether both ends of a text stay where they are, and the view went on beyond them or a word ends there.

    What is cut ends where the view does: while a camera hardly moves, that end stays as well.
    """
    in_view = np.array([each.room for each in cuts]) >= _IN_VIEW
    are_words = np.array([not is_piece and each.glance.right >= _LONGER for each in cuts])[:, None] & np.array(
        [ends_as_words_do(each.text.text) for each in cuts]
    )
    reaches, stray = _reaches(cuts, cuts[0])
    for ends, is_seen, is_word in zip(reaches, in_view.T, are_words.T, strict=True):
        there = ends >= ends.max() - stray
        if np.count_nonzero(there) < max(2.0, _STAYS * len(cuts)):
            return False
        if not is_enough and np.count_nonzero(there & is_seen) < 2 and not (there & is_word).any():
            return False
    return True


def _reach_beyond(longer: list[CutText], cuts: list[CutText]) -> bool:
    """Whether a longer spelling was read beyond the ends of a text, and not of what its readings show as well."""
    own, stray = _reaches(cuts, cuts[0])
    theirs, _ = _reaches(longer, cuts[0])
    return bool((theirs > own.max(axis=1, keepdims=True) + stray).any())


def _reaches(cuts: list[CutText], of: CutText) -> tuple[Array, float]:
    """How far n readings reach from the middle of one, to its begin and to its end, (2, n) metres; and their stray."""
    origin, baseline, _ = in_world(of.placement, of.world_from_keyframe)
    middles = np.array([(in_world(each.placement, each.world_from_keyframe)[0] - origin) @ baseline for each in cuts])
    widths = np.array([each.placement.width for each in cuts])
    heights = np.array([each.placement.height for each in cuts])
    stray = _STRAY * float(np.median(heights)) + _STRAY_SHARE * float(np.median(widths))
    return np.array([widths / 2.0 - middles, middles + widths / 2.0]), stray


def _is_told(cuts: list[CutText], names_at: Callable[[Placement, Array], list[str]]) -> bool:
    """Whether what stands there was read as a whole: no less than these readings say."""
    spellings = [each.text.text for each in cuts]
    longest = max(spellings, key=lambda text: (spellings.count(text), len(text)))
    names = {name for each in cuts for name in names_at(each.placement, each.world_from_keyframe)}
    return any(not is_fragment(name, longest) for name in names)


def _overlap(one: CutText, other: CutText) -> bool:
    """Whether two readings stand on one line, one beside or over the other."""
    position, baseline, normal = in_world(one.placement, one.world_from_keyframe)
    there, _, facing = in_world(other.placement, other.world_from_keyframe)
    offset = there - position
    along = float(offset @ baseline)
    across = float(np.linalg.norm(offset - along * baseline))
    is_beside = abs(along) < 0.5 * (one.placement.width + other.placement.width)
    on_line = across < _ACROSS * max(one.placement.height, other.placement.height)
    return bool(is_beside and on_line and normal @ facing > 0.0)
