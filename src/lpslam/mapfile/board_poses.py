"""Where boards hang, as poses: for whoever draws them or tells a robot of them."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from lpslam.text.types import Landmark


def placed(landmarks: Iterable[Landmark]) -> list[Landmark]:
    """Those whose place is known in numbers."""
    return [mark for mark in landmarks if np.isfinite([*mark.position, *mark.normal, mark.spread]).all()]


def board_pose(mark: Landmark) -> NDArray[np.float64]:
    """`world_from_board`, 4×4: x out of the board towards its readers, y to their right as they read, z up."""
    ahead = np.asarray(mark.normal, np.float64)
    length = float(np.linalg.norm(ahead))
    ahead = ahead / length if length > 1e-6 else np.array([1.0, 0.0, 0.0])
    # A board that lies on the floor has no side that is up.
    up = np.array([0.0, 0.0, 1.0]) if abs(ahead[2]) < 0.99 else np.array([1.0, 0.0, 0.0])
    aside = np.cross(up, ahead)
    aside /= np.linalg.norm(aside)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2], pose[:3, 3] = ahead, aside, np.cross(ahead, aside), mark.position
    return pose


def board_size(mark: Landmark) -> NDArray[np.float64]:
    """(3,) metres along the axes of `board_pose`: a plate, and no side of it too small to be seen."""
    return np.maximum([_PLATE, mark.width, mark.height], _PLATE)


def board_colour(mark: Landmark) -> tuple[float, float, float]:
    """Red, green, blue, 0 to 1: blue for landmarks and pink for other texts once they are judged; else white."""
    if mark.is_landmark is None:
        return (1.0, 1.0, 1.0)
    return (0.15, 0.35, 0.9) if mark.is_landmark else (0.9, 0.4, 0.6)


_PLATE = 0.02
"""Metres: how thick a board is drawn."""
