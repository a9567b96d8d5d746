"""What texts looked like when they were seen best: small pictures for whoever wants to see a sign, kept in the map."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Self

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SightingConfig
from lpslam.text.again.crops import Picture, cut_out

Array = NDArray[np.float64]

_NUMBERS = 7
"""Numbers that are kept of a sighting, besides its picture: see `SightingStore.to_arrays`."""
_JPEG, _LONGEST = b"\xff\xd8\xff", 1 << 20  # how a JPEG begins, and bytes of one that a crafted map may have


@dataclass(frozen=True, slots=True)
class Sighting:
    """A text as one keyframe's surroundings saw it.

    Attributes:
        keyframe: id of the reference keyframe.
        position: metres, in the frame of that keyframe's camera, of the text.
        seen: pixels of its letters' height, times how frontally they were seen, as in `SeenSize.effective`.
        jpeg: the picture, with what is around the text.
    """

    keyframe: int
    position: tuple[float, float, float]
    seen: float
    jpeg: bytes


def pictured(rgb: Picture, box: Array, letter_height: float, config: SightingConfig) -> bytes:
    """What is around a text's box (4, 2) of an image, as JPEG, no wider than it may be."""
    _, _, cut = cut_out(rgb, box, config.margin * letter_height)
    share = config.width / max(cut.shape[:2])
    if share < 1.0:
        cut = np.asarray(cv2.resize(cut, None, fx=share, fy=share, interpolation=cv2.INTER_AREA), np.uint8)
    _, jpeg = cv2.imencode(".jpg", cut[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, config.quality])
    return jpeg.tobytes()


@dataclass(slots=True)
class SightingStore:
    """The best sightings of each class, within a bound.

    Attributes:
        config: how many.
        by_class: class id → sightings.
    """

    config: SightingConfig
    by_class: dict[int, list[Sighting]] = field(default_factory=dict)
    _bytes: int = 0

    def __len__(self) -> int:
        return sum(map(len, self.by_class.values()))

    def wants(self, text_class: int, keyframe: int, seen: float) -> bool:
        """Whether a sighting of a class, seen so large, would be kept: its picture need not be made otherwise."""
        rival = self._rival(text_class, keyframe)
        return rival is None or seen > self.config.better * rival.seen

    def _rival(self, text_class: int, keyframe: int) -> Sighting | None:
        """In whose place one of a keyframe would be kept: of that keyframe, else the worst where there is no room."""
        own = self.by_class.get(text_class, [])
        same = [each for each in own if each.keyframe == keyframe]
        rivals = same or (own if len(own) >= self.config.of_class else [])
        return min(rivals, key=lambda each: each.seen, default=None)

    def keep(self, text_class: int, sighting: Sighting, is_remembered: Callable[[int], bool]) -> None:
        """Keep a sighting, in another's place if need be; where room is short, those of what is forgotten go.

        Args:
            text_class: id of its class.
            sighting: to keep.
            is_remembered: whether a class is in memory for long.
        """
        rival, own = self._rival(text_class, sighting.keyframe), self.by_class.setdefault(text_class, [])
        if rival is not None:
            own.remove(rival)
            self._bytes -= len(rival.jpeg)
        own.append(sighting)
        self._bytes += len(sighting.jpeg)
        if self._bytes > self.config.all_bytes:
            self.drop([key for key in self.by_class if not is_remembered(key)])
        while self._bytes > self.config.all_bytes:
            self.drop([min(self.by_class, key=lambda key: (max(each.seen for each in self.by_class[key]), key))])

    def drop(self, text_classes: Iterable[int]) -> None:
        """Forget the sightings of some classes."""
        for key in list(text_classes):
            self._bytes -= sum(len(each.jpeg) for each in self.by_class.pop(key, ()))

    def to_arrays(self, is_remembered: Callable[[int], bool]) -> dict[str, NDArray[np.generic]]:
        """Everything kept of what is remembered: a row of numbers for each, and all pictures one after the other."""
        kept = [(key, each) for key in sorted(self.by_class) if is_remembered(key) for each in self.by_class[key]]
        rows = [[key, each.keyframe, *each.position, each.seen, len(each.jpeg)] for key, each in kept]
        return {
            "rows": np.array(rows, np.float64).reshape(-1, _NUMBERS),
            "bytes": np.frombuffer(b"".join(each.jpeg for _, each in kept), np.uint8),
        }

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[np.generic]], config: SightingConfig) -> Self:
        """Restore what `to_arrays` gave; nothing where an older map has none.

        Raises:
            ValueError: rows and pictures do not belong together.
        """
        store = cls(config)
        if not arrays:
            return store
        rows, content = np.asarray(arrays["rows"], np.float64), arrays["bytes"]
        if rows.ndim != 2 or rows.shape[1] != _NUMBERS or content.dtype != np.uint8 or content.ndim != 1:
            raise ValueError("sightings of texts have a wrong shape")
        sizes = rows[:, -1]
        if not np.isfinite(rows).all() or (sizes < len(_JPEG)).any() or (sizes > _LONGEST).any():
            raise ValueError("sightings of texts have no size")
        if int(sizes.astype(np.int64).sum()) != len(content):
            raise ValueError("sightings of texts lack bytes")
        start = 0
        for row in rows:
            jpeg = content[start : start + int(row[-1])].tobytes()
            start += len(jpeg)
            if not jpeg.startswith(_JPEG):
                raise ValueError("a sighting of a text is no JPEG")
            place = float(row[2]), float(row[3]), float(row[4])
            store.by_class.setdefault(int(row[0]), []).append(Sighting(int(row[1]), place, float(row[5]), jpeg))
            store._bytes += len(jpeg)
        return store
