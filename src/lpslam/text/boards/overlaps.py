"""One painted text may have become several classes: whole, in pieces, and wrongly. One of them stays.

That two texts are one paint is said by their letters, or by boxes that are all but the same. That something larger is
read at the spot says nothing: a small line may stand within the width of a large one. And two boxes that one frame
showed apart are two paints, whatever their places seem to be.
"""

from collections import Counter, defaultdict
from collections.abc import Sequence

import numpy as np
from rapidfuzz import fuzz
from scipy.spatial import KDTree

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.text.placing.places import PLACES_OF_A_CLASS, Place, named_together
from lpslam.text.remembering.similarity import IDEOGRAPHS, comparison_key, is_fragment, similarity

# Metres within which two texts are on one surface: a text that was read wrongly is often placed worse too.
_SURFACE = 0.25
# A whole text is believed over its fragment with this share of the fragment's evidence: from near, pieces are read.
_WHOLE_OVER_FRAGMENT = 0.25
# Two boxes are the same when each covers this share of the other ...
_SAME_BOX = 0.6
# ... and two boxes of one frame are apart when they share less than this of the smaller.
_APART = 0.3
# Of a text that lies within another, in its row and of its height, this percentage of letters shows a misread piece.
_PIECE = 50.0
# Letters of one row differ in height by this factor at most, and their middles by this share of it.
_ROW_HEIGHT, _ROW_SHIFT = 1.4, 0.35
# Ratio of its sides from which a text runs along the longer one.
_LONG = 1.3


def without_overlaps(places: Sequence[Place], config: InstanceConfig, memory: MemoryConfig) -> list[Place]:
    """Of places that are one paint, keep the best founded: whole texts over their fragments, else the most evidence.

    Where some readings of a text have joined the class of another one that says the same, that says what it is called.
    """
    stand = Counter(each.id // PLACES_OF_A_CLASS for each in places)
    ordered = sorted(places, key=lambda each: (-each.evidence * len(comparison_key(each.name)), each.id))
    standing: dict[int, Place] = {}
    slips: dict[int, list[Place]] = defaultdict(list)
    for row, (place, near) in enumerate(zip(ordered, _in_reach(ordered), strict=True)):
        rivals = [each for each in near if each in standing and _are_one_paint(standing[each], place, config)]
        if stronger := [each for each in rivals if not _outranks(place, standing[each])]:
            for each in stronger:
                slips[each] += [place] if _are_alike(standing[each], place, memory) else []
            continue
        for each in rivals:
            slips[row] += [standing[each]] if _are_alike(place, standing[each], memory) else []
            del standing[each]
        standing[row] = place
    for row, others in slips.items():
        # What stands nowhere else was named by what was read here, and less often.
        elsewhere = [each for each in others if stand[each.id // PLACES_OF_A_CLASS] > 1]
        if row in standing and elsewhere:
            standing[row] = named_together(standing[row], elsewhere, memory)
    return sorted(standing.values(), key=lambda each: each.id)


def _are_alike(first: Place, second: Place, config: MemoryConfig) -> bool:
    """Whether two places have all but the same box, and names that are slips of one another, neither a piece."""
    if is_fragment(first.name, second.name) or is_fragment(second.name, first.name):
        return False
    return _have_one_box(first, second) and similarity(first.name, second.name) >= config.similarity


def _in_reach(places: Sequence[Place]) -> list[list[int]]:
    """Rows of those that may overlap each place: of any other, some side is farther away than both are wide or high."""
    if not places:
        return []
    positions = np.array([each.position for each in places])
    reach = np.array([each.width + each.height for each in places]) / 2.0
    radii = (_SURFACE + reach + reach.max()) * (1.0 + 1e-9) + 1e-9
    return [sorted(rows) for rows in KDTree(positions).query_ball_point(positions, radii)]


def _are_one_paint(first: Place, second: Place, config: InstanceConfig) -> bool:
    shared = overlap(first, second)
    if shared <= config.overlap:
        return False
    if _cross(first, second):
        return True
    part, whole = sorted((first, second), key=lambda each: len(comparison_key(each.name)))
    if comparison_key(part.name) == comparison_key(whole.name) or is_fragment(part.name, whole.name):
        return True
    if _seen_apart(first, second):
        return False
    if _have_one_box(first, second):
        return True
    alike = fuzz.partial_ratio(comparison_key(part.name), comparison_key(whole.name))
    return _in_one_row(first, second) and alike >= _PIECE


def _have_one_box(first: Place, second: Place) -> bool:
    shared, areas = overlap(first, second), sorted(each.width * each.height for each in (first, second))
    return shared >= _SAME_BOX and shared * areas[0] >= _SAME_BOX * areas[1]


def _cross(first: Place, second: Place) -> bool:
    """Whether one text runs across and the other down through it, by a character that both have: a block of columns."""
    runs_across = [each.width > _LONG * each.height for each in (first, second)]
    runs_down = [each.height > _LONG * each.width for each in (first, second)]
    is_crossed = (runs_across[0] and runs_down[1]) or (runs_down[0] and runs_across[1])
    return is_crossed and any(ch >= IDEOGRAPHS and ch in second.name for ch in first.name)


def _pitch(place: Place) -> float:
    """Metres from one character to the next."""
    return max(place.width, place.height) / max(len(comparison_key(place.name)), 1)


def _seen_apart(first: Place, second: Place) -> bool:
    """Whether a frame showed both, side by side or one above the other."""
    return any(
        _share_in_frame(first, second, frame) < _APART for frame in first.sizes_by_frame.keys() & second.sizes_by_frame
    )


def _share_in_frame(first: Place, second: Place, frame: int) -> float:
    across = second.positions_by_frame[frame] - first.positions_by_frame[frame]
    return _covered(first, across, first.sizes_by_frame[frame], second.sizes_by_frame[frame])


def _in_one_row(first: Place, second: Place) -> bool:
    letters = sorted((first.letter, second.letter))
    wide = first if first.width >= second.width else second
    axis = wide.down if wide.width >= wide.height else wide.baseline
    shift = abs(float((second.position - first.position) @ axis))
    return letters[1] <= _ROW_HEIGHT * letters[0] and shift <= _ROW_SHIFT * letters[1]


def _outranks(place: Place, rival: Place) -> bool:
    if _cross(place, rival):
        # What is nearest belongs together.
        return _pitch(place) < _pitch(rival)
    if is_fragment(rival.name, place.name):
        return place.evidence >= _WHOLE_OVER_FRAGMENT * rival.evidence
    if is_fragment(place.name, rival.name):
        return rival.evidence < _WHOLE_OVER_FRAGMENT * place.evidence
    return place.evidence > rival.evidence


def overlap(first: Place, second: Place) -> float:
    """Share of the smaller of two texts that the other covers, seen along the first's normal; 0 if not on one surface.

    Surfaces count as one within a quarter of a metre and 60 degrees.
    """
    across = second.position - first.position
    if abs(across @ first.normal) > _SURFACE or first.normal @ second.normal < 0.5:
        return 0.0
    return _covered(first, across, (first.width, first.height), (second.width, second.height))


def _covered(
    first: Place, across: np.ndarray, first_sizes: tuple[float, float], second_sizes: tuple[float, float]
) -> float:
    covered = 1.0
    for axis, first_size, second_size in zip((first.baseline, first.down), first_sizes, second_sizes, strict=True):
        shared = (first_size + second_size) / 2.0 - abs(float(across @ axis))
        covered *= float(np.clip(shared / max(min(first_size, second_size), 1e-6), 0.0, 1.0))
    return covered
