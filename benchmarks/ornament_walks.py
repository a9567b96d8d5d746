"""Walls with ornaments walked past: what stays of them in a map of words, by true poses and a flat wall's depth."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ornament_pictures
from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import TextConfig
from lpslam.frames import RgbdFrame
from lpslam.language.offline import OfflineModel
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.types import BoxFate, Landmark

METRE = 260.0  # pixels of a wall: motifs of 6 to 22 centimetres, seen from two to three metres
READ_EVERY = 0.17  # seconds, between views of a wall
DEPTH_NOISE = 0.002  # metres at one metre; grows with the square


@dataclass(frozen=True)
class Walked:
    """What one wall gave: boxes by what became of them, and the landmarks that stay."""

    read: int
    refused: int
    landmarks: list[Landmark]


def walk_past(kind: str, random: np.random.Generator, views: int, spotter: TextSpotter, model: OfflineModel) -> Walked:
    """Map the texts of one wall in passing."""
    pictures, away, yaws = ornament_pictures.ornament_walked_past(kind, random, views)
    middle_x, middle_y = ornament_pictures.MIDDLE.tolist()
    focal = ornament_pictures.FOCAL
    camera = PinholeCamera(*ornament_pictures.SIZE, focal, focal, middle_x, middle_y)
    mapper = TextMapper(camera, spotter, TextConfig(), model)
    poses = {}
    fates: list[BoxFate] = []
    for view, (image, yaw) in enumerate(zip(pictures, yaws, strict=True)):
        camera_from_wall = _camera_from_wall(yaw, away * focal / METRE)
        poses[view] = inverse_transform(camera_from_wall)
        frame = RgbdFrame(view, READ_EVERY * view, image, _depth(camera_from_wall, random))
        tracked = TrackedFrame(view, frame.timestamp, TrackingState.TRACKING, view, np.eye(4), poses[view], 0, True)
        reading = mapper.read(frame, tracked)
        fates += reading.fates if reading is not None else ()
    mapper.take_waiting()
    refused = sum(each == BoxFate.ORNAMENT for each in fates)
    return Walked(sum(each == BoxFate.KEPT for each in fates), refused, mapper.text_map.landmarks(poses.get))


def _camera_from_wall(yaw: float, distance: float) -> NDArray[np.float64]:
    """Pose (4, 4) of a wall through the origin, turned by so many degrees, so many metres away."""
    cosine, sine = np.cos(np.radians(yaw)), np.sin(np.radians(yaw))
    pose = np.eye(4)
    pose[:3, :3] = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    pose[2, 3] = distance
    return pose


def _depth(camera_from_wall: NDArray[np.float64], random: np.random.Generator) -> NDArray[np.float32]:
    columns = (np.arange(ornament_pictures.SIZE[0]) - ornament_pictures.MIDDLE[0]) / ornament_pictures.FOCAL
    normal, distance = camera_from_wall[:3, 2], float(camera_from_wall[2, 3])
    along = normal[2] * distance / np.maximum(normal[0] * columns + normal[2], 1e-6)
    depth = np.tile(np.where((along > 0.0) & (along < 8.0), along, 0.0), (ornament_pictures.SIZE[1], 1))
    noise = DEPTH_NOISE * depth**2 * random.standard_normal(depth.shape)
    return np.asarray(depth + noise, np.float32)
