"""A folder of labelled pictures of boards: pictures beside `labels.json`.

    {"images": {"file.png": ["line", {"text": "line", "role": "primary", "box": [left, top, right, bottom]}]},
     "boards": {"file.png": {"width": 2.1, "depth": false, "glows": true, "corners": [[x, y], ...],
                             "features": {"lettering": "neon"}}}}

A line is its text, or an object with a role and a box in pixels; `boards` may be absent, and so may all in it: metres
of the board's width, whether depth sensors see it, its four corners in the photograph (upper left first, clockwise;
the board is cut out and straightened, and boxes are those of the straightened board), and what it is made of.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.regular_files import bytes_of, text_of

Image = NDArray[np.uint8]
Box = tuple[float, float, float, float]
LABELS = "labels.json"
MAX_PICTURES = 500  # in one folder: more is no set of boards, and would fill the memory
MAX_TEXT = 200  # characters of one line
MAX_SIDE = 8000  # pixels of a picture's longer side
WIDTHS = (0.2, 12.0)  # metres that a board may be wide


@dataclass(frozen=True, slots=True)
class LabelledLine:
    """One line of a board.

    Attributes:
        text: what a person reads.
        role: primary, secondary, contact or list; empty where not stated.
        box: left, top, right, bottom of its ink in pixels; None where not stated.
        letter_height: of a capital or a character, pixels; 0 where not known.
    """

    text: str
    role: str = ""
    box: Box | None = None
    letter_height: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class LabelledBoard:
    """A picture of a board and what stands on it.

    Attributes:
        name: of its file.
        image: (h, w, 3) RGB, seen from the front.
        lines: the most prominent first; perhaps none.
        width: metres; None where not stated.
        has_depth: whether depth sensors see it.
        glows: whether it shines by itself.
        features: what it is made of, by factor ("lettering", "ageing", "script").
    """

    name: str
    image: Image
    lines: tuple[LabelledLine, ...]
    width: float | None = None
    has_depth: bool = True
    glows: bool = False
    features: Mapping[str, str] = field(default_factory=dict)


def write_labelled(folder: Path, boards: Sequence[LabelledBoard]) -> None:
    """Write pictures and their labels; the folder is created if need be."""
    folder.mkdir(parents=True, exist_ok=True)
    images: dict[str, Any] = {}
    described: dict[str, Any] = {}
    for board in boards:
        cv2.imwrite(str(folder / board.name), cv2.cvtColor(board.image, cv2.COLOR_RGB2BGR))
        images[board.name] = [_line_entry(line) for line in board.lines]
        described[board.name] = {
            "width": board.width,
            "depth": board.has_depth,
            "glows": board.glows,
            "features": dict(board.features),
        }
    text = json.dumps({"images": images, "boards": described}, ensure_ascii=False, indent=1)
    (folder / LABELS).write_text(text + "\n", encoding="utf-8")


def _line_entry(line: LabelledLine) -> Any:
    if not line.role and line.box is None:
        return line.text
    entry: dict[str, Any] = {"text": line.text, "role": line.role}
    if line.box is not None:
        entry |= {"box": [round(value, 1) for value in line.box], "letter_height": round(line.letter_height, 1)}
    return entry


def read_labelled(folder: Path) -> list[LabelledBoard]:
    """Read a labelled folder, boards straightened.

    Raises:
        UserError: there is none, or something in it is not as it should be; names the file and the entry.
    """
    tree = _tree(folder / LABELS)
    images, described = tree.get("images"), tree.get("boards", {})
    if not isinstance(images, dict) or not isinstance(described, dict):
        raise UserError(f'{folder / LABELS}: expected {{"images": {{file: [line, ...]}}}}')
    if len(images) > MAX_PICTURES:
        raise UserError(f"{folder / LABELS} lists {len(images)} pictures; at most {MAX_PICTURES} are taken")
    return [_board(folder, name, lines, described.get(name, {})) for name, lines in images.items()]


def _tree(path: Path) -> dict[str, Any]:
    try:
        tree = json.loads(text_of(path))
    except (ValueError, RecursionError) as error:
        raise UserError(f"{path} is not JSON: {' '.join(str(error).split())}") from error
    if not isinstance(tree, dict):
        raise UserError(f'{path}: expected {{"images": {{file: [line, ...]}}}}')
    return tree


def _board(folder: Path, name: str, lines: Any, about: Any) -> LabelledBoard:
    where = f"{folder / LABELS}: {name!r}"
    # A name is a file of this folder and nothing else.
    if not name or name != Path(name).name or name in (".", "..") or "\\" in name or "\0" in name:
        raise UserError(f"{where} is no name of a file in the folder")
    if not isinstance(lines, list):
        raise UserError(f"{where} needs a list of lines")
    if not isinstance(about, dict):
        raise UserError(f"{where}: what is said of the board must be an object")
    features = about.get("features", {})
    if not isinstance(features, dict):
        raise UserError(f"{where}: features must be an object")
    image = _picture(folder / name)
    if (corners := about.get("corners")) is not None:
        image = _straightened(image, _numbers(corners, (4, 2), f"{where}: corners"))
    width = about.get("width")
    if width is not None:
        width = float(_numbers(width, (), f"{where}: width"))
        if not WIDTHS[0] <= width <= WIDTHS[1]:
            raise UserError(f"{where}: width is {width}; it must be {WIDTHS[0]} to {WIDTHS[1]} metres")
    return LabelledBoard(
        name=name,
        image=image,
        lines=tuple(_line(entry, where) for entry in lines),
        width=width,
        has_depth=about.get("depth") is not False,
        glows=about.get("glows") is True,
        features={str(key): str(value) for key, value in features.items()},
    )


def _line(entry: Any, where: str) -> LabelledLine:
    given = {"text": entry} if isinstance(entry, str) else entry
    text = given.get("text") if isinstance(given, dict) else None
    if not isinstance(text, str) or not text.strip() or len(text) > MAX_TEXT:
        raise UserError(f"{where} has a line without a text of 1 to {MAX_TEXT} characters")
    role, box = given.get("role", ""), given.get("box")
    if not isinstance(role, str):
        raise UserError(f"{where}: the role of {text!r} must be a word")
    height = float(_numbers(given.get("letter_height", 0.0), (), f"{where}: letter_height of {text!r}"))
    if box is None:
        return LabelledLine(text, role, None, height)
    left, top, right, bottom = _numbers(box, (4,), f"{where}: box of {text!r}").tolist()
    if not (left < right and top < bottom):
        raise UserError(f"{where}: box of {text!r} must be left, top, right, bottom")
    return LabelledLine(text, role, (left, top, right, bottom), height)


def _numbers(value: Any, shape: tuple[int, ...], what: str) -> NDArray[np.float64]:
    try:
        numbers = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array([np.nan])
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise UserError(f"{what} must be {'x'.join(map(str, shape)) or 'one'} finite numbers")
    return numbers


def _picture(path: Path) -> Image:
    data = np.frombuffer(bytes_of(path), np.uint8)
    try:
        picture = cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
    except cv2.error:
        picture = None
    if picture is None or min(picture.shape[:2]) < 8 or max(picture.shape[:2]) > MAX_SIDE:
        raise UserError(f"{path} is no picture of 8 to {MAX_SIDE} pixels a side")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)


def _straightened(image: Image, corners: NDArray[np.float64]) -> Image:
    """The quadrilateral of a photograph, seen from its front."""
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    width, height = (int(np.clip(max(sides[i], sides[i + 2]), 8, MAX_SIDE)) for i in (0, 1))
    flat = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    matrix = cv2.getPerspectiveTransform(corners.astype(np.float32), flat)
    return np.asarray(cv2.warpPerspective(image, matrix, (width, height), flags=cv2.INTER_LINEAR), np.uint8)
