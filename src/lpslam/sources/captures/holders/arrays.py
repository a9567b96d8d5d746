"""Files of arrays: numpy's `.npy`, `.npz`, HDF5 (extra `arrays`), MATLAB's `.mat`, TIFF. None of them is executed."""

import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.config import JobsConfig
from lpslam.errors import MissingExtraError, UserError
from lpslam.sources.archives import unpack
from lpslam.sources.calibrations.bare_numbers import matrix_of
from lpslam.sources.captures.holders import pages
from lpslam.sources.captures.holders.stacks import (
    MALFORMED,
    MOST_BYTES,
    OTHER_WORDS,
    Entry,
    Stack,
    combined,
    is_picture,
    numbers_in,
    stacks_of,
)
from lpslam.sources.clocks import in_seconds
from lpslam.sources.inside import Inside, PictureFile
from lpslam.sources.unpacked_once import unpacked_once
from lpslam.sources.yaml_tree import Tree

SUFFIXES = frozenset((".npz", ".npy", ".h5", ".hdf5", ".mat"))
_MOST_ENTRIES, _SMALL, _DEEPEST = 100_000, 64, 50
_MOST_NUMBERS = 1 << 24
"""Of matrices that are one for each picture."""
_LONGEST_TEXT = 8 << 16
"""Bits."""
_IN_MEMORY = 1 << 28
"""Bytes of an array that is unpacked into memory; a larger one is unpacked to the disk."""
_OF_TIME = ("time", "stamp", "clock", "sec")
_HDF5 = b"\x89HDF\r\n\x1a\n"
_HDF5_BEGINS = (0, 512)
"""Bytes at which HDF5 begins; MATLAB writes a header before it."""


@dataclass(slots=True)
class Arrays:
    """What a file of arrays holds.

    Attributes:
        stacks: series of pictures, and whether each is depth.
        tree: what else it says, as a tree of lower-case keys, for whoever reads a calibration.
        notes: what was made of its times.
    """

    stacks: list[tuple[Stack, bool]] = field(default_factory=list)
    tree: Tree = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def arrays_of(path: Path) -> Arrays:
    """Find the pictures, their times and the calibration in a file of arrays.

    Raises:
        UserError: it cannot be read, or holds more than fits into memory.
        MissingExtraError: HDF5 cannot be read here.
    """
    try:
        entries = combined(list(_entries(path)))
        found = Arrays(stacks_of(path, entries))
        taken = {stack.path for stack, _ in found.stacks}
        small = [each for each in entries if path / each.name not in taken]
        found.notes = _time(found.stacks, small)
        found.tree = _tree(small)
        return found
    except MALFORMED as error:
        raise UserError(f"{path} holds no arrays that can be read ({_short(error)})") from error


def _short(error: Exception) -> str:
    return " ".join(str(error).split())[:120]


def arrays_of_many(paths: Sequence[Path]) -> Arrays:
    """The same of many files, in order, that hold one picture of each kind; what the first says holds for all.

    Raises:
        UserError: the first cannot be read.
        MissingExtraError: HDF5 cannot be read here.
    """
    try:
        first = list(_entries(paths[0]))
        pictures = [each for each in first if is_picture(each.shape)]
        found = Arrays(stacks_of(paths[0].parent, [_one_a_file(each, paths) for each in pictures]))
        found.tree = _tree([each for each in first if each not in pictures])
        return found
    except MALFORMED as error:
        raise UserError(f"{paths[0]} holds no arrays that can be read ({_short(error)})") from error


def _one_a_file(entry: Entry, paths: Sequence[Path]) -> Entry:
    """An array of each of many files, named as one in the first, as one array."""

    def read(index: Any) -> Any:
        found = next((each for each in _listed(paths[index]) if each.name == entry.name), None)
        if found is None or found.shape != entry.shape:
            raise ValueError(f"{paths[index].name} has no array {entry.name} of that shape")
        part = np.asarray(found.read(()))
        return part.T if entry.is_reversed else part

    shape = entry.shape[::-1] if entry.is_reversed else entry.shape
    return Entry(entry.name, (len(paths), *shape), entry.kind, entry.bits, read)


def times_beside(pictures: Sequence[PictureFile]) -> NDArray[np.float64] | None:
    """Seconds (n,) that each of many `.npz` holds beside its picture, as one number; None where they do not."""
    if any(isinstance(each, Inside) or each.suffix.lower() != ".npz" for each in pictures):
        return None
    stamps: list[float] = []
    for path in pictures:
        try:
            clocks = [each for each in _of_numpy(Path(str(path))) if not each.shape and _is_time(each)]
            if len(clocks) != 1:
                return None
            stamps.append(float(clocks[0].read(())))
        except (OSError, ValueError, EOFError, KeyError, UserError, zipfile.BadZipFile):
            # A damaged picture is one that cannot be used; its time is not known.
            return None
    return in_seconds(np.array(stamps))[0]


def _listed(path: Path) -> list[Entry]:
    """The arrays of a file, listed once for all pictures of its frame."""
    status = path.stat()
    return _lately_listed(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=1)
def _lately_listed(path: Path, _changed: int, _size: int) -> list[Entry]:
    return list(_entries(path))


def _entries(path: Path) -> Iterator[Entry]:
    if path.suffix.lower() == ".npy":
        array = np.load(path, mmap_mode="r", allow_pickle=False)
        yield _entry("", array.shape, array.dtype, lambda index: array[index])
    elif path.suffix.lower() == ".npz":
        yield from _of_numpy(path)
    elif path.suffix.lower() in pages.SUFFIXES:
        yield from pages.entries_of(path)
    elif _is_hdf5(path):
        yield from _of_hdf5(path)
    else:
        yield from _of_matlab(path)


def _entry(name: str, shape: Sequence[int], kind: np.dtype[Any], read: Callable[[Any], Any]) -> Entry:
    return Entry(name, tuple(int(side) for side in shape), kind.kind, 8 * kind.itemsize, read)


class _Once:
    """An array that is unpacked when a part of it is wanted first, and kept."""

    def __init__(self, load: Callable[[], NDArray[Any]]) -> None:
        self._load, self._array = load, None  # type: Callable[[], NDArray[Any]], NDArray[Any] | None

    def __call__(self, index: Any) -> Any:
        if self._array is None:
            self._array = self._load()
        return self._array[index]


def _of_numpy(path: Path) -> Iterator[Entry]:
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist()[:_MOST_ENTRIES]:
            if not member.filename.endswith(".npy"):
                continue
            name = member.filename.removesuffix(".npy")
            with archive.open(member) as file:
                version = np.lib.format.read_magic(file)
                read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
                shape, _, kind = read(file)
            if kind.hasobject:
                # Objects are a program that would run.
                continue
            is_large = numbers_in(shape) * kind.itemsize > _IN_MEMORY

            def load(name: str = name, is_large: bool = is_large) -> NDArray[Any]:
                if is_large:
                    return _unpacked(path, name)
                with np.load(path, allow_pickle=False) as file:
                    return np.asarray(file[name])

            yield _entry(name, shape, kind, _Once(load))


def _unpacked(path: Path, name: str) -> NDArray[Any]:
    """A large array of an `.npz`, which stays on the disk until a part of it is wanted."""

    def unpack_all(folder: Path, room: int) -> None:
        unpack(path, folder, JobsConfig(unpacked_bytes=room))

    folder = unpacked_once(path, unpack_all)
    return np.asarray(np.load(folder / f"{name}.npy", mmap_mode="r", allow_pickle=False))


def _of_hdf5(path: Path) -> Iterator[Entry]:
    try:
        import h5py
    except ImportError:
        raise MissingExtraError(f"HDF5 ({path.name})", "arrays") from None
    file = h5py.File(path, "r")
    found: list[Any] = []

    def visit(name: str, item: Any) -> None:
        # Links to other files are not visited; arrays that lie in other files are left out.
        is_array = isinstance(item, h5py.Dataset) and item.shape is not None and len(found) < _MOST_ENTRIES
        if is_array and not item.external and not item.is_virtual:
            found.append(item)
        for key, value in list(item.attrs.items())[:_SMALL]:
            number = np.asarray(None if isinstance(value, h5py.Empty) else value)
            if number.size <= _SMALL and number.dtype.kind in "uifSU":
                found.append((f"{name}/{key}".strip("/"), number))

    visit("", file)
    file.visititems(visit)
    for item in found:
        if isinstance(item, tuple):
            yield _entry(item[0], item[1].shape, item[1].dtype, item[1].__getitem__)
            continue
        name, encoded = item.name.strip("/"), h5py.check_vlen_dtype(item.dtype)
        if encoded is not None and np.dtype(encoded) == np.uint8 and item.ndim == 1:
            yield Entry(name, item.shape, "O", 0, item.__getitem__, is_encoded=True)
        elif item.dtype.kind in "uifSU":
            entry = _entry(name, item.shape, item.dtype, item.__getitem__)
            is_reversed = "MATLAB_class" in item.attrs
            yield Entry(name, entry.shape, entry.kind, entry.bits, entry.read, is_reversed=is_reversed)
        elif h5py.check_string_dtype(item.dtype) is not None and item.size == 1:
            yield _entry(name, (), np.dtype("U1"), np.asarray(item.asstr()[()]).__getitem__)


def _of_matlab(path: Path) -> Iterator[Entry]:
    from scipy.io import loadmat, whosmat
    from scipy.io.matlab import MatReadError

    kinds = {"uint8": "u1", "uint16": "u2", "int16": "i2", "int32": "i4", "single": "f4", "double": "f8"}
    try:
        listed = whosmat(path)
    except MatReadError as error:
        raise ValueError(str(error)) from error
    # Each is kept as a whole from when its first picture is wanted.
    whole = 0.0
    for name, shape, kind in listed:
        if kind not in kinds:
            continue
        whole += numbers_in(shape) * np.dtype(kinds[kind]).itemsize
        if whole > MOST_BYTES:
            raise UserError(
                f"{path}: its arrays unpack to more than {MOST_BYTES >> 30} GB; save them as .npy, or as pictures"
            )

        def load(name: str = name) -> NDArray[Any]:
            return np.asarray(loadmat(path, variable_names=[name])[name])

        yield _entry(name, shape, np.dtype(kinds[kind]), _Once(load))


def _is_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        begin = file.read(_HDF5_BEGINS[-1] + len(_HDF5))
    return any(begin[at : at + len(_HDF5)] == _HDF5 for at in _HDF5_BEGINS)


def _time(stacks: Sequence[tuple[Stack, bool]], small: list[Entry]) -> tuple[str, ...]:
    """Give every stack its times: those that are called so and are as many; what is used is taken out of `small`."""
    notes = {""}
    clocks = [each for each in small if sum(side != 1 for side in each.shape) == 1 and _is_time(each)]
    for stack, is_depth in stacks:
        fitting = [each for each in clocks if max(each.shape) == len(stack)]
        if fitting:
            words = ("depth",) if is_depth else ("color", "colour", "rgb", "image")
            best = max(fitting, key=lambda each: any(word in each.says for word in words))
            stamps = np.asarray(best.read(()), np.float64).ravel()
            if not np.isfinite(stamps).all():
                notes.add(f"{best.name} holds times that are no numbers, and is not used")
                continue
            stack.times, note = in_seconds(stamps)
            notes.add(note)
    for each in clocks:
        small.remove(each)
    return tuple(sorted(notes - {""}))


def _is_time(entry: Entry) -> bool:
    return entry.kind in "uif" and any(word in entry.says for word in _OF_TIME) and len(entry.shape) <= 2


def _tree(small: Sequence[Entry]) -> Tree:
    """What the small arrays say; a matrix of a camera for each picture as the first, where all are the same."""
    tree: Tree = {}
    # A number that has attributes of its own is a number.
    for entry in sorted(small, key=lambda each: each.name.count("/")):
        if entry.is_encoded or any(word in entry.says for word in OTHER_WORDS):
            continue
        value = _value(entry)
        *sections, name = [part for part in entry.says.split("/") if part] or [""]
        if len(sections) > _DEEPEST:
            continue
        inner = tree
        for section in sections:
            inner = inner.setdefault(section, {})
            if not isinstance(inner, dict):
                break
        if value is not None and isinstance(inner, dict):
            inner[name] = value
    return tree


def _value(entry: Entry) -> Any:
    size = numbers_in(entry.shape)
    is_of_each = len(entry.shape) == 3 and max(entry.shape[1:]) <= 4 and size <= _MOST_NUMBERS
    if (size > _SMALL and not is_of_each) or entry.bits > _LONGEST_TEXT:
        return None
    array = np.asarray(entry.read(()))
    if array.dtype.kind in "SUO":
        text = array.ravel()[0] if array.size == 1 else ""
        return text.decode("utf-8", "replace") if isinstance(text, bytes) else str(text)
    if array.dtype.kind not in "uif":
        return None
    array = array.T if entry.is_reversed else array
    if array.ndim == 3:
        if not (array == array[:1]).all():
            return None
        array = array[0]
    if array.size == 1:
        return float(array.ravel()[0])
    camera = matrix_of([float(number) for number in array.ravel()]) if array.ndim == 2 else None
    if camera is not None:
        return [camera["fx"], 0.0, camera["cx"], 0.0, camera["fy"], camera["cy"], 0.0, 0.0, 1.0]
    return [float(number) for number in array.ravel()]
