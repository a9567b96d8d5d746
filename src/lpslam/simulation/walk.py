"""The walking camera: along the route, bobbing, turning no faster than allowed, looking at signs as it passes."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.simulation.layout import Layout
from lpslam.simulation.signs import Sign

FPS = 30.0
OVERLAP = 4.0  # metres walked past the start, so that the loop is seen to close
STEP = 1.0 / 240.0  # seconds between the computed poses
TICK = 0.1  # seconds between decisions where to look
DWELL = 0.6  # seconds for which a sign is looked at
KEEP_RIGHT = 0.5  # metres off the middle of a corridor that is walked in both directions


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


def stroll(
    seed: int, layout: Layout, signs: tuple[Sign, ...], options: SimulationConfig, frames: int | None, visit: int = 0
) -> Walk:
    """Walk the route of a layout.

    Args:
        seed: decides pace, height, bob and the start on the route.
        layout: gives the route.
        signs: what there is to look at.
        options: pace, the bound on turning, and whether to come back the same way.
        frames: how many frames; None for once around and a little more.
        visit: another number is another walk along the same route.
    """
    rng = np.random.default_rng([seed, 11, *([visit] if visit else [])])
    path = rounded(layout.route, radius=1.3)
    if options.way == "there-and-back":
        path, signs = _there_and_back(path), _by_side(signs)
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    around = float(lengths[-1])
    pace = options.speed
    once = math.ceil((around + OVERLAP) / pace * FPS)
    frames = once if frames is None else frames
    # Planned for whole rounds, so that a shorter walk is the beginning of the longer one.
    planned = once * math.ceil(frames / once)
    count = math.ceil((planned / FPS + 1.0) / STEP) + 2
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
    bound = math.radians(options.max_turn_rate)
    wanted = gaze(positions, ahead, signs, 0.8 * bound)
    # Later rounds look where the first one looked at the same place: so the end of a loop shows what its start did.
    rounds, place = np.divmod(travelled - travelled[0], around)
    first, later = rounds == 0, rounds > 0
    wanted[later, 0] = ahead[later] + np.interp(place[later], place[first], (wanted[:, 0] - ahead)[first])
    wanted[later, 1] = np.interp(place[later], place[first], wanted[first, 1])
    # And it begins as if a round had gone before: the head already moves as it will when it comes by again.
    end = int(np.argmax(later))
    warm = min(round(6.0 / STEP), end)
    before = wanted[end - warm : end] - [ahead[end] - ahead[0], 0.0]
    wanted = np.concatenate([before, wanted])
    heading = _follow(wanted[:, 0], 0.88 * bound, 4.0 * bound, STEP)[warm:]
    pitch = _follow(wanted[:, 1], 0.3 * bound, 1.5 * bound, STEP)[warm:]
    nod = rng.uniform(0.003, 0.006)
    heading = heading + nod * np.sin(steps / 2 * times + 2.0)
    pitch = pitch + nod * np.sin(steps * times + 0.7)
    roll = rng.uniform(0.006, 0.014) * np.sin(steps / 2 * times) + 0.01 * np.sin(0.7 * times + rng.uniform(0, 6))
    return Walk(np.asarray(times, np.float64), positions, np.column_stack([heading, pitch, roll]), frames)


def rounded(corners: NDArray[np.float64], radius: float) -> NDArray[np.float64]:
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


def _there_and_back(ring: NDArray[np.float64]) -> NDArray[np.float64]:
    """A closed path around a ring and back again, on the right hand side of either direction."""
    along = np.gradient(ring, axis=0)
    along[[0, -1]] = (ring[1] - ring[-2]) / 2
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    aside = KEEP_RIGHT * np.column_stack([along[:, 1], -along[:, 0]])
    turn = np.linspace(0, np.pi, 24)[1:-1, None]
    # The turn swings out ahead, from the right of one direction to the right of the other.
    last = ring[-1] + np.cos(turn) * aside[-1] + np.sin(turn) * KEEP_RIGHT * along[-1]
    first = ring[0] - np.cos(turn) * aside[0] - np.sin(turn) * KEEP_RIGHT * along[0]
    return np.vstack([ring + aside, last, (ring - aside)[::-1], first, ring[:1] + aside[:1]])


def _by_side(signs: tuple[Sign, ...]) -> tuple[Sign, ...]:
    """Signs of one side only: who comes back looks at the back too."""
    fronts = [replace(sign, double_sided=False) for sign in signs]
    backs = [replace(sign, double_sided=False, normal=-sign.normal) for sign in signs if sign.double_sided]
    return (*fronts, *backs)


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


def gaze(
    positions: NDArray[np.float64], ahead: NDArray[np.float64], signs: tuple[Sign, ...], max_rate: float
) -> NDArray[np.float64]:
    """Where to look, (n, 2) heading and pitch: at one sign after another while it is well placed, else ahead.

    Of the signs that can be turned to in time, the one whose chance ends first is looked at for `DWELL` seconds.
    """
    wanted = np.column_stack([ahead, np.full(len(ahead), -0.06)])
    if not signs:
        return wanted
    chunk = round(TICK / STEP)
    view = _placing(positions[::chunk], ahead[::chunk], signs)
    ticks, count = view.good.shape
    # Ticks for which each sign stays well placed from each tick on.
    left = np.zeros((ticks + 1, count))
    for tick in range(ticks - 1, -1, -1):
        left[tick] = np.where(view.good[tick], left[tick + 1] + 1, 0)
    looked = np.zeros(count)
    current, heading, every = -1, float(ahead[0]), np.arange(count)
    for tick in range(ticks):
        if current < 0 or looked[current] >= DWELL or left[tick, current] == 0:
            turning = np.abs(view.bearing[tick] - heading) / max_rate / TICK + 2
            arrival = np.minimum(tick + np.ceil(turning).astype(np.int64), ticks)
            chance = np.where(looked < DWELL, left[arrival, every], 0)
            deadline = np.where(chance * TICK > 0.4, arrival + chance, np.inf)
            current = int(np.argmin(deadline)) if np.isfinite(deadline).any() else -1
        start, stop = tick * chunk, (tick + 1) * chunk
        target = float(ahead[start])
        if current >= 0:
            target = float(view.bearing[tick, current])
            wanted[start:stop, 1] = np.clip(0.7 * view.pitch[tick, current], -0.12, 0.2)
        # A glance over the shoulder is as far as a neck turns.
        target = float(ahead[start] + np.clip(target - ahead[start], -1.35, 1.35))
        wanted[start:stop, 0] = target
        heading += float(np.clip(target - heading, -TICK * max_rate, TICK * max_rate))
        if current >= 0 and view.good[tick, current] and abs(view.bearing[tick, current] - heading) < 0.2:
            looked[current] += TICK
    # Eyes lead: the spring that follows comes about a third of a second late.
    lead = min(round(0.32 / STEP), len(wanted) - 1)
    return np.concatenate([wanted[lead:], np.repeat(wanted[-1:], lead, axis=0)])


@dataclass(frozen=True, slots=True, eq=False)
class _Placing:
    """How signs stand to a walker at every tick, each (ticks, signs).

    Attributes:
        bearing: heading at which each is straight ahead, radians, less than half a turn from the way ahead.
        pitch: radians, up positive.
        good: whether each is 1.3 to 6 m away, not behind the shoulder, and seen at less than 46 degrees.
    """

    bearing: NDArray[np.float64]
    pitch: NDArray[np.float64]
    good: NDArray[np.bool_]


def _placing(positions: NDArray[np.float64], ahead: NDArray[np.float64], signs: tuple[Sign, ...]) -> _Placing:
    centres = np.array([sign.corners.mean(axis=0) for sign in signs])
    normals = np.array([sign.normal for sign in signs])
    way = centres[None] - positions[:, None]
    distance = np.linalg.norm(way, axis=2)
    cosine = -np.einsum("tsi,si->ts", way, normals) / distance
    cosine = np.where([sign.double_sided for sign in signs], np.abs(cosine), cosine)
    turn = (np.arctan2(way[..., 1], way[..., 0]) - ahead[:, None] + np.pi) % (2 * np.pi) - np.pi
    good = (distance > 1.3) & (distance < 6.0) & (np.abs(turn) < 1.35) & (cosine > 0.695)
    return _Placing(ahead[:, None] + turn, np.arcsin(np.clip(way[..., 2] / distance, -1, 1)), good)


@njit(cache=True, nogil=True)
def _follow(wanted: NDArray[np.float64], max_rate: float, max_acceleration: float, step: float) -> NDArray[np.float64]:
    """Follow a signal smoothly: a damped spring whose rate and acceleration are bounded."""
    out = np.empty_like(wanted)
    value, rate = wanted[0], 0.0
    stiffness = 5.0
    for i in range(len(wanted)):
        pull = stiffness * stiffness * (wanted[i] - value) - 2.0 * stiffness * rate
        pull = min(max(pull, -max_acceleration), max_acceleration)
        rate = min(max(rate + pull * step, -max_rate), max_rate)
        value += rate * step
        out[i] = value
    return out
