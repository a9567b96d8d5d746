"""The walking camera: along the route, bobbing, turning no faster than allowed, looking at signs as it passes."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.simulation.layout import Layout
from lpslam.simulation.signs import Sign

FPS = 30.0
OVERLAP = 3.0  # metres walked past the start, so that the loop is seen to close
STEP = 1.0 / 240.0  # seconds between the computed poses


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """Where the camera is at every instant.

    Attributes:
        times: (n,) seconds, evenly spaced.
        positions: (n, 3) metres.
        angles: (n, 3) heading, pitch (up positive), roll; radians.
        frames: number of frames of the walk at 30 Hz.
    """

    times: NDArray[np.float64]
    positions: NDArray[np.float64]
    angles: NDArray[np.float64]
    frames: int

    def pose(self, time: float) -> NDArray[np.float64]:
        """World from camera (4×4, optical frame) at a time in seconds."""
        place = np.clip(time / STEP, 0, len(self.times) - 1.001)
        index, share = int(place), place - int(place)
        position = self.positions[index] * (1 - share) + self.positions[index + 1] * share
        heading, pitch, roll = self.angles[index] * (1 - share) + self.angles[index + 1] * share
        return _pose(position, heading, pitch, roll)


def _pose(position: NDArray[np.float64], heading: float, pitch: float, roll: float) -> NDArray[np.float64]:
    forward = np.array([math.cos(heading) * math.cos(pitch), math.sin(heading) * math.cos(pitch), math.sin(pitch)])
    right = np.array([math.sin(heading), -math.cos(heading), 0.0])
    down = np.cross(forward, right)
    world_from_camera = np.eye(4)
    world_from_camera[:3, 0] = math.cos(roll) * right + math.sin(roll) * down
    world_from_camera[:3, 1] = -math.sin(roll) * right + math.cos(roll) * down
    world_from_camera[:3, 2] = forward
    world_from_camera[:3, 3] = position
    return world_from_camera


def stroll(seed: int, layout: Layout, signs: tuple[Sign, ...], options: SimulationConfig, frames: int | None) -> Walk:
    """Walk the route of a layout.

    Args:
        seed: decides pace, height, bob and the start on the route.
        layout: gives the route.
        signs: what there is to look at.
        options: the bound on turning.
        frames: how many frames; None for once around and a little more.
    """
    rng = np.random.default_rng([seed, 11])
    path = _rounded(layout.route, radius=1.3)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    around = float(lengths[-1])
    pace = options.speed
    if frames is None:
        frames = math.ceil((around + OVERLAP) / pace * FPS)
    count = math.ceil((frames / FPS + 1.0) / STEP) + 2
    times = np.arange(count) * STEP
    # Steps are not all alike: the pace drifts by some percent, over several seconds.
    drift = sum(rng.uniform(0.02, 0.05) * np.sin(times * rng.uniform(0.3, 1.1) + rng.uniform(0, 6)) for _ in range(2))
    travelled = np.cumsum(np.maximum(pace * (1 + np.asarray(drift)), 0.2)) * STEP
    travelled += around * rng.uniform(0, 1) - travelled[0]
    sway = rng.uniform(0.1, 0.25) * np.sin(2 * np.pi * travelled / around * rng.integers(3, 6) + rng.uniform(0, 6))
    position, ahead = _along(path, lengths, travelled)
    position = position + sway[:, None] * np.column_stack([-np.sin(ahead), np.cos(ahead)])
    eye = rng.uniform(1.3, 1.5)
    steps = rng.uniform(1.7, 1.95) * 2 * np.pi
    bob = rng.uniform(0.012, 0.022) * np.sin(steps * times)
    side = rng.uniform(0.008, 0.015) * np.sin(steps / 2 * times + 1.0)
    position = position + side[:, None] * np.column_stack([-np.sin(ahead), np.cos(ahead)])
    positions = np.column_stack([position, eye + bob])
    wanted = _gaze(positions, ahead, signs)
    bound = math.radians(options.max_turn_rate)
    heading = _follow(wanted[:, 0], 0.88 * bound, 4.0 * bound, STEP)
    pitch = _follow(wanted[:, 1], 0.3 * bound, 1.5 * bound, STEP)
    nod = rng.uniform(0.003, 0.006)
    heading = heading + nod * np.sin(steps / 2 * times + 2.0)
    pitch = pitch + nod * np.sin(steps * times + 0.7)
    roll = rng.uniform(0.006, 0.014) * np.sin(steps / 2 * times) + 0.01 * np.sin(0.7 * times + rng.uniform(0, 6))
    return Walk(times, positions, np.column_stack([heading, pitch, roll]), frames)


def _rounded(corners: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
    """A closed polygon with arcs for corners, as points every few centimetres; the last repeats the first."""
    points: list[NDArray[np.float64]] = []
    count = len(corners)
    for i in range(count):
        before, here, after = corners[i - 1], corners[i], corners[(i + 1) % count]
        arrive = (here - before) / np.linalg.norm(here - before)
        leave = (after - here) / np.linalg.norm(after - here)
        turn = float(np.clip(arrive @ leave, -1, 1))
        if turn > 0.999:
            points.append(here)
            continue
        reach = min(radius, 0.45 * float(np.linalg.norm(here - before)), 0.45 * float(np.linalg.norm(after - here)))
        blend = np.linspace(0, np.pi / 2, 24)[:, None]
        points.extend(here - reach * arrive + reach * (np.sin(blend) * arrive + (1 - np.cos(blend)) * leave))
    points.append(points[0])
    ring = np.array(points)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    even = np.linspace(0, lengths[-1], max(50, round(lengths[-1] / 0.05)))
    return np.column_stack([np.interp(even, lengths, ring[:, axis]) for axis in range(2)])


def _along(
    path: NDArray[np.float64], lengths: NDArray[np.float64], travelled: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Positions (n, 2) and unwrapped headings (n,) at distances along a closed path."""
    around = lengths[-1]
    place = np.mod(travelled, around)
    position = np.column_stack([np.interp(place, lengths, path[:, axis]) for axis in range(2)])
    ahead = np.mod(travelled + 0.15, around)
    behind = np.mod(travelled - 0.15, around)
    step = np.column_stack(
        [np.interp(ahead, lengths, path[:, axis]) - np.interp(behind, lengths, path[:, axis]) for axis in range(2)]
    )
    return position, np.unwrap(np.arctan2(step[:, 1], step[:, 0]))


def _gaze(positions: NDArray[np.float64], ahead: NDArray[np.float64], signs: tuple[Sign, ...]) -> NDArray[np.float64]:
    """Where to look, (n, 2) heading and pitch: at one sign after another while it is well placed, else ahead.

    A sign is well placed while it is 1.6 to 5 m away, within 62 degrees of the way ahead and seen at less than 48
    degrees. The one that offers its chance soonest and has been looked at least is taken for about a second.
    """
    wanted = np.column_stack([ahead, np.zeros(len(ahead))])
    if not signs:
        return wanted
    centres = np.array([sign.corners.mean(axis=0) for sign in signs])
    normals = np.array([sign.normal for sign in signs])
    both = np.array([sign.double_sided for sign in signs])
    looked = np.zeros(len(signs))
    chunk = round(0.1 / STEP)
    current, since = -1, 0.0
    for start in range(0, len(ahead), chunk):
        way = centres - positions[start]
        distance = np.linalg.norm(way, axis=1)
        cosine = -np.einsum("ij,ij->i", way, normals) / distance
        cosine = np.where(both, np.abs(cosine), cosine)
        bearing = np.arctan2(way[:, 1], way[:, 0])
        turn = (bearing - ahead[start] + np.pi) % (2 * np.pi) - np.pi
        pitch = np.arcsin(np.clip(way[:, 2] / distance, -1, 1))
        good = (distance > 1.6) & (distance < 5.0) & (np.abs(turn) < 1.08) & (cosine > 0.67)
        score = np.where(good, cosine / (1.0 + looked) - 0.04 * distance, -np.inf)
        if current < 0 or not good[current] or since > 1.2:
            best = int(np.argmax(score))
            if best != current:
                since = 0.0
            current = best if np.isfinite(score[best]) else -1
        since += 0.1
        if current >= 0:
            looked[current] += 0.1
            stop = start + chunk
            wanted[start:stop, 0] = ahead[start:stop] + turn[current]
            wanted[start:stop, 1] = np.clip(0.75 * pitch[current], -0.1, 0.2)
    return wanted


@njit(cache=True, nogil=True)
def _follow(wanted, max_rate, max_acceleration, step):
    """Follow a signal smoothly: a damped spring whose rate and acceleration are bounded."""
    out = np.empty_like(wanted)
    value, rate = wanted[0], 0.0
    stiffness = 3.2
    for i in range(len(wanted)):
        pull = stiffness * stiffness * (wanted[i] - value) - 2.0 * stiffness * rate
        pull = min(max(pull, -max_acceleration), max_acceleration)
        rate = min(max(rate + pull * step, -max_rate), max_rate)
        value += rate * step
        out[i] = value
    return out
