"""The ground truth of a sign: what it says, where it hangs, how large its letters are."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Sign:
    """One sign; a double-sided one is one sign.

    Attributes:
        id: number in the world.
        text: its most prominent line.
        aliases: its other lines, and all lines together: what else a reader may rightly report.
        kind: shop, restaurant, facility, warning or slogan.
        centre: (3,) middle of `text`'s ink, metres in the ground-truth world frame (z up).
        normal: (3,) unit vector out of the (front) face.
        corners: (4, 3) of the ink of all lines: upper left, upper right, lower right, lower left, seen from the front.
        letter_height: metres, of `text`.
        double_sided: whether its back shows the same; the back's ink is the front's, turned about the vertical axis.
        face: row of the sign's front in the scene, for visibility tests; the back is the next row.
        readable_frames: in how many frames a person could read it; see `visibility.is_readable`.
    """

    id: int
    text: str
    aliases: tuple[str, ...]
    kind: str
    centre: NDArray[np.float64]
    normal: NDArray[np.float64]
    corners: NDArray[np.float64]
    letter_height: float
    double_sided: bool
    face: int
    readable_frames: int = 0

    @property
    def width(self) -> float:
        """Metres, of the ink of all lines."""
        return float(np.linalg.norm(self.corners[1] - self.corners[0]))

    @property
    def height(self) -> float:
        """Metres, of the ink of all lines."""
        return float(np.linalg.norm(self.corners[3] - self.corners[0]))

    def as_json(self) -> dict[str, Any]:
        """The entry of `signs.json`."""
        return {
            "id": self.id,
            "text": self.text,
            "aliases": list(self.aliases),
            "kind": self.kind,
            "centre": [round(float(value), 4) for value in self.centre],
            "normal": [round(float(value), 5) for value in self.normal],
            "width": round(self.width, 4),
            "height": round(self.height, 4),
            "letter_height": round(self.letter_height, 4),
            "double_sided": self.double_sided,
            "readable_frames": self.readable_frames,
        }
