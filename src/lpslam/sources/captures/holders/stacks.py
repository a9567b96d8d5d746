"""Arrays of many pictures, one along their first or last axis: which axis that is, and what they show."""

import math
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.sources.images import MOST_PIXELS, TOO_LARGE, BadImageError, decoded_image
from lpslam.sources.inside import refuse_many

COLOUR_WORDS = ("color", "colour", "rgb", "bgr", "image", "img", "picture", "left", "cam", "gray", "grey", "mono")
DEPTH_WORDS = ("depth", "distance", "range")
OTHER_WORDS = ("conf", "mask", "label", "seg", "semantic", "instance", "normal", "pose", "traj", "preview", "thumb")
_CHANNELS, _LEAST_SIDE = (1, 3, 4), 32
_MOST_NUMBERS = 4 * MOST_PIXELS
"""Of one picture."""
MALFORMED = (OSError, ValueError, EOFError, KeyError, IndexError, TypeError, RuntimeError, OverflowError, struct.error,
             zipfile.BadZipFile, zlib.error, MemoryError)  # fmt: skip
"""What libraries raise of arrays that are damaged, or state what cannot be."""
MOST_BYTES = 1 << 32
"""Of what is kept in memory as a whole."""


def numbers_in(shape: Sequence[int]) -> float:
    """How many numbers an array states that it has; more than any integer holds, where it lies."""
    return math.prod(float(side) for side in shape)


@dataclass(frozen=True, slots=True)
class Entry:
    """An array of a file, of which parts can be read.

    Attributes:
        name: where in the file it lies, parts by slashes.
        shape: as numpy has it; of encoded pictures how many there are.
        kind: of its type: u, i, f or other letters, as numpy names them.
        bits: of a number.
        read: gives the part that an index along the first axis names, the whole for ().
        is_encoded: its items are files of pictures.
        is_reversed: its axes are in reversed order, as MATLAB writes HDF5.
    """

    name: str
    shape: tuple[int, ...]
    kind: str
    bits: int
    read: Callable[[Any], Any]
    is_encoded: bool = False
    is_reversed: bool = False

    @property
    def says(self) -> str:
        """Its name in lower-case letters."""
        return self.name.lower()


class Stack:
    """An array as a holder of pictures."""

    def __init__(self, path: Path, entry: Entry, *, is_last: bool, channel_axis: int | None) -> None:
        self.path = path / entry.name if entry.name else path
        self._entry, self._is_last, self._channel_axis = entry, is_last, channel_axis
        self._whole: NDArray[Any] | None = None
        self.times: NDArray[np.float64] | None = None
        self._count = self._oriented_shape[-1 if is_last else 0]
        self._refuse_large()
        first = self.picture(0)
        self.size = first.shape[1], first.shape[0]

    def __len__(self) -> int:
        return self._count

    @property
    def _oriented_shape(self) -> tuple[int, ...]:
        return self._entry.shape[::-1] if self._entry.is_reversed else self._entry.shape

    def _refuse_large(self) -> None:
        """Raise a `UserError` where pictures are too many or too large, as the array states it, which may be a lie."""
        refuse_many(self.path, self._count)
        numbers = numbers_in(self._entry.shape)
        if not self._entry.is_encoded and numbers > _MOST_NUMBERS * max(self._count, 1):
            raise UserError(f"{self.path}: its pictures are {TOO_LARGE}")
        if self._is_read_whole and numbers * self._entry.bits / 8 > MOST_BYTES:
            raise UserError(
                f"{self.path} has more than {MOST_BYTES >> 30} GB and can be read as a whole only; save it with the "
                "pictures along its first axis"
            )

    @property
    def _is_read_whole(self) -> bool:
        """Whether one picture is no part that can be read alone: they lie along the last axis."""
        return not self._entry.is_encoded and self._is_last != self._entry.is_reversed

    def picture(self, index: int) -> NDArray[Any]:
        """See `Holder`."""
        try:
            found = self._part(index)
        except MALFORMED as error:
            raise BadImageError(f"{self.path.name} {index} cannot be read ({type(error).__name__})") from error
        if self._channel_axis is not None:
            found = np.moveaxis(found, self._channel_axis, -1)
            found = found[..., 0] if found.shape[-1] == 1 else found
        return found[..., ::-1] if found.ndim == 3 and "bgr" in self._entry.says else found

    def _part(self, index: int) -> NDArray[Any]:
        entry = self._entry
        if entry.is_encoded:
            return _decoded(bytes(np.asarray(entry.read(index), np.uint8)), f"{self.path.name} {index}")
        if not self._is_read_whole:
            found = np.asarray(entry.read(index))
            return found.T if entry.is_reversed else found
        if self._whole is None:
            whole = np.asarray(entry.read(()))
            self._whole = whole.T if entry.is_reversed else whole
        return np.asarray(self._whole[..., index] if self._is_last else self._whole[index])


def stacks_of(path: Path, entries: Sequence[Entry]) -> list[tuple[Stack, bool]]:
    """The series of pictures among a file's arrays, and of each whether it is depth."""
    colours = [each for each in entries if _is_colour(each)]
    is_last = any(_channel_axis(_oriented(each)) == 2 for each in colours if len(each.shape) == 4)
    found: list[tuple[Stack, bool]] = []
    for entry in (*colours, *(each for each in entries if _is_depth(each))):
        shape = _oriented(entry)
        axis = _channel_axis(shape) if len(shape) == 4 else None
        # Without the axis of the pictures, channels come one earlier.
        inner = None if axis is None else (axis if is_last else axis - 1)
        try:
            stack = Stack(path, entry, is_last=is_last, channel_axis=inner)
        except BadImageError:
            continue
        if len(stack) > 1:
            found.append((stack, entry not in colours))
    return found


def combined(entries: Sequence[Entry]) -> list[Entry]:
    """Entries with those that are called alike but for their number, and have one shape, as one array."""
    groups: dict[tuple[str, tuple[int, ...], str], list[Entry]] = {}
    for entry in entries:
        groups.setdefault((re.sub(r"\d+", "#", entry.name), entry.shape, entry.kind), []).append(entry)
    whole: list[Entry] = []
    for members in groups.values():
        first = members[0]
        if len(members) < 2 or not is_picture(first.shape):
            whole += members
            continue
        ordered = sorted(members, key=lambda each: [int(digits) for digits in re.findall(r"\d{1,18}", each.name)])

        def read(index: Any, ordered: Sequence[Entry] = tuple(ordered)) -> Any:
            return ordered[index].read(())

        name = re.sub(r"[\d_/.\-]+$", "", first.name) or first.name
        whole.append(Entry(name, (len(ordered), *first.shape), first.kind, first.bits, read))
    return whole


def is_picture(shape: tuple[int, ...]) -> bool:
    """Whether an array of a shape may be one picture."""
    return len(shape) in (2, 3) and min(shape[:2]) >= _LEAST_SIDE


def _is_colour(entry: Entry) -> bool:
    if _says(entry, OTHER_WORDS) or _says(entry, DEPTH_WORDS):
        return False
    if entry.is_encoded:
        return True
    is_eight = entry.bits == 8 and entry.kind == "u"
    if len(entry.shape) == 4:
        return _channel_axis(_oriented(entry)) is not None and (is_eight or _says(entry, COLOUR_WORDS))
    return len(entry.shape) == 3 and is_eight and _says(entry, COLOUR_WORDS) and _is_stack(_oriented(entry))


def _is_depth(entry: Entry) -> bool:
    if _says(entry, OTHER_WORDS) or (entry.kind, entry.bits) == ("u", 8):
        return False
    if entry.is_encoded:
        return _says(entry, DEPTH_WORDS)
    shape = _oriented(entry)
    if len(shape) == 4:
        axis = _channel_axis(shape)
        return axis is not None and shape[axis] == 1 and _says(entry, DEPTH_WORDS)
    is_named = _says(entry, DEPTH_WORDS) or not _says(entry, COLOUR_WORDS)
    return len(shape) == 3 and entry.kind in "uif" and is_named and _is_stack(shape)


def _is_stack(shape: tuple[int, ...]) -> bool:
    return min(shape[1:]) >= _LEAST_SIDE or min(shape[:2]) >= _LEAST_SIDE


def _oriented(entry: Entry) -> tuple[int, ...]:
    return entry.shape[::-1] if entry.is_reversed else entry.shape


def _channel_axis(shape: tuple[int, ...]) -> int | None:
    """Behind the pictures' sides, before them, or between them and the axis of the pictures."""
    return next((axis for axis in (3, 1, 2) if shape[axis] in _CHANNELS), None) if len(shape) == 4 else None


def _says(entry: Entry, words: tuple[str, ...]) -> bool:
    return any(word in entry.says for word in words)


def _decoded(data: bytes, name: str) -> NDArray[Any]:
    picture = decoded_image(data, name, cv2.IMREAD_UNCHANGED)
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB) if picture.ndim == 3 else picture)
