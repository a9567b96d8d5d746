"""Pictures that lie with many others in one file: a video, an array of numpy, HDF5."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError


class Holder(Protocol):
    """A file that holds pictures of one kind.

    Attributes:
        path: the file, followed by where in it they lie, as `take.h5/camera/depth`.
        size: width and height of its pictures, pixels.
        times: seconds of each (n,), rising, where the file says them.
    """

    path: Path
    size: tuple[int, int]
    times: NDArray[np.float64] | None

    def __len__(self) -> int: ...

    def picture(self, index: int) -> NDArray[Any]:
        """A picture as it is stored: (height, width), or (height, width, 3 or 4) in the order red, green, blue.

        Raises:
            BadImageError: it cannot be read.
        """
        ...


@dataclass(frozen=True, slots=True)
class Inside:
    """One picture of a holder, which goes by the names that a file of its own would have."""

    holder: Holder
    index: int

    @property
    def name(self) -> str:
        """As in reports."""
        return f"{self.holder.path.name} {self.index}"

    @property
    def stem(self) -> str:
        """Its number alone, or the name that it has in the holder."""
        named = getattr(self.holder, "name_of", None)
        return str(self.index) if named is None else str(named(self.index))

    @property
    def parent(self) -> Path:
        """The holder."""
        return self.holder.path

    @property
    def parts(self) -> tuple[str, ...]:
        """As of a path."""
        return (*self.holder.path.parts, self.stem)

    def __str__(self) -> str:
        """As a path is written."""
        return f"{self.holder.path}/{self.index}"


_MOST_PICTURES = 1_000_000
"""In one file: nine hours at thirty a second."""


def refuse_many(path: Path, count: int) -> None:
    """Raise a `UserError` where a file says that it has more pictures than any recording: each is listed."""
    if count > _MOST_PICTURES:
        raise UserError(f"{path} claims to hold {count:,} pictures, more than any recording; cut it, or copy it again")


PictureFile = Path | Inside
"""Where a picture lies."""
