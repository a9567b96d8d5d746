"""Series of pictures in a folder: which are colour and which depth, by what they hold and how they are called."""

import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from pathlib import Path

import numpy as np

from lpslam.sources.images import BadImageError, read_raw

_PICTURES = frozenset((".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".npy", ".npz"))
_NO_PICTURE_OF_A_VIEW = ("conf", "mask", "label", "seg", "semantic", "instance", "normal", "preview", "thumb")
_COLOUR = ("color", "colour", "rgb", "image", "img", "picture", "left", "cam")
_DEPTH = ("depth", "distance", "range", "disp")
_REGISTERED = ("align", "regist", "_to_")
_DEEPEST, _MOST_FILES, _MOST_ALIKE = 3, 400_000, 20


@dataclass(frozen=True, slots=True)
class Series:
    """Pictures of one kind that lie together.

    Attributes:
        paths: in order of their numbers, then of their names.
        is_depth: one channel of more than eight bits.
        is_float: of fractions: metres, as a rule.
    """

    paths: tuple[Path, ...]
    is_depth: bool
    is_float: bool = False


@dataclass(eq=False)
class Pictures:
    """The pictures and the other files of a folder and of those within it."""

    folder: Path

    @cached_property
    def files(self) -> list[Path]:
        """Files that may be pictures, lists or calibrations; hidden ones and those of archives' makers left out."""
        return sorted(islice(_walk(self.folder, _DEEPEST), _MOST_FILES))

    @cached_property
    def series(self) -> list[Series]:
        """All series of two pictures and more."""
        return [
            _series(paths)
            for paths in _of_one_kind(path for path in self.files if path.suffix.lower() in _PICTURES)
            if len(paths) > 1 and not _says(paths[0], self.folder, _NO_PICTURE_OF_A_VIEW)
        ]

    @cached_property
    def texts(self) -> list[Path]:
        """What may be a list or a calibration; of many files of one kind, as of labels for each picture, the first."""
        groups = _of_one_kind(path for path in self.files if path.suffix.lower() not in _PICTURES)
        return [path for paths in groups for path in (paths if len(paths) <= _MOST_ALIKE else paths[:1])]

    @property
    def colour(self) -> Series | None:
        """Of several the one that is called so, and then the longest."""
        return self._best(False, _COLOUR)

    @property
    def depth(self) -> Series | None:
        """Of several the one registered to colour, and then the longest."""
        return self._best(True, _REGISTERED)

    def _best(self, is_depth: bool, words: tuple[str, ...]) -> Series | None:
        of_kind = [each for each in self.series if each.is_depth == is_depth]
        return max(of_kind, key=lambda each: (_says(each.paths[0], self.folder, words), len(each.paths)), default=None)


def _walk(folder: Path, levels: int) -> Iterator[Path]:
    inner = []
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith((".", "__MACOSX")):
                continue
            if entry.is_file():
                yield Path(entry.path)
            elif levels and entry.is_dir(follow_symlinks=False):
                inner.append(Path(entry.path))
    for each in sorted(inner):
        yield from _walk(each, levels - 1)


def _of_one_kind(paths: Iterable[Path]) -> list[list[Path]]:
    """Files that lie together and are called alike but for their numbers."""
    groups: dict[tuple[Path, str, str], list[Path]] = {}
    for path in paths:
        letters = re.sub(r"[\d.\-_:T]+", "#", path.stem)
        groups.setdefault((path.parent, path.suffix.lower(), letters), []).append(path)
    return list(groups.values())


def _says(path: Path, folder: Path, words: tuple[str, ...]) -> bool:
    name = str(path.relative_to(folder)).lower()
    return any(word in name for word in words)


def _series(paths: list[Path]) -> Series:
    ordered = sorted(paths, key=lambda path: (len(path.stem) if path.stem.isdigit() else 0, _numbers(path), path.name))
    for path in ordered[:: max(len(ordered) // _PROBES, 1)]:
        try:
            raw = read_raw(path)
        except BadImageError:
            continue
        is_float = raw.dtype.kind == "f"
        return Series(tuple(ordered), raw.ndim == 2 and (is_float or raw.dtype != np.uint8), is_float)
    return Series(tuple(ordered), any(word in str(ordered[0]).lower() for word in _DEPTH))


def _numbers(path: Path) -> list[int]:
    return [int(digits) for digits in re.findall(r"\d{1,30}", path.stem)]


_PROBES = 4
"""Pictures of a series that are looked at, until one can be decoded."""
