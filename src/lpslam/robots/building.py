"""What the map knows as messages of ROS 2. Metres and radians, map frame, z up.

What a sign says is text in these messages: cleaned, bounded, and never part of a topic, a frame or a file's name.
"""

from collections.abc import Iterable, Sequence
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.ground.grid import Grid
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.board_poses import board_colour, board_pose, board_size, placed
from lpslam.robots import types
from lpslam.robots.types import made
from lpslam.text.types import Landmark

Array = NDArray[np.float64]

_LONGEST = 200
"""Letters of a sign that are told; RViz draws them all on one line."""
_SMALLEST = 0.05
"""Metres: smaller text cannot be seen in a room from above."""
_SECOND = 10**9


def header(nanoseconds: int, frame: str) -> Any:
    """A `Header` of a time and a frame of reference."""
    time = made("builtin_interfaces/msg/Time", nanoseconds // _SECOND, nanoseconds % _SECOND)
    return made("std_msgs/msg/Header", time, frame)


def picture(pixels: NDArray[Any], nanoseconds: int, frame: str) -> Any:
    """An `Image`: (h, w, 3) uint8 red, green, blue; or depth (h, w), uint16 millimetres or float32 metres."""
    encoding = {("uint8", 3): "rgb8", ("uint16", 2): "16UC1", ("float32", 2): "32FC1"}[pixels.dtype.name, pixels.ndim]
    height, width = pixels.shape[:2]
    data = np.frombuffer(np.ascontiguousarray(pixels).tobytes(), np.uint8)
    return made(types.IMAGE, header(nanoseconds, frame), height, width, encoding, 0, len(data) // height, data)


def camera_info(camera: PinholeCamera, nanoseconds: int, frame: str) -> Any:
    """A `CameraInfo` of a camera."""
    region = made("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
    projection = np.column_stack([camera.matrix, np.zeros(3)]).ravel()
    lens = "plumb_bob", np.array(camera.distortion), camera.matrix.ravel(), np.eye(3).ravel(), projection
    return made(types.CAMERA_INFO, header(nanoseconds, frame), camera.height, camera.width, *lens, 0, 0, region)


def transforms(entries: Iterable[tuple[str, str, Array]], nanoseconds: int) -> Any:
    """A `TFMessage` of parents, children and `parent_from_child`, 4×4."""
    return made(
        types.TRANSFORMS,
        [
            made(
                "geometry_msgs/msg/TransformStamped",
                header(nanoseconds, parent),
                child,
                made("geometry_msgs/msg/Transform", _vector(matrix[:3, 3]), _quaternion(matrix[:3, :3])),
            )
            for parent, child, matrix in entries
        ],
    )


def pose_stamped(world_from_thing: Array, nanoseconds: int, frame: str) -> Any:
    """A `PoseStamped` of a 4×4 pose."""
    return made(types.POSE, header(nanoseconds, frame), _pose(world_from_thing))


def standing(x: float, y: float, yaw: float, nanoseconds: int, frame: str) -> Any:
    """A `PoseStamped` on the ground, facing `yaw`."""
    turn = made("geometry_msgs/msg/Quaternion", 0.0, 0.0, sin(yaw / 2), cos(yaw / 2))
    pose = made("geometry_msgs/msg/Pose", _point(np.array([x, y, 0.0])), turn)
    return made(types.POSE, header(nanoseconds, frame), pose)


def path(points: Array, nanoseconds: int, frame: str, last_yaw: float | None = None) -> Any:
    """A `Path` over points (n, 2); each pose faces the next, the last as the one before or `last_yaw`."""
    steps = np.diff(points, axis=0)
    yaws = np.arctan2(steps[:, 1], steps[:, 0]).tolist()
    last = last_yaw if last_yaw is not None else (yaws[-1] if yaws else 0.0)
    poses = [
        standing(float(x), float(y), yaw, nanoseconds, frame)
        for (x, y), yaw in zip(points, [*yaws, last][: len(points)], strict=True)
    ]
    return made(types.PATH, header(nanoseconds, frame), poses)


def occupancy_grid(grid: Grid, nanoseconds: int, frame: str) -> Any:
    """An `OccupancyGrid`; its values and its order of cells are those of `Grid`."""
    rows, columns = grid.shape
    origin = np.eye(4)
    origin[:2, 3] = grid.origin
    head = header(nanoseconds, frame)
    meta = made("nav_msgs/msg/MapMetaData", head.stamp, grid.resolution, columns, rows, _pose(origin))
    return made(types.GRID, head, meta, np.ascontiguousarray(grid.values).ravel())


def markers(landmarks: Sequence[Landmark], nanoseconds: int, frame: str) -> Any:
    """A `MarkerArray` in place of all before it: of each landmark a plate where its board hangs, and its name."""
    head = header(nanoseconds, frame)
    shown = [_marker(head, "", 0, _DELETE_ALL, np.eye(4), np.ones(3), (0.0, 0.0, 0.0, 0.0))]
    for mark in placed(landmarks):
        pose = board_pose(mark)
        identifier = mark.id & 0x7FFFFFFF  # of 32 bits with a sign
        size = board_size(mark)
        shown.append(_marker(head, "boards", identifier, _ADD, pose, size, (*board_colour(mark), 0.5), _CUBE))
        pose = pose.copy()
        pose[2, 3] += size[2]
        tall = np.full(3, max(min(mark.height, 0.3), _SMALLEST))
        text = clean_text(mark.name, _LONGEST)
        shown.append(_marker(head, "signs", identifier, _ADD, pose, tall, (*board_colour(mark), 1.0), _TEXT, text))
    return made(types.MARKERS, shown)


def detections(landmarks: Sequence[Landmark], nanoseconds: int, frame: str) -> Any:
    """A `Detection3DArray`: `class_id` is the name, `score` how sure it is, `id` the landmark's."""
    head = header(nanoseconds, frame)
    found = []
    for mark in placed(landmarks):
        pose = _pose(board_pose(mark))
        covariance = np.zeros((6, 6))
        covariance[:3, :3] = np.eye(3) * mark.spread**2 / 3.0
        hypothesis = made("vision_msgs/msg/ObjectHypothesis", clean_text(mark.name, _LONGEST), float(mark.confidence))
        uncertain = made("geometry_msgs/msg/PoseWithCovariance", pose, covariance.ravel())
        result = made("vision_msgs/msg/ObjectHypothesisWithPose", hypothesis, uncertain)
        size = _vector(board_size(mark))
        box = made("vision_msgs/msg/BoundingBox3D", pose, size)
        found.append(made("vision_msgs/msg/Detection3D", head, [result], box, str(mark.id)))
    return made(types.DETECTIONS, head, found)


def _marker(
    head: Any,
    namespace: str,
    identifier: int,
    action: int,
    pose: Array,
    size: Array,
    colour: tuple[float, float, float, float],
    shape: int = 0,
    text: str = "",
) -> Any:
    empty = np.zeros(0, np.uint8)
    time = made("builtin_interfaces/msg/Time", 0, 0)
    nothing = made(types.COMPRESSED, made("std_msgs/msg/Header", time, ""), "", empty)
    return made(
        "visualization_msgs/msg/Marker",
        *(head, namespace, identifier, shape, action, _pose(pose), _vector(size)),
        made("std_msgs/msg/ColorRGBA", *colour),
        made("builtin_interfaces/msg/Duration", 0, 0),
        *(False, [], [], "", nothing, [], text, ""),
        made("visualization_msgs/msg/MeshFile", "", empty),
        False,
    )


def _pose(matrix: Array) -> Any:
    return made("geometry_msgs/msg/Pose", _point(matrix[:3, 3]), _quaternion(matrix[:3, :3]))


def _quaternion(rotation: Array) -> Any:
    return made("geometry_msgs/msg/Quaternion", *map(float, Rotation.from_matrix(rotation).as_quat()))


def _point(position: Array) -> Any:
    return made("geometry_msgs/msg/Point", *map(float, position))


def _vector(values: Array) -> Any:
    return made("geometry_msgs/msg/Vector3", *map(float, values))


point = _point

_CUBE, _TEXT = 1, 9
_ADD, _DELETE_ALL = 0, 3
"""Numbers of visualization_msgs/Marker."""
