"""In which unit a recording counts time: seconds, or thousandths, millionths or billionths of them, or durations."""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError

Times = NDArray[np.float64]

_UNITS = ((1.0, "seconds"), (1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds"))
_SLOWEST = 4.0
"""Seconds between frames at most: a thousandth of more is another unit's step, of a camera of 250 frames a second."""
_MOST_SET_BACK = 3
"""Times that a clock may be set back in one list; what goes back more often is in no order."""
_FEW, _DENSE = 4, 1.5
"""Stamps that say how dense they lie at least, and by how many times denser than usual two stretches in one lie."""
_EPOCH = (1e9, 1e11)
"""Between these, stamps are seconds since 1970, however slowly frames come ..."""
_SLOWEST_EPOCH = 60.0
"""... though no slower than this, seconds."""
_ALIKE, _NO_TREND = 0.3, 0.4
"""Durations spread by less than this share of their median, and correlate with their order by less."""
_LEAST = 20
"""Stamps by which durations are known; fewer may be alike by chance."""
_FASTEST = 1 / 400
"""Seconds between frames at least."""
_COMPARED = 5
"""Stamps that are compared with another clock at least; between fewer, one delay is much of the time."""
_NEAR = 0.3
"""Powers of ten by which the two clocks may differ besides: pictures are recorded in bursts."""


def in_seconds(times: Times) -> tuple[Times, str]:
    """Stamps (n,) in order of the recording → seconds, and a note of what was converted, empty where nothing was."""
    if len(times) < 2:
        return times, ""
    if _are_durations(times):
        seconds, note = in_seconds(np.concatenate([[0.0], np.cumsum(times[1:])]))
        return seconds, "its stamps are durations from frame to frame, which are added up" + (note and f"; {note}")
    steps = np.diff(np.unique(times))
    step = float(np.median(steps)) if len(steps) else 0.0
    if _EPOCH[0] <= times.min() and times.max() < _EPOCH[1] and step < _SLOWEST_EPOCH:
        return times, ""
    factor, unit = next((each for each in _UNITS if step < _SLOWEST * each[0]), _UNITS[-1])
    return (times, "") if factor == 1.0 else (times / factor, f"its stamps are {unit}, which are converted to seconds")


def set_back_at(times: Times) -> int | None:
    """Where the clock of a list was set back (the number of its first stamp that comes before those ahead of it).

    None for a list that rises, that is in no order at all, or whose parts follow one another in another order: sorting
    makes these right, and weaves the stretches of a clock that was set back into one another. Lines that a logger
    swapped lie no denser when they are sorted.
    """
    drops = drops_of(times)
    if not drops:
        return None
    edges = [0, *drops, len(times)]
    parts = sorted((times[begin:end].min(), times[begin:end].max()) for begin, end in itertools.pairwise(edges))
    is_woven = any(_is_dense(times, second[0], first[1]) for first, second in itertools.pairwise(parts))
    return drops[0] if is_woven else None


def drops_of(times: Times) -> list[int]:
    """Numbers of the stamps that come before those ahead of them; none of a list that is in no order at all."""
    drops = np.flatnonzero(np.diff(times) < 0) + 1
    return drops.tolist() if len(drops) <= max(_MOST_SET_BACK, len(times) // 1000) else []


def is_in_parts(times: Times) -> bool:
    """Whether a list consists of some stretches that rise and share no time, in another order."""
    edges = [0, *drops_of(times), len(times)]
    parts = sorted((times[begin:end].min(), times[begin:end].max()) for begin, end in itertools.pairwise(edges))
    return len(parts) > 1 and all(first[1] < second[0] for first, second in itertools.pairwise(parts))


def _is_dense(times: Times, first: float, last: float) -> bool:
    """Whether more stamps lie between two than at the pace of the list; of a few that is chance."""
    within = np.count_nonzero((times >= first) & (times <= last))
    usual = float(np.median(np.abs(np.diff(times))))
    return bool(within >= _FEW and (within - 1) * usual > _DENSE * (last - first))


def refuse_set_back(times: Times, path: Path) -> None:
    """Raise a `UserError` where the clock of a list was set back."""
    at = set_back_at(times)
    if at is not None:
        raise set_back(times, at, path)


def set_back(times: Times, at: int, path: Path, besides: str = "") -> UserError:
    """That the clock of a list was set back before a number, and what says so besides."""
    return UserError(
        f"{path}: its clock goes back by {times[at - 1] - times[at]:.3g} between entries {at} and {at + 1}{besides}; "
        "give times that rise, or cut the recording in two there"
    )


def power_of_ten_between(stamps: Sequence[int], logged: Sequence[int]) -> int:
    """By which power of ten stamps run faster than the clock of their recording; 0 where they are a camera's.

    Args:
        stamps: nanoseconds, as the headers of pictures have them.
        logged: nanoseconds, when the same pictures were recorded.
    """
    if len(stamps) < _COMPARED:
        return 0
    step, by_log = ((each[-1] - each[0]) / (len(each) - 1) / 1e9 for each in (stamps, logged))
    is_camera = _FASTEST < step < _SLOWEST
    if is_camera or not step > 0 or not _FASTEST < by_log < _SLOWEST:
        return 0
    power = math.log10(step / by_log)
    nearest = 3 * round(power / 3)
    return nearest if abs(power - nearest) < _NEAR and abs(nearest) <= 9 else 0


def _are_durations(times: Times) -> bool:
    """Whether stamps stay about the same instead of rising."""
    middle = float(np.median(times))
    if len(times) < _LEAST or not middle > 0 or float(times.max()) >= _SLOWEST * 1e3:
        return False
    spread = float(np.median(np.abs(times - middle)))
    # Durations are often rounded to a few values: equal ones share a rank, or their order alone would be a trend.
    ranks = np.unique(times, return_inverse=True)[1]
    trend = float(np.corrcoef(np.arange(len(times)), ranks)[0, 1]) if spread > 0 else 0.0
    return spread < _ALIKE * middle and abs(trend) < _NO_TREND
