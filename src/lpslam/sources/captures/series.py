"""Series of pictures in a folder: which are colour and which depth, by what they hold and how they are called.

A series lies in files of its own, or inside one: a video, or a file of arrays.
"""

import glob
import os
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice
from pathlib import Path

import numpy as np

from lpslam.errors import UserError
from lpslam.regular_files import is_regular
from lpslam.sources.captures.chunks import tree_in
from lpslam.sources.captures.holders import bare, pages, videos
from lpslam.sources.captures.holders.arrays import SUFFIXES, Arrays, arrays_of, arrays_of_many
from lpslam.sources.captures.holders.stacks import COLOUR_WORDS, DEPTH_WORDS, OTHER_WORDS
from lpslam.sources.captures.holders.videos import DeepVideo, Video
from lpslam.sources.depths.stated import stated_encoding
from lpslam.sources.images import BadImageError, image_size, read_raw
from lpslam.sources.inside import Holder, Inside, PictureFile
from lpslam.sources.yaml_tree import Tree

_IMAGES = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".pfm", ".exr")
_PICTURES = frozenset((*_IMAGES, ".npy", ".npz"))
_HOLDERS = videos.SUFFIXES | SUFFIXES | bare.SUFFIXES
_DEPTH = (*DEPTH_WORDS, "disp")
_ALONG_RAYS = ("distance_to_camera", "euclidean", "ray_depth", "radial")
_REGISTERED = ("align", "regist", "_to_")
_DEEPEST, _MOST_FILES, _MOST_ALIKE = 5, 400_000, 20


@dataclass(frozen=True, slots=True)
class Series:
    """Pictures of one kind that lie together.

    Attributes:
        paths: in order of their numbers, then of their names.
        is_depth: one channel of more than eight bits.
        is_float: of fractions: metres, as a rule.
        holder: the one file in which all lie; None where each is a file.
    """

    paths: tuple[PictureFile, ...]
    is_depth: bool
    is_float: bool = False
    holder: Holder | None = None

    @property
    def is_disparity(self) -> bool:
        """Whether it is depth that is called so."""
        return self.is_depth and "disp" in self._name

    @property
    def is_along_rays(self) -> bool:
        """Whether it is called the distance to the camera, as Isaac Sim has it, and not to its plane."""
        return self.is_depth and any(word in self._name for word in _ALONG_RAYS)

    @property
    def _name(self) -> str:
        """Of its first picture, with where that lies."""
        return "/".join(self.paths[0].parts[-2:]).lower()


@dataclass(eq=False)
class Pictures:
    """The pictures and the other files of a folder and of those within it, or of one file of arrays.

    Attributes:
        folder: the folder, or the file.
    """

    folder: Path

    @cached_property
    def files(self) -> list[Path]:
        """Files that may be pictures, lists or calibrations; hidden ones and those of archives' makers left out."""
        if self.folder.is_file():
            beside = self.folder.parent.glob(f"{glob.escape(self.folder.stem)}.*")
            return sorted(path for path in beside if is_regular(path))
        return sorted(islice(_walk(self.folder, _DEEPEST), _MOST_FILES))

    @cached_property
    def series(self) -> list[Series]:
        """All series of two pictures and more."""
        of_files = [
            _series(paths)
            for paths in _of_one_kind(path for path in self.files if path.suffix.lower() in _PICTURES)
            if len(paths) > 1
        ]
        of_holders = [_of_stack(stack, is_depth) for found in self._arrays.values() for stack, is_depth in found.stacks]
        return [each for each in (*_merged(of_files), *of_holders) if not self._says(each, OTHER_WORDS)]

    @cached_property
    def trees(self) -> dict[Path, Tree]:
        """What files of arrays, and the first pictures, say besides, by file."""
        found = {path: arrays.tree for path, arrays in self._arrays.items() if arrays.tree}
        firsts = [series.paths[0] for series in (self.depth, self.colour) if series is not None]
        said: Tree = {}
        for first in firsts:
            said |= tree_in(first)
        return found | {Path(str(firsts[-1])): said} if said else found

    @cached_property
    def notes(self) -> list[str]:
        """What was made of the times in files of arrays."""
        return sorted({note for arrays in self._arrays.values() for note in arrays.notes})

    @cached_property
    def texts(self) -> list[Path]:
        """What may be a list or a calibration; of many files of one kind, as of labels for each picture, the first."""
        groups = _of_one_kind(path for path in self.files if path.suffix.lower() not in _PICTURES | _HOLDERS)
        return [path for paths in groups for path in (paths if len(paths) <= _MOST_ALIKE else paths[:1])]

    @cached_property
    def colour(self) -> Series | None:
        """Of several the one that is called so, and then the longest; a video where no pictures are."""
        return self._best(False, COLOUR_WORDS) or self._video(is_depth=False)

    @cached_property
    def depth(self) -> Series | None:
        """Of several the one registered to colour, and then the longest; raw files or a video where no pictures are."""
        return self._best(True, _REGISTERED) or self._packed() or self._bare() or self._video(is_depth=True)

    @property
    def painted(self) -> Series | None:
        """Pictures of eight bits a channel that are called depth: packed numbers, or a view in false colours."""
        return next((each for each in self.series if not each.is_depth and self._says(each, DEPTH_WORDS)), None)

    def _packed(self) -> Series | None:
        """Pictures that are called depth where a text states how their channels make a number."""
        painted = self.painted
        if painted is None or painted == self.colour:
            return None
        encoding = stated_encoding(self.texts, str(painted.paths[0]))
        return replace(painted, is_depth=True) if encoding is not None and encoding.weights else None

    def _bare(self) -> Series | None:
        """Files of sixteen bits a pixel without a header, as many of one length as fit colour's size."""
        size = image_size(self.colour.paths[0]) if self.colour is not None else None
        if size is None:
            return None
        for group in _of_one_kind(path for path in self.files if path.suffix.lower() in bare.SUFFIXES):
            if len(group) > 1 and all(path.stat().st_size == bare.length_of(size) for path in group):
                return _series_in(bare.BareFiles(sorted(group, key=_order), size), True, is_float=False)
        return None

    def _best(self, is_depth: bool, words: tuple[str, ...]) -> Series | None:
        of_kind = [each for each in self.series if each.is_depth == is_depth]
        if not is_depth:
            # Depth in false colours is to be looked at.
            of_kind = [each for each in of_kind if not self._says(each, DEPTH_WORDS)] or of_kind
        return max(of_kind, key=lambda each: (self._says(each, words), len(each.paths)), default=None)

    def _video(self, *, is_depth: bool) -> Series | None:
        """The only video, or the only one that is called so."""
        found = [path for path in self.files if path.suffix.lower() in videos.SUFFIXES]
        of_kind = [path for path in found if any(word in path.stem.lower() for word in DEPTH_WORDS) == is_depth]
        called = [path for path in of_kind if is_depth or any(word in path.stem.lower() for word in COLOUR_WORDS)]
        chosen = of_kind if len(of_kind) == 1 else called
        if len(chosen) != 1:
            return None
        return _series_in(DeepVideo(chosen[0]) if is_depth else Video(chosen[0]), is_depth, is_float=False)

    @cached_property
    def _arrays(self) -> dict[Path, Arrays]:
        """What files of arrays hold; of many of one kind, each with the pictures of one frame, under the first."""
        found: dict[Path, Arrays] = {}
        for paths in _of_one_kind(path for path in self.files if path.suffix.lower() in SUFFIXES | pages.SUFFIXES):
            first, *others = sorted(paths, key=_order)
            if first.suffix.lower() in pages.SUFFIXES and (others or not pages.has_pages(first)):
                continue
            if others and first.suffix.lower() == ".npy":
                # Each is a picture.
                continue
            of_frames = self._arrays_in(first, *others) if others else Arrays()
            if len({is_depth for _, is_depth in of_frames.stacks}) > 1:
                found[first] = of_frames
            elif not others or first.suffix.lower() != ".npz":
                found |= {path: self._arrays_in(path) for path in (first, *others)[:_MOST_ALIKE]}
        return found

    def _arrays_in(self, *paths: Path) -> Arrays:
        try:
            return arrays_of(paths[0]) if len(paths) == 1 else arrays_of_many(paths)
        except UserError:
            # Where it is the recording itself, that is what is wrong with it.
            if self.folder.is_file():
                raise
            return Arrays()

    def _says(self, series: Series, words: tuple[str, ...]) -> bool:
        around = str(self.folder.parent if self.folder.is_file() else self.folder)
        return any(word in str(series.paths[0])[len(around) :].lower() for word in words)


def _walk(folder: Path, levels: int) -> Iterator[Path]:
    inner = []
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith((".", "__MACOSX")):
                continue
            path = Path(entry.path)
            if is_regular(path):
                yield path
            elif levels and entry.is_dir(follow_symlinks=False):
                inner.append(path)
    for each in sorted(inner):
        yield from _walk(each, levels - 1)


def _of_one_kind(paths: Iterable[Path]) -> list[list[Path]]:
    """Files that lie together and are called alike but for their numbers."""
    groups: dict[tuple[Path, str, str, str], list[Path]] = {}
    for path in paths:
        groups.setdefault((path.parent, "", path.suffix.lower(), _letters(path.stem)), []).append(path)
    whole: dict[tuple[Path, str, str, str], list[Path]] = {}
    for key, members in groups.items():
        # A folder for each frame: what is called alike in all of them belongs together.
        folder = key[0]
        is_alone = len(members) == 1 and any(letter.isdigit() for letter in folder.name)
        around = (folder.parent, _letters(folder.name), *key[2:]) if is_alone else key
        whole.setdefault(around, []).extend(members)
    return list(whole.values())


def _merged(series: Sequence[Series]) -> list[Series]:
    """Series with those that differ in nothing but the format of their files, where no picture is there twice."""
    whole: dict[tuple[object, ...], Series] = {}
    for each in series:
        first = each.paths[0]
        key = first.parent, _letters(first.stem), each.is_depth, each.is_float
        other = whole.get(key)
        if other is not None and {path.stem for path in other.paths}.isdisjoint(path.stem for path in each.paths):
            paths = [Path(str(path)) for path in (*other.paths, *each.paths)]
            ordered: list[Path] = sorted(paths, key=_order)
            whole[key] = replace(other, paths=tuple(ordered))
        else:
            whole[key if other is None else (*key, len(whole))] = each
    return list(whole.values())


def _letters(name: str) -> str:
    return re.sub(r"[\d.\-_:T]+", "#", name)


def _series(paths: list[Path]) -> Series:
    ordered = sorted(paths, key=_order)
    for path in ordered[:: max(len(ordered) // _PROBES, 1)]:
        try:
            raw = read_raw(path)
        except BadImageError:
            continue
        is_float = raw.dtype.kind == "f"
        return Series(tuple(ordered), raw.ndim == 2 and (is_float or raw.dtype != np.uint8), is_float)
    return Series(tuple(ordered), any(word in str(ordered[0]).lower() for word in _DEPTH))


def _of_stack(stack: Holder, is_depth: bool) -> Series:
    return _series_in(stack, is_depth, is_float=stack.picture(0).dtype.kind == "f")


def _series_in(holder: Holder, is_depth: bool, *, is_float: bool) -> Series:
    pictures = tuple(Inside(holder, index) for index in range(len(holder)))
    return Series(pictures, is_depth, is_float and is_depth, holder)


def _order(path: Path) -> tuple[int, list[int], str]:
    return len(path.stem) if path.stem.isdigit() else 0, _numbers(path), path.name


def _numbers(path: Path) -> list[int]:
    return [int(digits) for digits in re.findall(r"\d{1,30}", path.stem) or re.findall(r"\d{1,30}", path.parent.name)]


_PROBES = 4
"""Pictures of a series that are looked at, until one can be decoded."""
