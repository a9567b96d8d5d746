"""What a run shows as messages of Foxglove in JSON (https://docs.foxglove.dev/docs/sdk/schemas).

Whatever a sign says is a string of JSON: its letters, cleaned, and nothing else.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.ground.grid import FREE, OCCUPIED, Grid
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.board_poses import board_colour, board_pose, board_size, placed
from lpslam.slam.state import EventKind, SlamEvent
from lpslam.sources.writing.messages import BYTES, NUMBER, NUMBERS, SIZE, TEXT, TIME, calibration_fields, in_letters
from lpslam.sources.writing.pixels import packed
from lpslam.text.types import BoxFate, FrameReading, Landmark

Array = NDArray[np.float64]

MAP, CAMERA = "map", "camera_color_optical_frame"

_NUMERIC = {"type": "number"}
_BOOL = {"type": "boolean"}


def _object(**fields: Any) -> dict[str, Any]:
    return {"type": "object", "properties": fields}


def _list(item: Any) -> dict[str, Any]:
    return {"type": "array", "items": item}


_VECTOR = _object(x=_NUMERIC, y=_NUMERIC, z=_NUMERIC)
_TURN = _object(x=_NUMERIC, y=_NUMERIC, z=_NUMERIC, w=_NUMERIC)
_POSE = _object(position=_VECTOR, orientation=_TURN)
_COLOUR = _object(r=_NUMERIC, g=_NUMERIC, b=_NUMERIC, a=_NUMERIC)
_SPOT = _object(x=_NUMERIC, y=_NUMERIC)
_PACKED = _list(_object(name=TEXT, offset=NUMBER, type=NUMBER))
_LINE = {"type": NUMBER, "pose": _POSE, "thickness": _NUMERIC, "scale_invariant": _BOOL, "color": _COLOUR}
_ENTITY = _object(
    timestamp=TIME,
    frame_id=TEXT,
    id=TEXT,
    lifetime=TIME,
    frame_locked=_BOOL,
    metadata=_list(_object(key=TEXT, value=TEXT)),
    cubes=_list(_object(pose=_POSE, size=_VECTOR, color=_COLOUR)),
    texts=_list(
        _object(pose=_POSE, billboard=_BOOL, font_size=_NUMERIC, scale_invariant=_BOOL, color=_COLOUR, text=TEXT)
    ),
    lines=_list(_object(**_LINE, points=_list(_VECTOR))),
)
SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.CameraCalibration": {
        **SIZE, "distortion_model": TEXT, "D": NUMBERS, "K": NUMBERS, "R": NUMBERS, "P": NUMBERS,
    },
    "foxglove.CompressedImage": {"data": BYTES, "format": TEXT},
    "foxglove.ImageAnnotations": {
        "points": _list(
            _object(timestamp=TIME, type=NUMBER, points=_list(_SPOT), outline_color=_COLOUR, thickness=_NUMERIC)
        ),
        "texts": _list(
            _object(timestamp=TIME, position=_SPOT, text=TEXT, font_size=_NUMERIC, text_color=_COLOUR,
                    background_color=_COLOUR)
        ),
    },
    "foxglove.PoseInFrame": {"pose": _POSE},
    "foxglove.FrameTransform": {
        "parent_frame_id": TEXT, "child_frame_id": TEXT, "translation": _VECTOR, "rotation": _TURN,
    },
    "foxglove.SceneUpdate": {
        "deletions": _list(_object(timestamp=TIME, type=NUMBER, id=TEXT)), "entities": _list(_ENTITY),
    },
    "foxglove.PointCloud": {"pose": _POSE, "point_stride": NUMBER, "fields": _PACKED, "data": BYTES},
    "foxglove.Grid": {
        "pose": _POSE, "column_count": NUMBER, "cell_size": _SPOT, "row_stride": NUMBER, "cell_stride": NUMBER,
        "fields": _PACKED, "data": BYTES,
    },
    "foxglove.Log": {"level": NUMBER, "message": TEXT, "name": TEXT, "file": TEXT, "line": NUMBER},
}  # fmt: skip

_LINE_LOOP, _DELETE_ALL = 2, 1
_UINT8, _FLOAT32 = 1, 7
_INFO, _WARNING = 2, 3
"""Numbers of Foxglove's enumerations."""

FATE_COLOURS: dict[BoxFate, tuple[float, float, float]] = {
    BoxFate.KEPT: (0.2, 0.8, 0.3),
    BoxFate.KNOWN: (0.3, 0.6, 1.0),
    BoxFate.BORDER: (0.9, 0.7, 0.2),
    BoxFate.SMALL: (0.6, 0.6, 0.6),
    BoxFate.HIDDEN: (0.7, 0.4, 0.9),
    BoxFate.ORNAMENT: (0.5, 0.4, 0.3),
    BoxFate.UNREAD: (0.9, 0.3, 0.3),
}


def stamp(nanoseconds: int) -> dict[str, int]:
    """A time."""
    return {"sec": nanoseconds // 10**9, "nsec": nanoseconds % 10**9}


def image(rgb: NDArray[np.uint8], nanoseconds: int) -> dict[str, Any]:
    """A `CompressedImage`, JPEG."""
    data = in_letters(packed(".jpg", rgb[:, :, ::-1]))
    return {**_head(nanoseconds, CAMERA), "data": data, "format": "jpeg"}


def calibration(camera: PinholeCamera, nanoseconds: int) -> dict[str, Any]:
    """A `CameraCalibration`."""
    return {**_head(nanoseconds, CAMERA), **calibration_fields(camera)}


def pose(map_from_camera: Array, nanoseconds: int) -> dict[str, Any]:
    """A `PoseInFrame`."""
    return {**_head(nanoseconds, MAP), "pose": _pose(map_from_camera)}


def transform(map_from_camera: Array, nanoseconds: int) -> dict[str, Any]:
    """A `FrameTransform` from the map to the camera."""
    placed_ = _pose(map_from_camera)
    frames = {"parent_frame_id": MAP, "child_frame_id": CAMERA}
    return {
        "timestamp": stamp(nanoseconds), **frames,
        "translation": placed_["position"], "rotation": placed_["orientation"],
    }  # fmt: skip


def boxes(reading: FrameReading, nanoseconds: int) -> dict[str, Any]:
    """`ImageAnnotations` of a frame's boxes, coloured by what became of each, with what was read in those kept."""
    time = stamp(nanoseconds)
    points = [
        {
            "timestamp": time, "type": _LINE_LOOP, "thickness": 2.0, "outline_color": _colour(FATE_COLOURS[fate]),
            "points": [{"x": float(x), "y": float(y)} for x, y in box],
        }
        for box, fate in zip(reading.boxes, reading.fates, strict=True)
    ]  # fmt: skip
    texts = [
        {
            "timestamp": time, "position": {"x": float(box[0, 0]), "y": float(box[0, 1])},
            "text": clean_text(spelling), "font_size": 14.0,
            "text_color": _colour((1.0, 1.0, 1.0)), "background_color": _colour((0.0, 0.0, 0.0), 0.6),
        }
        for box, spelling in zip(reading.texts.boxes, reading.texts.spellings, strict=True)
    ]  # fmt: skip
    return {"points": points, "texts": texts}


def landmarks(marks: Sequence[Landmark], nanoseconds: int) -> dict[str, Any]:
    """A `SceneUpdate` in place of all before it: an entity for each landmark, a plate with its name."""
    time = stamp(nanoseconds)
    entities = []
    for mark in placed(marks):
        at, colour = board_pose(mark), board_colour(mark)
        size = board_size(mark)
        above = at.copy()
        above[2, 3] += size[2]
        told = {
            "name": clean_text(mark.name), "role": mark.role, "confidence": f"{mark.confidence:.2f}",
            "seen": str(mark.observations), "lines": clean_text(" / ".join(line.text for line in mark.lines)),
        }  # fmt: skip
        entities.append({
            "timestamp": time, "frame_id": MAP, "id": str(mark.id), "lifetime": stamp(0), "frame_locked": False,
            "metadata": [{"key": key, "value": value} for key, value in told.items()],
            "cubes": [{"pose": _pose(at), "size": _vector(size), "color": _colour(colour, 0.5)}],
            "texts": [{
                "pose": _pose(above), "billboard": True, "font_size": 0.2, "scale_invariant": False,
                "color": _colour(colour), "text": told["name"],
            }],
        })  # fmt: skip
    return {"deletions": [{"timestamp": time, "type": _DELETE_ALL, "id": ""}], "entities": entities}


def way(positions: Array, nanoseconds: int) -> dict[str, Any]:
    """A `SceneUpdate` of the camera's way, (n, 3)."""
    time = stamp(nanoseconds)
    known = positions[np.isfinite(positions).all(axis=1)]
    line = {
        "type": 0, "pose": _pose(np.eye(4)), "thickness": 0.03, "scale_invariant": False,
        "color": _colour((0.2, 0.7, 0.3)), "points": [_vector(each) for each in known],
    }  # fmt: skip
    entity = {
        "timestamp": time, "frame_id": MAP, "id": "way", "lifetime": stamp(0), "frame_locked": False, "metadata": [],
        "cubes": [], "texts": [], "lines": [line],
    }  # fmt: skip
    return {"deletions": [], "entities": [entity]}


def points(cloud: Array, nanoseconds: int) -> dict[str, Any]:
    """A `PointCloud`, (n, 3) metres."""
    data = np.ascontiguousarray(cloud, np.float32).tobytes()
    fields = [{"name": name, "offset": 4 * at, "type": _FLOAT32} for at, name in enumerate("xyz")]
    head = {**_head(nanoseconds, MAP), "pose": _pose(np.eye(4))}
    return {**head, "point_stride": 12, "fields": fields, "data": in_letters(data)}


def ground(grid: Grid, nanoseconds: int) -> dict[str, Any]:
    """A `Grid`: 0 where nobody has looked, 1 free, 2 occupied."""
    shown = np.zeros(grid.shape, np.uint8)
    shown[grid.values == FREE], shown[grid.values == OCCUPIED] = 1, 2
    corner = np.eye(4)
    corner[:2, 3] = grid.origin
    columns = grid.shape[1]
    return {
        **_head(nanoseconds, MAP), "pose": _pose(corner), "column_count": columns,
        "cell_size": {"x": grid.resolution, "y": grid.resolution}, "row_stride": columns, "cell_stride": 1,
        "fields": [{"name": "ground", "offset": 0, "type": _UINT8}], "data": in_letters(shown.tobytes()),
    }  # fmt: skip


def event(happened: SlamEvent, nanoseconds: int) -> dict[str, Any]:
    """A `Log` line."""
    level = _WARNING if happened.kind in (EventKind.LOST, EventKind.WEAK) else _INFO
    line = clean_text(f"{happened.kind}: {happened.reason}")
    return {
        "timestamp": stamp(nanoseconds), "level": level, "message": line, "name": "lpslam", "file": "", "line": 0,
    }  # fmt: skip


def _head(nanoseconds: int, frame: str) -> dict[str, Any]:
    return {"timestamp": stamp(nanoseconds), "frame_id": frame}


def _pose(matrix: Array) -> dict[str, Any]:
    turn = Rotation.from_matrix(matrix[:3, :3]).as_quat()
    return {"position": _vector(matrix[:3, 3]), "orientation": dict(zip("xyzw", map(float, turn), strict=True))}


def _vector(values: Array) -> dict[str, float]:
    return dict(zip("xyz", map(float, values), strict=True))


def _colour(rgb: tuple[float, float, float], opacity: float = 1.0) -> dict[str, float]:
    return {"r": rgb[0], "g": rgb[1], "b": rgb[2], "a": opacity}
