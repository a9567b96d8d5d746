"""What the recordings of all benchmarks share: work in several processes, and the true path of a folder."""

import multiprocessing
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TypeVar

from lpslam.poses import StampedPoses
from lpslam.sources.ground_truth import read_ground_truth

Task = TypeVar("Task")
Answer = TypeVar("Answer")


def beside(work: Callable[[Task], Answer], tasks: Sequence[Task], processes: int) -> Iterable[Answer]:
    """Do all tasks, in so many processes, and give their answers in order."""
    if processes <= 1 or len(tasks) <= 1:
        yield from map(work, tasks)
        return
    # Spawned, not forked: the parent may have threads already.
    with ProcessPoolExecutor(processes, multiprocessing.get_context("spawn")) as pool:
        yield from pool.map(work, tasks)


def truth_of(folder: Path) -> StampedPoses:
    """The true poses of a recording."""
    truth = read_ground_truth(folder)
    if truth is None:
        raise SystemExit(f"{folder} has no ground truth")
    return truth
