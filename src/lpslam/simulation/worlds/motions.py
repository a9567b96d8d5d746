"""How a camera is moved along a route: by hand, on wheels, on legs, put down, in a bag."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from lpslam.simulation.worlds.places.place import Route, Solids
from lpslam.simulation.worlds.shaking import Moves, moves_of

STEP = 1.0 / 240.0  # seconds between the computed poses
LEAD = 0.2  # seconds computed before the first frame and after the last
CLEARANCE = 0.12  # metres that a camera keeps from everything
GAZE_SMOOTHING = 0.3  # seconds

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Where the camera is at every instant.

    Attributes:
        positions: (n, 3) metres, one a step from `LEAD` before time zero.
        angles: (n, 3) heading, pitch (up positive), roll; radians.
        cover: (n,) 0 to 1, how much of the view is covered.
    """

    positions: Array
    angles: Array
    cover: Array

    def poses(self, times: Array) -> Array:
        """(m, 4, 4) world from camera, of the optical frame, at (m,) seconds."""
        place = np.clip((np.asarray(times) + LEAD) / STEP, 0, len(self.positions) - 1.001)
        index = place.astype(np.int64)
        share = (place - index)[:, None]
        position = self.positions[index] * (1 - share) + self.positions[index + 1] * share
        angle = self.angles[index] * (1 - share) + self.angles[index + 1] * share
        return _poses(position, angle)

    def covered(self, times: Array) -> Array:
        """(m,) 0 to 1 at (m,) seconds."""
        return np.interp(times, np.arange(len(self.cover)) * STEP - LEAD, self.cover)


def _poses(positions: Array, angles: Array) -> Array:
    (heading, pitch, roll), zero = angles.T, np.zeros(len(angles))
    forward = np.column_stack([np.cos(heading) * np.cos(pitch), np.sin(heading) * np.cos(pitch), np.sin(pitch)])
    right = np.column_stack([np.sin(heading), -np.cos(heading), zero])
    down = np.cross(forward, right)
    cosine, sine = np.cos(roll)[:, None], np.sin(roll)[:, None]
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 0] = cosine * right + sine * down
    poses[:, :3, 1] = -sine * right + cosine * down
    poses[:, :3, 2] = forward
    poses[:, :3, 3] = positions
    return poses


def move(kind: str, seed: int, visit: int, route: Route, solids: Solids, seconds: float) -> Trajectory:
    """Move a camera along a route.

    Args:
        kind: the factor's value.
        seed, visit: decide pace, height, start and shaking; another visit begins elsewhere, at another height.
        route, solids: of the place; what would come too near to a solid is done with less swing.
        seconds: length.
    """
    rng = np.random.default_rng([seed, 107, visit])
    count = int(np.ceil((seconds + 2 * LEAD) / STEP)) + 2
    moves = moves_of(kind, rng, count, STEP, route.pace)
    start = float(rng.uniform(0, 1))
    height = float(rng.uniform(-0.06, 0.06)) if not visit else float(rng.choice([-0.15, 0.15]))
    for swing in (1.0, 0.7, 0.45, 0.25, 0.1, 0.0):
        trajectory = _follow(route, moves, start, height, swing, is_robot=kind == "robot")
        if solids.clearance(trajectory.positions[::6]).min() > CLEARANCE:
            break
    return trajectory


def _follow(route: Route, moves: Moves, start: float, height: float, swing: float, *, is_robot: bool) -> Trajectory:
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route.points, axis=0), axis=1))])
    around = float(lengths[-1])
    travelled = start * around + np.cumsum(moves.speed) * STEP
    if route.is_closed:
        place = np.mod(travelled, around)
    else:
        fold = np.mod(travelled, 2 * around)
        place = gaussian_filter1d(np.where(fold < around, fold, 2 * around - fold), 0.3 / STEP, mode="nearest")
    position = _at(route.points, lengths, place)
    position[:, 2] += height * swing
    if is_robot:
        position[:, 2] = route.robot_height
    angles = _gaze(route, lengths, place, position)
    if is_robot:
        angles[:, 1] = np.clip(angles[:, 1].mean(), -0.5, 0.2)
    angles = angles + moves.turns
    if moves.glances is not None and not np.isfinite(route.targets).all():
        angles[:, 0] += moves.glances
    heading = angles[:, 0]
    forward = np.column_stack([np.cos(heading), np.sin(heading)])
    left = np.column_stack([-forward[:, 1], forward[:, 0]])
    offset = swing * moves.offsets
    position[:, :2] += offset[:, :1] * forward + offset[:, 1:2] * left
    position[:, 2] += offset[:, 2]
    return Trajectory(position, angles, moves.cover)


def _at(points: Array, lengths: Array, place: Array) -> Array:
    return np.column_stack([np.interp(place, lengths, points[:, axis]) for axis in range(3)])


def _gaze(route: Route, lengths: Array, place: Array, position: Array) -> Array:
    """(n, 3) heading, pitch and no roll: to the route's targets, or ahead along it."""
    reach = min(0.8, 0.2 * float(lengths[-1]))
    further = place + reach
    further = np.mod(further, lengths[-1]) if route.is_closed else np.minimum(further, lengths[-1])
    nearer = np.mod(place - 0.1, lengths[-1]) if route.is_closed else np.maximum(place - 0.1, 0.0)
    way = _at(route.points, lengths, further) - _at(route.points, lengths, nearer)
    way[:, 2] = -0.06 * np.linalg.norm(way[:, :2], axis=1)
    if np.isfinite(route.targets).all():
        way = _at(route.targets, lengths, place) - position
    heading = np.unwrap(np.arctan2(way[:, 1], way[:, 0]))
    pitch = np.arctan2(way[:, 2], np.linalg.norm(way[:, :2], axis=1))
    smoothing = GAZE_SMOOTHING / STEP
    heading, pitch = (gaussian_filter1d(each, smoothing, mode="nearest") for each in (heading, pitch))
    return np.column_stack([heading, np.clip(pitch, -1.2, 1.2), np.zeros(len(heading))])
