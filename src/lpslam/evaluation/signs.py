"""The true signs of a recording, as its signs.json lists them."""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.regular_files import text_of

Vector3 = tuple[float, float, float]
Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TrueLine:
    """One line of a sign.

    Attributes:
        text: as painted.
        centre: metres, middle of its ink, in the frame of the true trajectory.
        width, height: metres, of its ink.
        readable_frames: in how many frames a person could read it; None where not stated.
        role: primary, secondary, contact or list; empty where not stated.
    """

    text: str
    centre: Vector3
    width: float
    height: float
    readable_frames: int | None = None
    role: str = ""


@dataclass(frozen=True, slots=True)
class TrueSign:
    """One sign of the scene.

    Attributes:
        id: as listed; the row where none is given.
        text: as painted.
        aliases: what else a reader may rightly report.
        kind: shop, facility, warning, slogan and so on; empty where not stated.
        centre: metres, of `text`, in the frame of the true trajectory.
        normal: unit, out of its face; None where not stated.
        readable_frames: in how many frames a person could read it; None where not stated.
        lines: what is painted on it, line by line; empty where not stated.
        double_sided: whether its back shows the same.
        thickness: metres between its two sides.
        readable_from: seconds of the first frame in which a person could read it; None where there is none, or not
            stated.
        features: what it is made of, by factor; empty where not stated.
    """

    id: int | str
    text: str
    aliases: tuple[str, ...]
    kind: str
    centre: Vector3
    normal: Vector3 | None
    readable_frames: int | None
    lines: tuple[TrueLine, ...] = ()
    double_sided: bool = False
    thickness: float = 0.0
    readable_from: float | None = None
    features: Mapping[str, str] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Every name that is right."""
        return (self.text, *self.aliases)

    def middle_of(self, name: str, also: Collection[str] = ()) -> Array:
        """Where a landmark of one of its `names` should be, (3,) metres: the middle of the line or lines that it says.

        Of a double-sided sign, the middle as seen from its front.

        Args:
            name: one of its names.
            also: texts of further lines that the landmark says.
        """
        named = [line for line in self.lines if line.text == name or line.text in also]
        if not named and name != self.text:
            named = list(self.lines)
        if not named:
            return np.array(self.centre)
        if len(named) == 1 or self.normal is None:
            return np.array(named[0].centre)
        right = np.cross([0.0, 0.0, 1.0], self.normal)
        axes = np.array([right / max(float(np.linalg.norm(right)), 1e-9), [0.0, 0.0, 1.0]])
        origin = np.array(named[0].centre)
        places = np.array([axes @ (np.array(line.centre) - origin) for line in named])
        halves = np.array([[line.width, line.height] for line in named]) / 2.0
        middle = ((places - halves).min(axis=0) + (places + halves).max(axis=0)) / 2.0
        return np.asarray(origin + middle @ axes, dtype=np.float64)

    def distance(self, name: str, position: Array, also: Collection[str] = ()) -> float:
        """Metres between a position (3,) and where one of its `names` is; any depth within a double-sided sign is."""
        middle = self.middle_of(name, also)
        if self.double_sided and self.normal is not None:
            behind = float((middle - position) @ np.array(self.normal))
            middle = middle - np.clip(behind, 0.0, self.thickness) * np.array(self.normal)
        return float(np.linalg.norm(middle - position))

    def angle(self, normal: Array) -> float | None:
        """Degrees between a unit normal (3,) and the sign's, whichever side shows it; None where that is not known."""
        if self.normal is None:
            return None
        cosine = float(np.array(self.normal) @ normal)
        return float(np.degrees(np.arccos(np.clip(abs(cosine) if self.double_sided else cosine, -1.0, 1.0))))


def read_signs(path: Path) -> list[TrueSign] | None:
    """Read signs.json, or the signs.json of a recording's folder; None where there is none.

    Raises:
        UserError: the file is malformed; names the file and the sign.
    """
    path = path / "signs.json" if path.is_dir() else path
    try:
        if not path.exists():
            return None
        tree = json.loads(text_of(path))
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not JSON: {' '.join(str(error).split())}") from error
    listed = tree.get("signs") if isinstance(tree, dict) else tree
    if not isinstance(listed, list):
        raise UserError(f'{path}: expected {{"signs": [...]}} or a list of signs')
    return listed_signs(listed, path)


def listed_signs(listed: Sequence[Any], source: Path | str) -> list[TrueSign]:
    """Take signs as `signs.json` lists them.

    Raises:
        UserError: one is malformed; names the source and the sign.
    """
    return [_sign(entry, row, source) for row, entry in enumerate(listed)]


def _sign(entry: Any, row: int, source: Path | str) -> TrueSign:
    if not isinstance(entry, dict) or not isinstance(entry.get("text"), str):
        raise UserError(f"{source}: sign {row} has no text")
    centre = _centre(entry)
    if centre is None:
        raise UserError(f"{source}: sign {row} ({entry['text']!r}) needs its centre as three numbers")
    identifier = entry.get("id", row)
    aliases = entry.get("aliases") or []
    return TrueSign(
        id=identifier if isinstance(identifier, int | str) else row,
        text=entry["text"],
        aliases=tuple(str(alias) for alias in aliases) if isinstance(aliases, list) else (str(aliases),),
        kind=str(entry.get("kind", "")),
        centre=centre,
        normal=_vector(entry.get("normal")),
        readable_frames=_count(entry.get("readable_frames")),
        lines=_lines(entry.get("lines")),
        double_sided=entry.get("double_sided") is True,
        thickness=_number(entry.get("thickness")) or 0.0,
        readable_from=_number(entry.get("readable_from")),
        features=_features(entry.get("features")),
    )


def _lines(listed: Any) -> tuple[TrueLine, ...]:
    """The lines of a sign; none unless all of them are understood."""
    lines = []
    for entry in listed if isinstance(listed, list) else []:
        centre = _centre(entry) if isinstance(entry, dict) else None
        if centre is None or not isinstance(entry.get("text"), str):
            return ()
        width, height = _number(entry.get("width")) or 0.0, _number(entry.get("height")) or 0.0
        role = entry.get("role")
        frames = _count(entry.get("readable_frames"))
        lines.append(TrueLine(entry["text"], centre, width, height, frames, role if isinstance(role, str) else ""))
    return tuple(lines)


def _features(value: Any) -> dict[str, str]:
    return {str(key): str(each) for key, each in value.items()} if isinstance(value, dict) else {}


def _centre(entry: dict[str, Any]) -> Vector3 | None:
    return _vector(next((entry[key] for key in ("centre", "center", "position") if key in entry), None))


def _vector(value: Any) -> Vector3 | None:
    try:
        x, y, z = (float(number) for number in value)
    except (TypeError, ValueError):
        return None
    return (x, y, z) if np.isfinite((x, y, z)).all() else None


def _number(value: Any) -> float | None:
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else None


def _count(value: Any) -> int | None:
    number = _number(value)
    return None if number is None else int(number)
