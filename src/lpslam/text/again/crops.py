"""What is kept of pictures: cut-outs around texts whose name is not sure yet, to be looked at again."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SecondLookConfig
from lpslam.text.reading.legibility import SeenSize

Array = NDArray[np.float64]
Picture = NDArray[np.uint8]

_NUMBERS = 7 + 16
"""Numbers that are kept of a crop, besides its pixels: see `CropStore.to_arrays`."""

_LARGEST_SIDE = 1 << 14
"""Pixels; no camera gives more, and a crafted map may not ask for more."""


@dataclass(frozen=True, slots=True, eq=False)
class Crop:
    """A cut-out around one sighting of a text.

    Attributes:
        timestamp: seconds.
        keyframe: id of the reference keyframe.
        keyframe_from_camera: 4×4.
        left, top: raw pixels, of its first pixel in the image.
        rgb: (h, w, 3).
        seen: how large the text was seen.
    """

    timestamp: float
    keyframe: int
    keyframe_from_camera: Array
    left: int
    top: int
    rgb: Picture
    seen: SeenSize

    def corners(self, camera: PinholeCamera) -> tuple[Array, Array]:
        """Its outermost pixels' middles, (4, 2) each: in the cut-out, and as directions without distortion, pixels."""
        right, bottom = self.rgb.shape[1] - 1.0, self.rgb.shape[0] - 1.0
        own = np.array([[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]])
        return own, camera.undistort(own + np.array([self.left, self.top]))


def cut_out(rgb: Picture, box: Array, margin: float) -> tuple[int, int, Picture]:
    """The pixels around a box (4, 2), so many pixels wider on every side: its left, its top and a copy (h, w, 3)."""
    height, width = rgb.shape[:2]
    left, top = np.clip(np.floor(box.min(axis=0) - margin), 0, [width - 2, height - 2]).astype(int).tolist()
    right, bottom = np.clip(np.ceil(box.max(axis=0) + margin), [left + 1, top + 1], [width - 1, height - 1]).astype(int)
    return left, top, rgb[top : bottom + 1, left : right + 1].copy()


@dataclass(slots=True)
class CropStore:
    """The crops of each class, the best seen of them, within a bound.

    Attributes:
        config: how many.
        by_class: class id → crops.
    """

    config: SecondLookConfig
    by_class: dict[int, list[Crop]] = field(default_factory=dict)
    _bytes: int = 0

    def __len__(self) -> int:
        return sum(map(len, self.by_class.values()))

    def keep(self, text_class: int, crop: Crop, is_wanted: Callable[[int], bool]) -> None:
        """Keep a crop if it is among the best of its class; where room is short, those that nobody wants go.

        Args:
            text_class: id of its class.
            crop: to keep.
            is_wanted: whether crops of a class will be looked at, as far as is known now.
        """
        if crop.rgb.nbytes > self.config.crop_bytes:
            return
        own = self.by_class.setdefault(text_class, [])
        own.append(crop)
        self._bytes += crop.rgb.nbytes
        if len(own) > self.config.crops:
            # Of equally large ones the later stays: views should be far apart.
            worst = min(own, key=lambda each: each.seen.effective)
            own.remove(worst)
            self._bytes -= worst.rgb.nbytes
        if self._bytes > self.config.all_bytes:
            self._make_room(is_wanted)

    def drop(self, text_classes: Iterable[int]) -> None:
        """Forget the crops of some classes."""
        for key in list(text_classes):
            self._bytes -= sum(each.rgb.nbytes for each in self.by_class.pop(key, ()))

    def _make_room(self, is_wanted: Callable[[int], bool]) -> None:
        self.drop([key for key in self.by_class if not is_wanted(key)])
        while self._bytes > self.config.all_bytes:
            largest = max(self.by_class, key=lambda key: (sum(each.rgb.nbytes for each in self.by_class[key]), key))
            worst = min(self.by_class[largest], key=lambda each: each.seen.effective)
            self.by_class[largest].remove(worst)
            self._bytes -= worst.rgb.nbytes

    def to_arrays(self) -> dict[str, NDArray[np.generic]]:
        """Everything kept: a row of numbers for each crop, and all pixels one after the other."""
        crops = [(key, each) for key in sorted(self.by_class) for each in self.by_class[key]]
        rows = [
            [
                *(key, each.timestamp, each.keyframe, each.left, each.top, *each.rgb.shape[:2]),
                *each.keyframe_from_camera.ravel(),
                *each.seen,
            ]
            for key, each in crops
        ]
        pixels = [each.rgb.ravel() for _, each in crops]
        return {
            "rows": np.array(rows, np.float64).reshape(-1, _NUMBERS + 2),
            "pixels": np.concatenate([*pixels, np.zeros(0, np.uint8)]),
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[np.generic]], config: SecondLookConfig) -> Self:
        """Restore what `to_arrays` gave; nothing where an older map has none.

        Raises:
            ValueError: rows and pixels do not belong together.
        """
        store = cls(config)
        if not arrays:
            return store
        rows, pixels = np.asarray(arrays["rows"], np.float64), arrays["pixels"]
        if rows.ndim != 2 or rows.shape[1] != _NUMBERS + 2 or pixels.dtype != np.uint8 or pixels.ndim != 1:
            raise ValueError("crops of texts have a wrong shape")
        sizes = rows[:, 5:7]
        if not np.isfinite(rows).all() or (sizes < 2).any() or (sizes > _LARGEST_SIDE).any():
            raise ValueError("crops of texts have no size")
        if int((sizes.astype(np.int64).prod(axis=1) * 3).sum()) != len(pixels):
            raise ValueError("crops of texts lack pixels")
        start = 0
        for row in rows:
            key, keyframe, left, top, height, width = (int(row[column]) for column in (0, 2, 3, 4, 5, 6))
            rgb = np.asarray(pixels[start : start + 3 * height * width], np.uint8).reshape(height, width, 3)
            start += rgb.size
            seen = SeenSize(float(row[-2]), float(row[-1]))
            crop = Crop(float(row[1]), keyframe, row[7:23].reshape(4, 4), left, top, rgb, seen)
            store.by_class.setdefault(key, []).append(crop)
            store._bytes += rgb.nbytes
        return store
