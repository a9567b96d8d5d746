"""The true signs of a recording, as its signs.json lists them."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.errors import UserError

Vector3 = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class TrueSign:
    """One sign of the scene.

    Attributes:
        id: as listed; the row where none is given.
        text: as painted.
        aliases: what else a reader may rightly report.
        kind: shop, facility, warning, slogan and so on; empty where not stated.
        centre: metres, in the frame of the true trajectory.
        normal: unit, out of its face; None where not stated.
        readable_frames: in how many frames a person could read it; None where not stated.
    """

    id: int | str
    text: str
    aliases: tuple[str, ...]
    kind: str
    centre: Vector3
    normal: Vector3 | None
    readable_frames: int | None


def read_signs(path: Path) -> list[TrueSign] | None:
    """Read signs.json, or the signs.json of a recording's folder; None where there is none.

    Raises:
        UserError: the file is malformed; names the file and the sign.
    """
    path = path / "signs.json" if path.is_dir() else path
    try:
        tree = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    except OSError as error:
        raise UserError(f"{path} cannot be read ({error.strerror})") from error
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not JSON: {' '.join(str(error).split())}") from error
    listed = tree.get("signs") if isinstance(tree, dict) else tree
    if not isinstance(listed, list):
        raise UserError(f'{path}: expected {{"signs": [...]}} or a list of signs')
    return [_sign(entry, row, path) for row, entry in enumerate(listed)]


def _sign(entry: Any, row: int, path: Path) -> TrueSign:
    if not isinstance(entry, dict) or not isinstance(entry.get("text"), str):
        raise UserError(f"{path}: sign {row} has no text")
    centre = _vector(next((entry[key] for key in ("centre", "center", "position") if key in entry), None))
    if centre is None:
        raise UserError(f"{path}: sign {row} ({entry['text']!r}) needs its centre as three numbers")
    identifier, frames = entry.get("id", row), entry.get("readable_frames")
    aliases = entry.get("aliases") or []
    return TrueSign(
        id=identifier if isinstance(identifier, int | str) else row,
        text=entry["text"],
        aliases=tuple(str(alias) for alias in aliases) if isinstance(aliases, list) else (str(aliases),),
        kind=str(entry.get("kind", "")),
        centre=centre,
        normal=_vector(entry.get("normal")),
        readable_frames=int(frames) if isinstance(frames, int | float) and np.isfinite(frames) else None,
    )


def _vector(value: Any) -> Vector3 | None:
    try:
        x, y, z = (float(number) for number in value)
    except (TypeError, ValueError):
        return None
    return (x, y, z) if np.isfinite((x, y, z)).all() else None
