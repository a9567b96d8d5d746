"""Files of pixels without a header: depth of sixteen bits, the lowest byte first, as RealSense's viewer exports it."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.sources.images import BadImageError

SUFFIXES = frozenset((".raw", ".bin"))
_BYTES = 2


def length_of(size: tuple[int, int]) -> int:
    """Bytes of a picture of a width and a height."""
    return _BYTES * size[0] * size[1]


class BareFiles:
    """A series of such files as a holder of pictures.

    Args:
        paths: in order.
        size: width and height, pixels.
    """

    def __init__(self, paths: Sequence[Path], size: tuple[int, int]) -> None:
        self.path, self._paths, self.size = paths[0].parent, tuple(paths), size
        self.times: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self._paths)

    def name_of(self, index: int) -> str:
        """The name of a file without its ending."""
        return self._paths[index].stem

    def picture(self, index: int) -> NDArray[np.uint16]:
        """See `Holder`."""
        path = self._paths[index]
        try:
            found = np.fromfile(path, "<u2", length_of(self.size) // _BYTES)
        except OSError as error:
            raise BadImageError(f"{path.name} cannot be read ({error.strerror})") from error
        if len(found) * _BYTES != length_of(self.size):
            raise BadImageError(f"{path.name} is truncated")
        return found.reshape(self.size[1], self.size[0])
