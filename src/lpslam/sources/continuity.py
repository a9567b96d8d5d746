"""Whether what lies in one recording is one walk: a clock that was set on the way, and two recordings in one folder."""

import itertools
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import ContinuityConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.sources.captures.common import number_of
from lpslam.sources.clocks import Times, drops_of, is_in_parts, refuse_set_back, set_back
from lpslam.sources.images import BadImageError, read_colour
from lpslam.sources.inside import PictureFile

Picture = NDArray[np.uint8]
_ALIKE = 0.5
"""One less the correlation of pictures that follow one another, at most."""
_SAME_RATIO = 1e-6
_SMALL = (32, 24)
"""Pixels of the pictures that are compared: noise and small motion vanish."""


def refuse_clock_set_back(times: Times, pictures: Sequence[PictureFile], path: Path) -> None:
    """Raise a `UserError` where the clock of a list was set back, as its pictures tell where its times alone do not.

    Times that fall once are those of a list in another order, or of a clock that was set: the numbers in the pictures'
    names tell, or else which pictures follow one another.

    Args:
        times: (n,) as listed.
        pictures: of the same entries.
        path: of the list.
    """
    refuse_set_back(times, path)
    drops = drops_of(times)
    if not is_in_parts(times):
        return
    numbers = [number_of(picture) for picture in pictures]
    if _rises(numbers):
        is_set_back = True
    elif _rises([numbers[row] for row in np.argsort(times, kind="stable")]) and not _are_times(numbers, times):
        is_set_back = False
    else:
        is_set_back = _follows_as_listed(times, pictures, drops[0])
    if is_set_back:
        raise set_back(times, drops[0], path, ", and the pictures go on")


def refuse_two_walks(
    name: str, times: Sequence[float], read: Callable[[int], RgbdFrame | None], config: ContinuityConfig
) -> None:
    """Raise a `UserError` where a long time without a frame lies between pictures of two places.

    Args:
        name: of the recording.
        times: of all frames, seconds, rising.
        read: gives the frame of a number; None where it cannot be used.
        config: how long, and how unlike.
    """
    gaps = np.diff(np.asarray(times, np.float64))
    for row in np.flatnonzero(gaps > config.longest_gap_s).tolist():
        before, after = row + 1, len(times) - row - 1
        if min(before, after) < config.least_frames:
            # Some stamps that are wrong are faults of their frames.
            continue
        here, there = read(row), read(row + 1)
        if here is not None and there is not None and _unlike(here.rgb, there.rgb) < config.most_unlike:
            continue
        start = times[row + 1] - times[0]
        raise UserError(
            f"{name}: {gaps[row]:.6g} s lie between its frames {row + 1} and {row + 2}, and they show two places: "
            f"these are two recordings; separate them, or use one with --to {times[row] - times[0] + 0.001:.3f} or "
            f"--from {start:.3f}"
        )


def _rises(numbers: Sequence[int | None]) -> bool:
    known = [number for number in numbers if number is not None]
    return len(known) == len(numbers) and all(one < other for one, other in itertools.pairwise(known))


def _are_times(numbers: Sequence[int | None], times: Times) -> bool:
    """Whether the numbers in names are the times, in whatever unit."""
    known = np.array([float(number or 0) for number in numbers])
    ratios = known / np.where(times == 0, np.nan, times)
    return bool(np.nanmax(np.abs(ratios / ratios[-1] - 1)) < _SAME_RATIO) if ratios[-1] else False


def _follows_as_listed(times: Times, pictures: Sequence[PictureFile], at: int) -> bool:
    """Whether pictures around a fall of the times follow one another, and those that sorting puts together do not."""
    order = np.argsort(times, kind="stable").tolist()
    place = order.index(at - 1)
    # What comes before the list's second part in time is what sorting puts before its first part.
    following = order[place + 1] if place + 1 < len(order) else None
    place = order.index(0)
    preceding = order[place - 1] if place else None
    listed = _change(pictures, at - 1, at)
    sorted_ = [
        change
        for one, other in ((at - 1, following), (preceding, 0))
        if one is not None and other is not None and (change := _change(pictures, one, other)) is not None
    ]
    return listed is not None and bool(sorted_) and listed < min(_ALIKE, min(sorted_) / 2)


def _change(pictures: Sequence[PictureFile], one: int, other: int) -> float | None:
    try:
        return _unlike(read_colour(pictures[one]), read_colour(pictures[other]))
    except BadImageError:
        return None


def _unlike(one: Picture, other: Picture) -> float:
    """How much two pictures differ: 0 where they are alike but for brightness, 1 where they have nothing in common."""
    if one.shape != other.shape:
        return 1.0
    grey = (np.asarray(each.mean(axis=2), np.float32) for each in (one, other))
    small = [cv2.resize(each, _SMALL, interpolation=cv2.INTER_AREA).ravel() for each in grey]
    if min(float(np.ptp(each)) for each in small) < 1.0:
        # A covered lens is like nothing.
        return 1.0
    return 1.0 - float(np.corrcoef(small[0], small[1])[0, 1])
