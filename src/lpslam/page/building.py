"""One HTML file of a map: the ground from above, signs as words, a field that searches or asks.

No request leaves the page but to its own server: the policy in its head forbids it. Whatever signs say travels as JSON
in which no tag can begin, and is shown as text.
"""

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.types import Landmark

Array = NDArray[np.float64]

LANGUAGES = ("en", "zh", "ja", "ko", "es", "de", "fr")
_FINEST, _MOST_PIXELS = 0.02, 2400  # metres a pixel of the picture, and pixels to a side at most
_ROUND = 1.0  # metres shown around all there is
_MOST_POSES, _MOST_VARIANTS = 2000, 8
_FREE_COLOUR, _OCCUPIED_COLOUR = (90, 150, 110, 45), (100, 108, 120, 255)


def write_page(world: LanguageMap, out: Path) -> Path:
    """Write a page that needs no server: it shows the map, and finds signs by name.

    Raises:
        UserError: the file cannot be written.
    """
    try:
        out.write_text(page_of(world, live=False), encoding="utf-8")
    except OSError as error:
        raise UserError(f"page {out} cannot be written ({error.strerror}); choose another place") from error
    return out


def page_of(world: LanguageMap, *, live: bool, name: str = "") -> str:
    """The page as text.

    Args:
        world: the map.
        live: whether a server beside it answers questions.
        name: of the map, as the server knows it.
    """
    style, script = _asset("page.css"), _asset("page.js")
    parts = {
        "@policy@": policy(live),
        "@style@": style,
        "@script@": script,
        "@data@": _as_json(_record(world, live, name)),
    }
    page = _asset("page.html")
    # Each mark once, from the last on: what is put in is never looked through for marks.
    for mark in sorted(parts, key=page.index, reverse=True):
        before, _, after = page.partition(mark)
        page = before + parts[mark] + after
    return page


def policy(live: bool) -> str:
    """What the page may load and run: its own style and script, pictures inside it, and its own server."""
    asked = "; connect-src 'self'" if live else ""
    style, script = (_digest(_asset(each)) for each in ("page.css", "page.js"))
    runs = f"img-src data:; style-src '{style}'; script-src '{script}'"
    return f"default-src 'none'; {runs}{asked}; base-uri 'none'; form-action 'none'"


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


@cache
def _asset(name: str) -> str:
    return files("lpslam.page").joinpath("assets", name).read_text(encoding="utf-8")


def _as_json(tree: Any) -> str:
    """JSON in which no tag begins or ends, and no line ends unseen."""
    text = json.dumps(tree, ensure_ascii=False, separators=(",", ":"))
    for char in "<>&\u2028\u2029":
        text = text.replace(char, f"\\u{ord(char):04x}")
    return text


def _record(world: LanguageMap, live: bool, name: str) -> dict[str, Any]:
    positions = world.frame_poses().positions
    positions = positions[np.isfinite(positions).all(axis=1)]
    landmarks = [mark for mark in world.landmarks() if np.isfinite(mark.position).all()]
    picture, picture_extent = _picture(world)
    everything = [positions[:, :2], np.array([mark.position[:2] for mark in landmarks]).reshape(-1, 2)]
    corners = np.concatenate([*everything, np.array(picture_extent).reshape(2, 2) if picture else np.empty((0, 2))])
    if not len(corners):
        corners = np.zeros((1, 2))
    low, high = corners.min(axis=0) - _ROUND, corners.max(axis=0) + _ROUND
    folder = files("lpslam.page").joinpath("words")
    return {
        "title": clean_text(world.source) or "lpslam",
        "name": name,
        "live": live,
        "extent": [*_rounded(low), *_rounded(high)],
        "picture": picture,
        "picture_extent": _rounded(np.array(picture_extent)),
        "trajectory": [_rounded(at[:2]) for at in positions[:: max(1, -(-len(positions) // _MOST_POSES))]],
        "signs": [_sign(mark) for mark in landmarks],
        "words": {each: json.loads(folder.joinpath(f"{each}.json").read_text("utf-8")) for each in LANGUAGES},
    }


def _sign(mark: Landmark) -> dict[str, Any]:
    counted = sorted(mark.variants.items(), key=lambda each: (-each[1], each[0]))
    return {
        "id": mark.id,
        "name": clean_text(mark.name),
        "lines": [clean_text(line.text) for line in mark.lines],
        "variants": {clean_text(text): int(count) for text, count in counted[:_MOST_VARIANTS]},
        "position": _rounded(mark.position),
        "normal": _rounded(np.nan_to_num(mark.normal)),
        "spread": round(float(np.nan_to_num(mark.spread)), 3),
        "observations": int(mark.observations),
        "confidence": round(float(np.nan_to_num(mark.confidence)), 3),
        "is_landmark": mark.is_landmark,
    }


def _rounded(values: Array) -> list[float]:
    return [round(float(value), 3) for value in values]


def _picture(world: LanguageMap) -> tuple[str, tuple[float, float, float, float]]:
    """A data URL of the room from above (PNG), and its left, bottom, right and top in metres; empty without scans."""
    cloud, colours = world.room_from_above()
    if not len(cloud):
        return "", (0.0, 0.0, 0.0, 0.0)
    low, high = np.percentile(cloud[:, :2], 0.5, axis=0) - 0.5, np.percentile(cloud[:, :2], 99.5, axis=0) + 0.5
    pixel = max(_FINEST, float((high - low).max()) / _MOST_PIXELS)
    columns, rows = np.maximum(np.ceil((high - low) / pixel), 1).astype(int)
    image = np.zeros((rows, columns, 4), np.uint8)
    grid = world.grid()
    if grid is not None:
        _paint_ground(image, grid, low, pixel)
    at = np.floor((cloud[:, :2] - low) / pixel).astype(int)
    seen = ((at >= 0) & (at < [columns, rows])).all(axis=1)
    for dy, dx in ((0, 0), (0, 1), (1, 0), (1, 1)):
        v, u = np.minimum(at[seen, 1] + dy, rows - 1), np.minimum(at[seen, 0] + dx, columns - 1)
        image[v, u, :3], image[v, u, 3] = colours[seen], 255
    _, png = cv2.imencode(".png", cv2.cvtColor(image[::-1], cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_PNG_COMPRESSION, 9])
    extent = (float(low[0]), float(low[1]), float(low[0] + columns * pixel), float(low[1] + rows * pixel))
    return "data:image/png;base64," + base64.b64encode(png.tobytes()).decode("ascii"), extent


def _paint_ground(image: NDArray[np.uint8], grid: Grid, low: Array, pixel: float) -> None:
    """Paint free ground and what is in the way into an image (rows, columns, 4) whose first row is the lowest."""
    row, column = (
        np.floor((low[axis] + (np.arange(image.shape[1 - axis]) + 0.5) * pixel - grid.origin[axis]) / grid.resolution)
        for axis in (1, 0)
    )
    inside = np.outer((row >= 0) & (row < grid.shape[0]), (column >= 0) & (column < grid.shape[1]))
    rows, columns = row.clip(0, grid.shape[0] - 1).astype(int), column.clip(0, grid.shape[1] - 1).astype(int)
    values = grid.values[rows[:, None], columns]
    image[inside & (values == FREE)] = _FREE_COLOUR
    image[inside & (values == OCCUPIED)] = _OCCUPIED_COLOUR
