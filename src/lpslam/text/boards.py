"""Lines of one board are one landmark: 星巴克 above STARBUCKS is one shop."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from lpslam.config import InstanceConfig
from lpslam.text.legibility import ground_difference
from lpslam.text.places import Place

Array = NDArray[np.float64]

# Two texts side by side are one line when their heights agree this well ...
_ROW_HEIGHT_RATIO = 1.6
# ... and they share this much of the lower one's height.
_ROW_SHARE = 0.6
# One above the other, they share this much of the narrower one's width.
_COLUMN_SHARE = 0.5


def boards(places: Sequence[Place], config: InstanceConfig) -> list[list[Place]]:
    """Group places into boards; the places of each in the order of reading, the boards in order of their first id."""
    pairs = [
        (first, second)
        for first in range(len(places))
        for second in range(first + 1, len(places))
        if _on_one_board(places[first], places[second], config)
    ]
    rows, columns = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(len(places), len(places)))
    count, labels = connected_components(graph, directed=False)
    groups = [[places[row] for row in np.flatnonzero(labels == label).tolist()] for label in range(count)]
    return sorted((_in_reading_order(group) for group in groups), key=lambda group: min(each.id for each in group))


def _on_one_board(first: Place, second: Place, config: InstanceConfig) -> bool:
    if np.linalg.norm(first.position - second.position) > first.width + second.width:
        return False
    offset = _offset(first, second)
    right, down, out = (abs(float(offset @ axis)) for axis in (first.baseline, first.down, first.normal))
    angle = np.degrees(np.arccos(np.clip(_facing(first, second), -1.0, 1.0)))
    first_letter, second_letter = _letter(first), _letter(second)
    ratio = max(first_letter, second_letter) / max(min(first_letter, second_letter), 1e-6)
    gap = config.line_gap * (first_letter + second_letter) / 2.0
    if out > config.line_offset or angle > config.line_angle or ratio > config.line_height_ratio:
        return False
    if not _on_one_ground(first, second, config):
        return False
    mean_height = (first.height + second.height) / 2.0
    shared_width = ((first.width + second.width) / 2.0 - right) / min(first.width, second.width)
    shared_height = (mean_height - down) / min(first.height, second.height)
    stacked = shared_width >= _COLUMN_SHARE and down - mean_height <= gap
    side_by_side = (
        shared_height >= _ROW_SHARE and ratio <= _ROW_HEIGHT_RATIO and right - (first.width + second.width) / 2.0 <= gap
    )
    return stacked or side_by_side


def _letter(place: Place) -> float:
    """Metres: a line is as high as its letters, one that runs downwards as wide."""
    return min(place.width, place.height)


def _on_one_ground(first: Place, second: Place, config: InstanceConfig) -> bool:
    """Whether the frames that saw both saw them on a ground of one colour; true where none saw both."""
    common = sorted(first.grounds_by_frame.keys() & second.grounds_by_frame.keys())
    differences = [ground_difference(first.grounds_by_frame[frame], second.grounds_by_frame[frame]) for frame in common]
    return not differences or float(np.median(differences)) <= config.line_ground_difference


def _offset(first: Place, second: Place) -> Array:
    """From the first to the second (3,) metres, as frames that saw both at once agree on it, where there are some.

    Within a frame the errors of pose and depth are common to both, so this is surer than the difference of positions.
    But a large line is read from afar and a small one from near, where the large one is cut off.
    """
    common = first.positions_by_frame.keys() & second.positions_by_frame.keys()
    if len(common) < 2:
        return second.position - first.position
    offsets = [second.positions_by_frame[frame] - first.positions_by_frame[frame] for frame in sorted(common)]
    return np.asarray(np.median(offsets, axis=0), dtype=np.float64)


def _facing(first: Place, second: Place) -> float:
    """Cosine between the normals, in the frames that saw both: of a sign with two sides, each line faces either way."""
    common = first.normals_by_frame.keys() & second.normals_by_frame.keys()
    cosines = [first.normals_by_frame[frame] @ second.normals_by_frame[frame] for frame in sorted(common)]
    return float(np.median(cosines)) if cosines else float(first.normal @ second.normal)


def _in_reading_order(group: list[Place]) -> list[Place]:
    """Sort the texts of a board into lines, top to bottom, each left to right."""
    reference = max(group, key=lambda each: (each.width * each.height, -each.id))
    across = [float((each.position - reference.position) @ reference.baseline) for each in group]
    down = [float((each.position - reference.position) @ reference.down) for each in group]
    ordered: list[list[int]] = []
    for index in sorted(range(len(group)), key=lambda each: down[each]):
        last = ordered[-1] if ordered else None
        # Still the same line while its middle lies within the height of the line's first text.
        if last is not None and down[index] - down[last[0]] < 0.5 * group[last[0]].height:
            last.append(index)
        else:
            ordered.append([index])
    return [group[index] for line in ordered for index in sorted(line, key=lambda each: across[each])]
