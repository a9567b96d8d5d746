"""How probably two texts are lines of one board: by the ground they stand on, their gap, size, style and alignment.

The evidence is of two kinds. What *links* two neighbours is how near and how alike they are, and that no edge runs
between them. What *divides* is said by any two texts, neighbours or not: another ground, another surface, another
ink. Both add up to log odds.
"""

from dataclasses import dataclass
from math import hypot, log

import numpy as np
from numpy.typing import NDArray

from lpslam.text.boards.roles import role_by_form
from lpslam.text.boards.surroundings import REACH, Colour
from lpslam.text.placing.places import Place
from lpslam.text.reading.legibility import ground_difference, hue_difference

Array = NDArray[np.float64]

# Values beyond these tell no more: gaps in letter heights, metres, degrees, shares of a colour.
_MOST_GAP, _MOST_OUT, _MOST_ANGLE, _MOST_COLOUR = 6.0, 0.4, 90.0, 0.6
# An edge that leaves so many letter heights of the gap to another ground is no slip of the boxes.
_SURE_EDGE = 0.5
# Metres and degrees by which surfaces of one board hardly ever differ: twice as much tells four times as much.
_OUT, _ANGLE = 0.1, 30.0
# A ground that goes on for this share of what is looked at goes on.
_ALL_CLEAR = 0.97
# A frame that saw less than this share of a text's longer side saw a part of it.
_WHOLE = 0.85
# Two names of one size, by the log of the ratio of their letters: surely up to the first, and from the second on not.
_ONE_SIZE = (0.3, 0.45)
# Their grounds, in shares of what is brightest: light and glow make 0.22 at most. Inks that differ more are not one.
_UNLIKE, _ONE_INK = (0.24, 0.29), 0.3
# Log of the ratio of its sides from which a text runs along the longer one.
_RUNS = 0.22
# Letter heights by which an edge must lie nearer than the other text: boxes are somewhat larger than their letters.
_EDGE_MARGIN = 0.15


@dataclass(frozen=True, slots=True)
class Kinship:
    """What two texts have in common.

    Attributes:
        stacked: whether one stands above the other, rather than beside it.
        gap: between their boxes, in letter heights (the mean of the two).
        apart: how far they stand out of one line or one column, in letter heights: edges and middles are compared.
        size: log of the ratio of their letter heights, not negative.
        edge: letter heights of the gap that lie beyond an edge of the ground of both; 0 where none runs between.
        hue, shade: difference of the grounds' colours, made equally bright and as they are; 0 where not known.
        ink: difference of the letters' colours.
        sheets: 0 to 1, how surely two names of one size and one ink stand on unlike grounds.
        crossing: 0 to 1, how surely of two names of one size one runs across and the other down.
        out: metres between their surfaces.
        unsure: metres, standard deviation of that: texts without depth of their own may be some way off.
        angle: degrees between their normals.
        steps: metres by which one lies right of and below the other, in the larger one's directions.
    """

    stacked: bool
    gap: float
    apart: float
    size: float
    edge: float
    hue: float
    shade: float
    ink: float
    sheets: float
    crossing: float
    out: float
    unsure: float
    angle: float
    steps: tuple[float, float]

    @property
    def link(self) -> float:
        """Log odds by what only neighbours tell."""
        return (
            LINK.bias
            + LINK.stacked * self.stacked
            + LINK.gap * log(1.0 + self.gap)
            + LINK.apart * log(1.0 + self.apart)
            + LINK.size * self.size
            + LINK.edge * min(self.edge / _SURE_EDGE, 1.0)
        )

    @property
    def divide(self) -> float:
        """Log odds by what any two texts tell."""
        colours = DIVIDE.hue * self.hue + DIVIDE.shade * self.shade + DIVIDE.ink * self.ink
        out = self.out**2 / (_OUT**2 + self.unsure**2)
        return colours + DIVIDE.out * out + DIVIDE.angle * (self.angle / _ANGLE) ** 2

    @property
    def names_apart(self) -> float:
        """Log odds by what only the largest lines of two groups tell."""
        return SHEETS * self.sheets + CROSSING * self.crossing


@dataclass(frozen=True, slots=True)
class Link:
    """Weights of what links neighbours, in log odds; fitted to drawn streets."""

    bias: float = 5.2
    stacked: float = 0.4
    gap: float = -4.4
    apart: float = -0.8
    size: float = -0.2
    edge: float = -5.0


@dataclass(frozen=True, slots=True)
class Divide:
    """Weights of what divides any two texts, in log odds; fitted to drawn streets."""

    hue: float = -6.5
    shade: float = -3.5
    ink: float = -0.6
    out: float = -1.2
    angle: float = -2.0


LINK, DIVIDE = Link(), Divide()

SHEETS = -6.0
"""Log odds for one board where the largest lines of two groups are surely names of two sheets: more than what touches
has for it. Of 326 pairs of like size in drawn streets, photographs and the coffee bar it parts no board."""

CROSSING = -4.0
"""Log odds for one board where the largest lines of two groups are of one size, and one runs down and the other across.
Of 58 such pairs of drawn streets and of other authors' three are of one board, of 632 that run alike 349."""

CONTACT_ALONE = 1.5
"""Log odds for one board where one of two groups is nothing but contacts, fitted to drawn streets: nobody hangs up a
telephone number, hours or an address without a name."""


def kinship(first: Place, second: Place) -> Kinship:
    """Compare two texts."""
    if first.width * first.height < second.width * second.height:
        first, second = second, first
    offset = _offset(first, second)
    right, down, out = (float(offset @ axis) for axis in (first.baseline, first.down, first.normal))
    letter = (first.letter + second.letter) / 2.0
    across, along = _free(right, first.width, second.width), _free(down, first.height, second.height)
    stacked = along >= across
    gap = hypot(max(across, 0.0), max(along, 0.0))
    sizes = (right, first.width, second.width) if stacked else (down, first.height, second.height)
    hue, shade, ink = _colours(first, second)
    size = abs(log(max(first.letter, 1e-6) / max(second.letter, 1e-6)))
    return Kinship(
        stacked=stacked,
        gap=min(gap / letter, _MOST_GAP),
        apart=min(out_of_line(*sizes) / letter, _MOST_GAP),
        size=size,
        edge=_edge(first, second, (right, down), stacked, gap) / letter,
        hue=hue,
        shade=shade,
        ink=ink,
        sheets=_sheets(first, second),
        crossing=_crossing(first, second, size),
        out=min(abs(out), _MOST_OUT),
        unsure=hypot(first.uncertainty, second.uncertainty),
        angle=min(float(np.degrees(np.arccos(np.clip(_facing(first, second), -1.0, 1.0)))), _MOST_ANGLE),
        steps=(right, down),
    )


def _free(offset: float, first: float, second: float) -> float:
    return abs(offset) - (first + second) / 2.0


def out_of_line(offset: float, first: float, second: float) -> float:
    """Metres by which two stretches fail to begin, end or have their middles together, whichever is least."""
    half = (first - second) / 2.0
    return min(abs(offset), abs(offset + half), abs(offset - half))


def _edge(first: Place, second: Place, steps: tuple[float, float], stacked: bool, gap: float) -> float:
    """Metres of the gap beyond the nearest edge, where the grounds of both end before the other text begins."""
    if first.clear is None or second.clear is None or gap <= 0.0:
        return 0.0
    towards = (0 if steps[1] < 0 else 2) if stacked else (3 if steps[0] < 0 else 1)
    beyond = []
    for place, side in ((first, towards), (second, (towards + 2) % 4)):
        share = float(place.clear[side])  # type: ignore[index]
        reach = share * place.letter if share < _ALL_CLEAR * REACH else gap
        beyond.append(gap - reach - _EDGE_MARGIN * place.letter)
    return max(0.0, min(beyond))


def _colours(first: Place, second: Place) -> tuple[float, float, float]:
    """Differences of the grounds' hue and shade, and of the inks' shade; 0 where nobody knows.

    In frames that saw both where there are some: light is the same in these. Of thick letters the ink may be taken for
    the ground, so two texts of the same two colours are on one ground.
    """
    pairs = [(place.grounds_by_frame, place.inks_by_frame or place.grounds_by_frame) for place in (first, second)]
    (grounds, inks), (other_grounds, other_inks) = pairs
    told = (grounds, other_grounds, inks, other_inks)
    frames = sorted(set.intersection(*(set(each) for each in told)))
    if frames:
        seen = [[each[frame] for each in told] for frame in frames]
    elif grounds and other_grounds:
        seen = [[_median(each) for each in told]]
    else:
        return 0.0, 0.0, 0.0

    def differ(a: int, b: int) -> tuple[float, float]:
        hue = float(np.median([hue_difference(each[a], each[b]) for each in seen]))
        return min(hue, _MOST_COLOUR), min(
            float(np.median([ground_difference(each[a], each[b]) for each in seen])), _MOST_COLOUR
        )

    swapped = tuple(map(max, differ(0, 3), differ(2, 1)))
    (hue, shade), (_, ink) = differ(0, 1), differ(2, 3)
    if sum(swapped) < hue + shade:
        (hue, shade), ink = swapped, swapped[1]
    return hue, shade, ink


def _sheets(first: Place, second: Place) -> float:
    """How surely, 0 to 1, two names are those of two sheets: as large as each other, in like ink, on unlike grounds.

    A board that has grounds of two colours has lines of two sizes on them, or prices and ways to reach someone. Only
    frames that saw both tell: light, and how boxes stray, are the same in these.
    """
    told = (first.bare_by_frame, second.bare_by_frame, first.inks_by_frame, second.inks_by_frame)
    frames = sorted(set.intersection(*map(set, told)))
    if not frames or role_by_form(first.name) or role_by_form(second.name):
        return 0.0
    seen = np.array([[colours[each] for each in frames] for colours in told])
    differ = np.abs(seen[::2] - seen[1::2]).max(axis=2) / np.maximum(seen.max(axis=(0, 2)), 1.0)
    ground, ink = np.median(differ, axis=1)
    # Of blurred letters ink and ground are taken for each other: then they differ in opposite ways.
    is_dark = np.median((seen[:2] - seen[2:]).sum(axis=2), axis=1) < 0.0
    if ink > _ONE_INK or is_dark[0] != is_dark[1]:
        return 0.0
    letters = [[min(place.sizes_by_frame.get(each, (place.letter,))) for each in frames] for place in (first, second)]
    size = abs(np.median(np.diff(np.log(np.maximum(letters, 1e-6)), axis=0)))
    return float(np.interp(ground, _UNLIKE, (0.0, 1.0)) * np.interp(size, _ONE_SIZE, (1.0, 0.0)))


def _crossing(first: Place, second: Place, size: float) -> float:
    """How surely, 0 to 1, of two names of one size one runs across and the other down."""
    runs = [log(max(each.height, 1e-6) / max(each.width, 1e-6)) for each in (first, second)]
    if runs[0] * runs[1] >= 0.0 or min(map(abs, runs)) < _RUNS or role_by_form(first.name) or role_by_form(second.name):
        return 0.0
    return float(np.interp(size, _ONE_SIZE, (1.0, 0.0)))


def _median(colours: dict[int, Colour]) -> Colour:
    red, green, blue = np.median(list(colours.values()), axis=0)
    return int(red), int(green), int(blue)


def _offset(first: Place, second: Place) -> Array:
    """From the first to the second (3,) metres, as frames that saw both at once agree on it, where there are some.

    Within a frame the errors of pose and depth are common to both, so this is surer than the difference of positions.
    But a large line is read from afar and a small one from near, where the large one is cut off: the middle of what is
    left is not its middle.
    """
    common = _whole_frames(first) & _whole_frames(second)
    if len(common) < 2:
        return second.position - first.position
    offsets = [second.positions_by_frame[frame] - first.positions_by_frame[frame] for frame in sorted(common)]
    return np.asarray(np.median(offsets, axis=0), dtype=np.float64)


def _whole_frames(place: Place) -> set[int]:
    """Frames that saw a text about as wide and high as it is, or of which no size is known."""
    longer = max(place.width, place.height)
    sizes = place.sizes_by_frame
    return {each for each in place.positions_by_frame if each not in sizes or max(sizes[each]) >= _WHOLE * longer}


def _facing(first: Place, second: Place) -> float:
    """Cosine between the normals, in the frames that saw both: of a sign with two sides, each line faces either way."""
    common = first.normals_by_frame.keys() & second.normals_by_frame.keys()
    cosines = [first.normals_by_frame[frame] @ second.normals_by_frame[frame] for frame in sorted(common)]
    return float(np.median(cosines)) if cosines else float(first.normal @ second.normal)
