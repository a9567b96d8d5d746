"""The ground truth of a sign: what it says, where it hangs, how large its letters are, when it can be read."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SignLine:
    """One line of a sign.

    Attributes:
        text: what it says.
        corners: (4, 3) metres, of its ink: upper left, upper right, lower right, lower left, seen from the front.
        letter_height: metres, of a capital or of a Chinese character.
        readable_frames: in how many frames a person could read it; see `visibility.views_of`.
        role: what it is for, "primary", "secondary", "contact" or "list"; empty where nobody said.
    """

    text: str
    corners: Array
    letter_height: float
    readable_frames: int = 0
    role: str = ""

    @property
    def centre(self) -> Array:
        """(3,) metres, middle of the ink."""
        return np.asarray(self.corners.mean(axis=0), dtype=np.float64)

    def as_json(self) -> dict[str, Any]:
        """The entry among a sign's lines."""
        return {
            "text": self.text,
            "centre": rounded(self.centre, 4),
            "width": round(_distance(self.corners[0], self.corners[1]), 4),
            "height": round(_distance(self.corners[0], self.corners[3]), 4),
            "letter_height": round(self.letter_height, 4),
            "readable_frames": self.readable_frames,
        } | ({"role": self.role} if self.role else {})


@dataclass(frozen=True, slots=True, eq=False)
class Sign:
    """One sign; a double-sided one is one sign.

    Attributes:
        id: number in the world.
        aliases: its other lines, and all lines together: what else than `text` a reader may rightly report.
        kind: shop, restaurant, facility, warning or slogan.
        normal: (3,) unit vector out of the (front) face.
        corners: (4, 3) of the ink of all lines: upper left, upper right, lower right, lower left, seen from the front.
        lines: what it says, the most prominent first.
        thickness: metres of its board.
        double_sided: whether its back shows the same; the back's ink is the front's, turned about the vertical axis.
        face: row of the sign's front in the scene, for visibility tests; the back is the next row.
        readable_frames: in how many frames a person could read `text`; see `visibility.views_of`.
        readable_from: seconds of the first of them; None without.
        features: what it is made of, by factor ("lettering", "ageing", "script"); empty where nobody said.
    """

    id: int
    aliases: tuple[str, ...]
    kind: str
    normal: Array
    corners: Array
    lines: tuple[SignLine, ...]
    thickness: float
    double_sided: bool
    face: int
    readable_frames: int = 0
    readable_from: float | None = None
    features: Mapping[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """Its most prominent line."""
        return self.lines[0].text

    @property
    def centre(self) -> Array:
        """(3,) middle of `text`'s ink, metres in the ground-truth world frame (z up)."""
        return self.lines[0].centre

    @property
    def letter_height(self) -> float:
        """Metres, of `text`."""
        return self.lines[0].letter_height

    @property
    def width(self) -> float:
        """Metres, of the ink of all lines."""
        return _distance(self.corners[0], self.corners[1])

    @property
    def height(self) -> float:
        """Metres, of the ink of all lines."""
        return _distance(self.corners[0], self.corners[3])

    def as_json(self) -> dict[str, Any]:
        """The entry of `signs.json`."""
        return {
            "id": self.id,
            "text": self.text,
            "aliases": list(self.aliases),
            "kind": self.kind,
            "centre": rounded(self.centre, 4),
            "normal": rounded(self.normal, 5),
            "width": round(self.width, 4),
            "height": round(self.height, 4),
            "letter_height": round(self.letter_height, 4),
            "lines": [line.as_json() for line in self.lines],
            "double_sided": self.double_sided,
            "thickness": round(self.thickness, 4),
            "readable_frames": self.readable_frames,
            "readable_from": None if self.readable_from is None else round(self.readable_from, 4),
        } | ({"features": dict(self.features)} if self.features else {})


def rounded(vector: Array, digits: int) -> list[float]:
    """A vector as JSON holds it."""
    return [round(float(value), digits) for value in vector]


def _distance(first: Array, second: Array) -> float:
    return float(np.linalg.norm(second - first))
