"""The ways in which cameras are carried: pace, swing, trembling, turns, and what covers the lens."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
RADIAN = np.pi / 180.0


@dataclass(slots=True, eq=False)
class Moves:
    """What a way of carrying adds to a route, one row a step.

    Attributes:
        speed: (n,) metres a second along the route.
        offsets: (n, 3) metres forward, to the left and up.
        turns: (n, 3) radians of heading, pitch and roll.
        cover: (n,) 0 to 1.
        glances: (n,) radians by which someone looks aside who otherwise looks where they go; None: never.
    """

    speed: Array
    offsets: Array
    turns: Array
    cover: Array
    glances: Array | None = None


def moves_of(kind: str, rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Draw the moves of a kind: `count` steps of `step` seconds by someone who walks at `pace` metres a second."""
    makers: dict[str, Callable[[np.random.Generator, int, float, float], Moves]] = {
        "handheld": _handheld,
        "rotation": _rotation,
        "pans": _pans,
        "stop-and-go": _stop_and_go,
        "robot": _robot,
        "humanoid": _humanoid,
        "set-down": _set_down,
        "bag": _bag,
    }
    moves = makers[kind](rng, count, step, pace)
    if kind in ("robot", "rotation"):
        return moves
    aside = 1.05 * np.tanh(waves(rng, count, step, 0.06, 0.22, 0.6) / 0.8)
    # What lies on a table looks nowhere else.
    moves.glances = None if kind == "set-down" else aside
    return moves


def waves(rng: np.random.Generator, count: int, step: float, low: float, high: float, size: float) -> Array:
    """(count,) smooth noise between two frequencies (hertz), falling as 1/f, of a standard deviation of `size`."""
    length = 2 * count
    frequency = np.fft.rfftfreq(length, step)
    band = (frequency >= low) & (frequency <= high)
    spectrum = np.zeros(len(frequency), complex)
    spectrum[band] = (rng.standard_normal(band.sum()) + 1j * rng.standard_normal(band.sum())) / frequency[band]
    wave = np.fft.irfft(spectrum, length)[:count]
    return np.asarray(wave * size / max(float(np.fft.irfft(spectrum, length).std()), 1e-12))


def _times(count: int, step: float) -> Array:
    return np.asarray(np.arange(count) * step, np.float64)


def eased(times: Array, start: float, length: float) -> Array:
    """0 before `start`, 1 after `start + length`, with the least jerk in between."""
    share = np.clip((times - start) / length, 0, 1)
    return np.asarray(share**3 * (10 - 15 * share + 6 * share**2))


def _handheld(rng: np.random.Generator, count: int, step: float, pace: float, calm: float = 1.0) -> Moves:
    """A hand that walks: slow swaying, shaking at a few hertz, a little trembling."""
    strength = calm * float(rng.uniform(0.6, 1.4))
    speed = np.maximum(pace * rng.uniform(0.7, 1.1) * (1 + waves(rng, count, step, 0.05, 0.5, 0.3)), 0.02)
    offsets, turns = np.empty((count, 3)), np.empty((count, 3))
    for axis, (slow, quick) in enumerate(((0.015, 0.003), (0.025, 0.004), (0.02, 0.005))):
        offsets[:, axis] = waves(rng, count, step, 0.15, 0.8, slow) + waves(rng, count, step, 1.0, 5.0, quick)
    for axis, (slow, quick) in enumerate(((4.0, 0.4), (2.5, 0.4), (1.5, 0.3))):
        turns[:, axis] = waves(rng, count, step, 0.1, 0.6, slow) + waves(rng, count, step, 1.0, 6.0, quick)
        turns[:, axis] += waves(rng, count, step, 7.0, 11.0, 0.06)
    return Moves(speed, strength * offsets, strength * turns * RADIAN, np.zeros(count))


def _rotation(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Someone or something that stands and turns; the camera sits a few centimetres off the axis."""
    times = _times(count, step)
    by_hand = bool(rng.random() < 0.5)
    moves = _handheld(rng, count, step, pace, 0.6 if by_hand else 0.0)
    moves.speed[:] = 0.0
    rate = float(rng.uniform(30, 90)) * float(rng.choice([-1, 1])) * RADIAN
    change = float(rng.uniform(0.45, 0.6)) * times[-1]
    # Once or more around, a stop, and back again or farther.
    rates = rate * eased(times, 0.5, 1.0) * (1 - eased(times, change, 0.8))
    rates += rate * float(rng.choice([-1.0, 0.7])) * eased(times, change + 1.5, 0.8)
    moves.turns[:, 0] += np.cumsum(rates * (1 + waves(rng, count, step, 0.1, 0.5, 0.12))) * step
    moves.turns[:, 1] += waves(rng, count, step, 0.05, 0.2, 5.0 * RADIAN)
    moves.offsets[:, 0] += float(rng.uniform(0.15, 0.3) if by_hand else rng.uniform(0.01, 0.06))
    return moves


def _pans(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """A hand that throws the camera aside and back: 100 to 250 degrees a second for half a second."""
    moves = _handheld(rng, count, step, 0.6 * pace)
    times, at = _times(count, step), float(rng.uniform(1.5, 3.0))
    aside = 0.0
    while at < times[-1] - 1.0:
        turn = -aside if abs(aside) > 20 else float(rng.uniform(35, 95)) * float(rng.choice([-1, 1]))
        moves.turns[:, 0] += turn * RADIAN * eased(times, at, abs(turn) * 1.875 / float(rng.uniform(100, 250)))
        aside += turn
        at += float(rng.uniform(1.2, 3.0))
    return moves


def _stop_and_go(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Steps of a second or three, and pauses in which only the hand trembles."""
    moves = _handheld(rng, count, step, pace, 0.7)
    times, at, going = _times(count, step), float(rng.uniform(0.5, 2.0)), 1.0
    share = np.ones(count)
    while at < times[-1]:
        share += (-1.0 if going else 1.0) * eased(times, at, 0.6)
        going = 1.0 - going
        at += float(rng.uniform(1.2, 3.2))
    moves.speed *= 1.3 * share
    return moves


def _robot(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Wheels: a plane, an even pace, and the floor's vibration."""
    times = _times(count, step)
    speed = pace * float(rng.uniform(0.5, 1.0)) * eased(times, 0.3, 1.0) * (1 + waves(rng, count, step, 0.05, 0.3, 0.1))
    offsets, turns = np.zeros((count, 3)), np.zeros((count, 3))
    strength = float(rng.uniform(0.5, 1.5)) * np.minimum(speed / pace, 1.0)
    offsets[:, 2] = strength * waves(rng, count, step, 10.0, 35.0, 0.0006)
    turns[:, 1] = strength * waves(rng, count, step, 8.0, 35.0, 0.12 * RADIAN)
    turns[:, 2] = strength * waves(rng, count, step, 8.0, 35.0, 0.10 * RADIAN)
    turns[:, 0] = waves(rng, count, step, 0.05, 0.3, 4.0 * RADIAN)
    return Moves(np.maximum(speed, 0.0), offsets, turns, np.zeros(count))


def _humanoid(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Legs: the head goes up and down with each step, from side to side with every other, and jerks as a foot lands."""
    times = _times(count, step)
    rhythm = float(rng.uniform(1.4, 2.1))
    phase = 2 * np.pi * (rhythm * times + np.cumsum(waves(rng, count, step, 0.05, 0.4, 0.05)) * step)
    strength = float(rng.uniform(0.6, 1.2))
    landing = np.mod(phase, 2 * np.pi) / (2 * np.pi * rhythm)  # seconds since a foot landed
    jerk = np.sin(2 * np.pi * 11.0 * landing) * np.exp(-landing / 0.07) * (1 - np.exp(-landing / 0.01))
    offsets = np.column_stack([0.008 * np.sin(phase), 0.025 * np.sin(phase / 2), 0.022 * np.cos(phase) + 0.0015 * jerk])
    turns = np.column_stack([
        3.0 * np.sin(phase / 2 + 0.5) + waves(rng, count, step, 0.1, 0.4, 4.0),
        1.4 * np.sin(phase + 0.8) + 0.7 * jerk + waves(rng, count, step, 0.1, 0.4, 2.0),
        1.8 * np.sin(phase / 2) + 0.3 * jerk,
    ])  # fmt: skip
    speed = pace * float(rng.uniform(0.7, 1.0)) * (1 + 0.12 * np.sin(phase))
    return Moves(speed, strength * offsets, strength * turns * RADIAN, np.zeros(count))


def _set_down(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Carried, put down for some seconds, tilted and perfectly still, and taken up again."""
    moves = _handheld(rng, count, step, pace)
    times = _times(count, step)
    start, rest = float(rng.uniform(0.3, 0.5)) * times[-1], float(rng.uniform(2.5, 5.0))
    down = eased(times, start, 1.1) * (1 - eased(times, start + 1.1 + rest, 0.9))
    still = 1.0 - down
    moves.speed *= still
    index = int(np.searchsorted(times, start + 1.1))
    for each in (moves.offsets, moves.turns):
        # It lies where it was when the hand let go.
        each[:] = still[:, None] * each + down[:, None] * each[index]
    moves.offsets[:, 2] -= float(rng.uniform(0.12, 0.3)) * down
    moves.turns[:, 2] += float(rng.uniform(8, 28)) * float(rng.choice([-1, 1])) * RADIAN * down
    moves.turns[:, 1] += float(rng.uniform(-8, 12)) * RADIAN * down
    return moves


def _bag(rng: np.random.Generator, count: int, step: float, pace: float) -> Moves:
    """Carried, put into a bag, taken some way in it, and out again."""
    moves = _handheld(rng, count, step, pace)
    times = _times(count, step)
    start, inside = float(rng.uniform(0.35, 0.5)) * times[-1], float(rng.uniform(2.0, 4.0))
    moves.cover = eased(times, start, 0.35) * (1 - eased(times, start + 0.35 + inside, 0.4))
    lowered = eased(times, start - 0.3, 0.9) * (1 - eased(times, start + inside - 0.1, 0.9))
    moves.offsets[:, 2] -= float(rng.uniform(0.2, 0.4)) * lowered
    moves.turns[:, 1] -= float(rng.uniform(25, 60)) * RADIAN * lowered
    moves.turns[:, 2] += float(rng.uniform(-25, 25)) * RADIAN * lowered
    moves.speed *= 1 + 0.8 * lowered
    return moves
