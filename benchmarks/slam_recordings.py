"""The recordings of the benchmarks: malls rendered once into a folder, and what is on disk."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lpslam.config import SimulationConfig
from lpslam.poses import StampedPoses
from lpslam.simulation.source import MallSource
from lpslam.simulation.writer import write_sequence
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.open import open_source
from side_by_side import beside, truth_of


@dataclass(frozen=True)
class MallKind:
    """Malls alike, of seeds on which nothing is tuned."""

    options: SimulationConfig
    first_seed: int


KINDS = {
    "loop": MallKind(SimulationConfig(), 51),
    "figure-eight": MallKind(SimulationConfig(layout="figure-eight", loop_length=90.0), 61),
    "dark": MallKind(SimulationConfig(light=0.3, max_turn_rate=134.0), 71),
}

TEXT_KINDS = {
    "dark": KINDS["dark"].options,
    "duplicates": SimulationConfig(
        duplicate_distances=(3.0, 3.0, 3.0, 15.0, 15.0, 15.0),
        similar_names=True,
        loop_length=34.0,
        way="there-and-back",
    ),
    "chinese": SimulationConfig(language="chinese"),
    "protruding": SimulationConfig(projecting_share=1.0, way="there-and-back", loop_length=24.0),
}
TEXT_SETS = {
    "dev": ("dark-201", "dark-202", "duplicates-203", "duplicates-204", "chinese-205", "protruding-206"),
    "eval": ("dark-301", "dark-302", "duplicates-303", "duplicates-304", "chinese-305", "protruding-306"),
}
"""Malls whose text is mapped: one set to develop on, one that nothing is tuned on."""


_OPTIONS = {
    **{kind: each.options for kind, each in KINDS.items()},
    **{f"{which}-{kind}": options for which in TEXT_SETS for kind, options in TEXT_KINDS.items()},
}


@dataclass(frozen=True)
class Recording:
    """A folder that can be opened as a source, with a ground truth."""

    name: str
    kind: str
    folder: Path

    @classmethod
    def at(cls, folder: Path) -> "Recording":
        """A folder named by kind and seed is known as such a mall, any other is just a recording."""
        kind = folder.name.rpartition("-")[0]
        return cls(folder.name, kind if kind in _OPTIONS else "recording", folder)

    def open(self) -> ImagePairSource:
        """Its frames, decoded as they are asked for."""
        return open_source(self.folder)

    @property
    def truth(self) -> StampedPoses:
        """The true poses."""
        return truth_of(self.folder)

    def mall(self, visit: int = 0) -> MallSource:
        """The mall of which this is a recording, to be walked again."""
        if self.kind not in _OPTIONS:
            raise SystemExit(f"{self.name} is no mall of the benchmark: its places cannot be drawn anew")
        return MallSource(int(self.name.rsplit("-", 1)[1]), options=_OPTIONS[self.kind], visit=visit)


def rendered(cache: Path, kinds: Sequence[str] | None, count: int, processes: int) -> list[Recording]:
    """So many malls of each kind; those that are not in the cache yet are rendered.

    Args:
        cache: a folder to a recording, named by kind and seed.
        kinds: names in `KINDS`; all without.
        count: malls of each kind.
        processes: that render at the same time.
    """
    return _all_rendered(
        [
            Recording.at(cache / f"{kind}-{seed}")
            for kind in kinds or KINDS
            for seed in range(KINDS[kind].first_seed, KINDS[kind].first_seed + count)
        ],
        processes,
    )


def rendered_for_text(cache: Path, which: str, kinds: Sequence[str] | None, processes: int) -> list[Recording]:
    """The malls of a set in `TEXT_SETS`; those that are not in the cache yet are rendered.

    Args:
        cache: a folder to a recording, named by set, kind and seed.
        which: the set.
        kinds: names in `TEXT_KINDS`; all without.
        processes: that render at the same time.
    """
    names = [name for name in TEXT_SETS[which] if not kinds or name.rpartition("-")[0] in kinds]
    return _all_rendered([Recording.at(cache / f"{which}-{name}") for name in names], processes)


def _all_rendered(recordings: list[Recording], processes: int) -> list[Recording]:
    missing = [recording for recording in recordings if not _is_complete(recording.folder)]
    if missing:
        print(f"rendering {len(missing)} malls: two to eight minutes each", flush=True)
        for recording in beside(_render, missing, processes):
            print(f"rendered {recording.name}", flush=True)
    return recordings


def _is_complete(folder: Path) -> bool:
    return (folder / "depth.txt").is_file()  # written last


def _render(recording: Recording) -> Recording:
    if recording.folder.exists():
        shutil.rmtree(recording.folder)
    write_sequence(recording.mall(), recording.folder)
    return recording
