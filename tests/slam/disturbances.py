"""What happens to cameras in the world, as sources of frames: a `FrameSource` in, a disturbed one out.

Each changes the frames at positions `first` to `last` (without) in the order of the source, and no other ones.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig, TrackingConfig
from lpslam.frames import FrameFault, FrameSource, RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source

Disturbance = Callable[[Iterator[RgbdFrame]], Iterator[RgbdFrame]]

WITHOUT_COASTING = SlamConfig(tracking=TrackingConfig(coast_seconds=0.0))
"""For what happens once the camera is lost: with coasting, half a second without a view comes before."""


class Clip:
    """Frames of a recording, kept in memory, as a `FrameSource` with its truth.

    Args:
        folder: of the recording.
        order: which of its frames are played, one after the other, at its pace; back and forth if need be.
    """

    def __init__(self, folder: Path, order: Sequence[int]) -> None:
        source = open_source(folder, max_frames=max(order) + 1)
        truth = read_ground_truth(folder)
        assert truth is not None
        recorded = _recorded(folder)
        times = recorded[0].timestamp + np.arange(len(order)) * (recorded[1].timestamp - recorded[0].timestamp)
        self.name = source.name
        self.camera: PinholeCamera = source.camera
        self.faults: list[FrameFault] = []
        self.truth = StampedPoses(times.astype(np.float64), truth.world_from_camera[list(order)])
        self._frames = [
            replace(recorded[row], index=index, timestamp=float(times[index])) for index, row in enumerate(order)
        ]

    def __len__(self) -> int:
        return len(self._frames)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return iter(self._frames)


@cache
def _recorded(folder: Path) -> list[RgbdFrame]:
    """All frames of a recording, decoded once in a process."""
    decoded = list(open_source(folder))
    for frame in decoded:
        frame.rgb.flags.writeable = frame.depth.flags.writeable = False
    return decoded


@dataclass(frozen=True)
class Disturbed:
    """A `FrameSource` whose frames pass through a disturbance."""

    source: FrameSource
    disturbance: Disturbance

    @property
    def name(self) -> str:
        return f"disturbed {self.source.name}"

    @property
    def camera(self) -> PinholeCamera:
        return self.source.camera

    @property
    def faults(self) -> list[FrameFault]:
        return self.source.faults

    def __len__(self) -> int:
        return len(self.source)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return self.disturbance(iter(self.source))


def _each(first: int, last: int, change: Callable[[int, RgbdFrame], RgbdFrame]) -> Disturbance:
    """Change single frames; `change` gets how many frames of the disturbance came before."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        for position, frame in enumerate(frames):
            yield change(position - first, frame) if first <= position < last else frame

    return disturbance


# Delivery ----------------------------------------------------------------------------------------------------------


def doubled(first: int, last: int) -> Disturbance:
    """Every frame comes twice, with the same time."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        for position, frame in enumerate(frames):
            yield frame
            if first <= position < last:
                yield frame

    return disturbance


def out_of_order(first: int, last: int) -> Disturbance:
    """Every second frame comes after the one that follows it."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        held: RgbdFrame | None = None
        for position, frame in enumerate(frames):
            if first <= position < last and held is None:
                held = frame
                continue
            yield frame
            if held is not None:
                yield held
                held = None

    return disturbance


def gap(first: int, last: int) -> Disturbance:
    """Frames never arrive."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        for position, frame in enumerate(frames):
            if not first <= position < last:
                yield frame

    return disturbance


# Sensor ------------------------------------------------------------------------------------------------------------


def without_depth(first: int, last: int) -> Disturbance:
    """The depth camera sends nothing."""
    return _each(first, last, lambda _, frame: replace(frame, depth=np.zeros_like(frame.depth)))


def hardly_any_depth(first: int, last: int, pixels: int = 60) -> Disturbance:
    """Depth is left in a square in the middle of the picture."""

    def change(_: int, frame: RgbdFrame) -> RgbdFrame:
        (height, width), depth = frame.depth.shape, np.zeros_like(frame.depth)
        top, left = (height - pixels) // 2, (width - pixels) // 2
        middle = np.s_[top : top + pixels, left : left + pixels]
        depth[middle] = frame.depth[middle]
        return replace(frame, depth=depth)

    return _each(first, last, change)


def frozen_colour(first: int, last: int) -> Disturbance:
    """The colour camera repeats its last picture, with a fresh time, while depth goes on."""

    def disturbance(frames: Iterator[RgbdFrame]) -> Iterator[RgbdFrame]:
        shown: NDArray[np.uint8] | None = None
        for position, frame in enumerate(frames):
            if not first <= position < last or shown is None:
                shown = frame.rgb
            yield replace(frame, rgb=shown)

    return disturbance


def exposure(first: int, last: int, factors: tuple[float, ...]) -> Disturbance:
    """Brightness jumps from one factor to the next, at equal intervals."""

    def change(age: int, frame: RgbdFrame) -> RgbdFrame:
        factor = factors[age * len(factors) // (last - first)]
        return replace(frame, rgb=np.clip(frame.rgb * np.float32(factor), 0, 255).astype(np.uint8))

    return _each(first, last, change)


def rolling_blur(first: int, last: int, pixels: int = 16) -> Disturbance:
    """A long rolling exposure in a sideways jerk: lower rows are later, and smeared like the others.

    Sixteen pixels are what 25 ms of reading out show at 70 degrees a second.
    """

    def change(age: int, frame: RgbdFrame) -> RgbdFrame:
        strength = np.sin(np.pi * (age + 1) / (last - first + 1)) * pixels
        height, width = frame.depth.shape
        u, v = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
        sheared = cv2.remap(frame.rgb, u + np.float32(strength) * (v / height - 0.5), v, cv2.INTER_LINEAR)
        return replace(frame, rgb=np.asarray(cv2.blur(sheared, (max(1, int(strength)), 1)), dtype=np.uint8))

    return _each(first, last, change)


# World -------------------------------------------------------------------------------------------------------------


def hand_over_lens(first: int, last: int) -> Disturbance:
    """Skin, out of focus, trembling, and too near for depth."""

    def change(age: int, frame: RgbdFrame) -> RgbdFrame:
        rng = np.random.default_rng(age)
        coarse = rng.normal([150.0, 95.0, 75.0], 12.0, (6, 8, 3)).clip(0, 255).astype(np.uint8)
        skin = cv2.resize(coarse, frame.depth.shape[::-1], interpolation=cv2.INTER_CUBIC).astype(np.float32)
        noisy = (skin + rng.normal(0.0, 3.0, skin.shape)).clip(0, 255).astype(np.uint8)
        return replace(frame, rgb=noisy, depth=np.zeros_like(frame.depth))

    return _each(first, last, change)


def blank_wall(first: int, last: int, distance: float = 1.2) -> Disturbance:
    """A wall without texture fills the view, with good depth."""

    def change(age: int, frame: RgbdFrame) -> RgbdFrame:
        rng = np.random.default_rng(age)
        wall = rng.normal([196.0, 190.0, 178.0], 2.0, frame.rgb.shape).clip(0, 255).astype(np.uint8)
        depth = rng.normal(distance, 0.003, frame.depth.shape).astype(np.float32)
        return replace(frame, rgb=wall, depth=depth)

    return _each(first, last, change)


def passer_by(first: int, last: int, distance: float = 1.4, share: float = 0.36, contrast: float = 30.0) -> Disturbance:
    """Someone in a checked coat walks through the view, from the left to the right, hiding what is farther off.

    Grey values of the checks differ by `contrast`; with 70 nearly all corners of the picture are the coat's.
    """
    checks = np.random.default_rng(5).normal([70.0, 80.0, 105.0], contrast, (30, 15, 3))
    coat = cv2.GaussianBlur(np.kron(checks, np.ones((16, 16, 1))), (5, 5), 0).clip(0, 255).astype(np.uint8)

    def change(age: int, frame: RgbdFrame) -> RgbdFrame:
        height, width = frame.depth.shape
        breadth = int(share * width)
        left = round(-breadth + (width + breadth) * (age + 1) / (last - first + 1))
        columns = slice(max(0, left), max(0, min(width, left + breadth)))
        cloth = cv2.resize(coat, (breadth, height))[:, columns.start - left : columns.stop - left]
        rgb, depth = frame.rgb.copy(), frame.depth.copy()
        hidden = (depth[:, columns] == 0) | (depth[:, columns] > distance)
        rgb[:, columns][hidden] = cloth[hidden]
        depth[:, columns][hidden] = distance
        return replace(frame, rgb=rgb, depth=depth)

    return _each(first, last, change)
