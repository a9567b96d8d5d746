"""The worlds of the benchmark: rendered once into a folder."""

import json
import shutil
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from lpslam.poses import StampedPoses
from lpslam.simulation.worlds.factors import EDITION, SETS, World, draw_world
from lpslam.simulation.worlds.source import WorldSource
from lpslam.simulation.worlds.writing import read_world, write_world
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import open_source
from side_by_side import beside, truth_of


@dataclass(frozen=True)
class WorldRecording:
    """A rendered world."""

    folder: Path

    @property
    def name(self) -> str:
        """By its seed."""
        return self.folder.name

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Its world.json."""
        return read_world(self.folder)[1]

    @cached_property
    def world(self) -> World:
        """Its factors."""
        return read_world(self.folder)[0]

    @property
    def truth(self) -> StampedPoses:
        """The true poses."""
        return truth_of(self.folder)

    @property
    def length(self) -> float:
        """Metres by which the trajectory's error is divided."""
        turned = 0.5 * self.facts["turned_radians"] if self.world.motion == "rotation" else 0.0
        return float(self.facts["path_metres"] + turned)

    def open(self) -> ImagePairSource:
        """Its frames."""
        return open_source(self.folder)

    def source(self, visit: int) -> WorldSource:
        """The world, to be passed through again."""
        return WorldSource(self.world, visit)


def numbered(which: str, text: str) -> list[int]:
    """Seeds of a set from numbers that count from 1: 1-40, or 3,7,20-25."""
    seeds = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds += [SETS[which] + number - 1 for number in range(int(first), int(last or first) + 1)]
    return seeds


def rendered(cache: Path, seeds: Iterable[int], processes: int) -> list[WorldRecording]:
    """The worlds of some seeds; those that are not in the cache yet are rendered."""
    folders = {seed: cache / draw_world(seed).name for seed in seeds}
    missing = [(seed, folder) for seed, folder in folders.items() if not _is_complete(folder)]
    for line in beside(_render, missing, processes):
        print(line, flush=True)
    return [WorldRecording(folder) for folder in folders.values()]


def _is_complete(folder: Path) -> bool:
    if not (folder / "depth.txt").is_file():  # written last
        return False
    return bool(json.loads((folder / "world.json").read_text(encoding="utf-8")).get("edition") == EDITION)


def _render(task: tuple[int, Path]) -> str:
    import cv2

    cv2.setNumThreads(1)
    seed, folder = task
    if folder.exists():
        shutil.rmtree(folder)
    started = time.process_time()
    source = WorldSource(draw_world(seed))
    write_world(source, folder)
    spent = time.process_time() - started
    factors = " ".join(source.world.factors().values())
    return f"rendered {folder.name} ({factors}): {len(source)} frames, {1000 * spent / len(source):.0f} ms each"
