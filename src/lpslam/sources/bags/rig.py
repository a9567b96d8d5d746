"""The two cameras of a recording, and whether depth must be registered."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.bags import realsense
from lpslam.sources.bags.containers.container import Container, Topic
from lpslam.sources.bags.lenses import MILLIMETRES, camera_of
from lpslam.sources.bags.messages import EXTRINSICS, TRANSFORMS, BadMessageError, decoded
from lpslam.sources.bags.pictures import colour_of, depth_of
from lpslam.sources.bags.topics import ChosenTopics, PictureTopic, first_of
from lpslam.sources.bags.transforms import FixedFrames
from lpslam.sources.calibration import read_calibration
from lpslam.sources.images import BadImageError
from lpslam.sources.registering.registration import DepthRig

_SAME = 0.5
"""Pixels by which two calibrations of the same pictures may place the image's corner apart."""
_STILL = 1e-4
"""Metres and radians between two cameras that are one."""
_STATIC = 64
"""Messages of tf_static that are read: one for each node that publishes it."""


@dataclass(frozen=True, slots=True, eq=False)
class BagRig:
    """What turns pictures into frames.

    Attributes:
        colour: the colour camera.
        depth_scale: raw depth units in a metre.
        splat: how depth is registered; None where it has the colour camera's pixels.
        notes: what was assumed, one sentence each.
    """

    colour: PinholeCamera
    depth_scale: float
    splat: DepthRig | None
    notes: list[str]


def rig_of(container: Container, topics: ChosenTopics, camera_file: Path | None) -> BagRig:
    """The cameras of the chosen topics.

    Raises:
        UserError: the colour camera is not calibrated, or depth is not registered and cannot be.
    """
    scale = realsense.depth_scale_of(container, topics.depth.name) or MILLIMETRES
    colour_size, depth_size = _size_of(topics.colour, container), _size_of(topics.depth, container)
    recorded = _camera(container, topics.colour, topics.colour_info, scale, is_needed=camera_file is None)
    notes: list[str] = []
    displacement = None
    if camera_file is not None:
        calibration = read_calibration(camera_file, image_size=colour_size, default_depth_scale=scale)
        colour = replace(calibration.camera, depth_scale=calibration.camera.depth_scale)
        scale, notes = colour.depth_scale, list(calibration.notes)
        displacement = calibration.displacement
    else:
        assert recorded is not None
        colour = recorded
    if colour_size != (colour.width, colour.height):
        raise UserError(
            f"{container.path}: its images are {_in_words(colour_size)}, its calibration is for "
            f"{_in_words((colour.width, colour.height))}; give the calibration of these images"
        )
    if displacement is not None:
        return BagRig(colour, scale, displacement.rig(depth_size, colour_size), notes)
    depth = _camera(container, topics.depth, topics.depth_info, scale, is_needed=False)
    if depth is not None and depth_size != (depth.width, depth.height):
        depth = None
    return BagRig(colour, scale, _splat(container, topics, colour, recorded or colour, depth, depth_size), notes)


def _splat(
    container: Container,
    topics: ChosenTopics,
    colour: PinholeCamera,
    recorded: PinholeCamera,
    depth: PinholeCamera | None,
    depth_size: tuple[int, int],
) -> DepthRig | None:
    is_same_size = depth_size == (recorded.width, recorded.height)
    if depth is None:
        if is_same_size:
            return None
        # Without a calibration of its own, smaller depth of the same view is what phones and aligned streams give.
        depth = _resized(recorded, depth_size)
    transform = _colour_from_depth(container, topics)
    is_like = is_same_size and _is_same(depth, recorded)
    is_one = _is_still(transform) if transform is not None else is_like
    if is_like and is_one:
        return None
    if transform is None:
        raise UserError(
            f"{container.path}: depth ({topics.depth.name}) is not registered to colour, and nothing says how the two "
            "cameras stand; record aligned depth (align_depth, depth_registered) or tf_static"
        )
    return DepthRig(depth, colour, transform)


def _colour_from_depth(container: Container, topics: ChosenTopics) -> NDArray[np.float64] | None:
    """From the maker's own topics, from tf_static, or from both being in one frame."""
    stated = realsense.colour_from_depth_of(container, topics.colour.name, topics.depth.name)
    if stated is not None:
        return stated
    colour_frame, depth_frame = (_frame(each, container) for each in (topics.colour, topics.depth))
    if colour_frame and colour_frame == depth_frame:
        return np.eye(4)
    frames = FixedFrames()
    for topic in container.topics:
        if topic.type in TRANSFORMS and topic.name.endswith("tf_static"):
            for number, message in enumerate(container.messages([topic.name])):
                try:
                    frames.add(decoded(message).transforms)
                except (BadMessageError, AttributeError):
                    continue
                if number >= _STATIC:
                    break
    found = frames.between(colour_frame, depth_frame) if colour_frame and depth_frame else None
    return found if found is not None else _extrinsics(container)


def _extrinsics(container: Container) -> NDArray[np.float64] | None:
    """What realsense2_camera publishes besides: from depth to colour, the rotation column by column."""
    topic = next(
        (each for each in container.topics if each.type in EXTRINSICS and each.name.endswith("depth_to_color")), None
    )
    message = first_of(container, topic) if topic is not None else None
    if message is None:
        return None
    pose = np.eye(4)
    pose[:3, :3] = np.asarray(message.rotation, np.float64).reshape(3, 3).T
    pose[:3, 3] = message.translation
    is_rigid = np.isfinite(pose).all() and np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-3)
    return pose if is_rigid else None


def _camera(
    container: Container, picture: PictureTopic, info: Topic | None, scale: float, *, is_needed: bool
) -> PinholeCamera | None:
    message = first_of(container, info) if info is not None else None
    if message is None:
        if not is_needed:
            return None
        raise UserError(
            f"{container.path} has no calibration (CameraInfo) for {picture.name}; give --info TOPIC or --camera FILE"
        )
    assert info is not None
    try:
        return camera_of(
            message, f"{container.path}: {info.name}", is_rectified=picture.is_rectified, depth_scale=scale
        )
    except UserError:
        if is_needed:
            raise
        return None


def _size_of(picture: PictureTopic, container: Container) -> tuple[int, int]:
    try:
        image: Any = depth_of(picture.first) if picture.is_depth else colour_of(picture.first)
    except BadImageError as error:
        raise UserError(f"{container.path}: {picture.name}: {error}") from error
    return int(image.shape[1]), int(image.shape[0])


def _frame(picture: PictureTopic, container: Container) -> str:
    """The optical frame; RealSense's recorders write "0" for every camera."""
    return "" if realsense.is_realsense(picture.name) else str(picture.first.header.frame_id)


def _resized(camera: PinholeCamera, size: tuple[int, int]) -> PinholeCamera:
    """The same view in other pixels."""
    across, down = size[0] / camera.width, size[1] / camera.height
    return replace(
        camera,
        width=size[0],
        height=size[1],
        fx=camera.fx * across,
        fy=camera.fy * down,
        cx=(camera.cx + 0.5) * across - 0.5,
        cy=(camera.cy + 0.5) * down - 0.5,
    )


def _is_same(one: PinholeCamera, other: PinholeCamera) -> bool:
    corners = np.array([[x, y] for x in (0.0, one.width - 1.0) for y in (0.0, one.height - 1.0)])
    rays = [(each.undistort(corners) - [each.cx, each.cy]) / [each.fx, each.fy] for each in (one, other)]
    return bool(np.abs(rays[0] - rays[1]).max() * one.fx < _SAME)


def _is_still(transform: NDArray[np.float64]) -> bool:
    return bool(np.abs(transform - np.eye(4)).max() < _STILL)


def _in_words(size: tuple[int, int]) -> str:
    return f"{size[0]}×{size[1]}"
