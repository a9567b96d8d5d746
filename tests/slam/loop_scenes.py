"""A camera that walks around inside a painted ring and comes back, mapped as if every step drifted a little."""

from dataclasses import dataclass

import numpy as np
from slam_scenes import CAMERA, SENSOR, add_view, descriptors_of, features_at, flip_bits, rigid

from lpslam.camera import inverse_transform, transform_points
from lpslam.config import SlamConfig
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor
from lpslam.slam.kernels import graph
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.map import SlamMap
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.loop_closing import LoopCloser

RADIUS = 3.0
WALKED = 1.0
KEYFRAMES_A_ROUND = 40
REMEMBERED = 5
"""Keyframes for which a point that was seen is known again; afterwards only a closed loop finds it."""


@dataclass
class World:
    """Points on the inside of a cylinder about the y axis, with what they look like; `hidden` are never seen."""

    points: np.ndarray
    descriptors: np.ndarray

    @classmethod
    def of(cls, random: np.random.Generator, count: int = 4000) -> "World":
        angle, depth = random.uniform(0, 2 * np.pi, count), random.uniform(RADIUS - 0.4, RADIUS + 0.4, count)
        points = np.column_stack([depth * np.sin(angle), random.uniform(-1.3, 1.3, count), depth * np.cos(angle)])
        return cls(points, descriptors_of(random, count))

    def with_twin_sector(self, at: float, twin: float, width: float) -> "World":
        """The world with a sector (radians) repeated elsewhere, to the last patch."""
        angle = np.arctan2(self.points[:, 0], self.points[:, 2])
        inside = np.abs(np.angle(np.exp(1j * (angle - at)))) < width / 2
        covered = np.abs(np.angle(np.exp(1j * (angle - twin)))) < width / 2
        turned = self.points[inside] @ exponential(np.array([0, 0, 0, 0, twin - at, 0.0]))[:3, :3].T
        return World(
            np.concatenate([self.points[~covered], turned]),
            np.concatenate([self.descriptors[~covered], self.descriptors[inside]]),
        )


def around(angle: float) -> np.ndarray:
    """camera_from_world of a camera on the walk that looks outwards."""
    world_from_camera = rigid([0, 0, 0], [0, angle, 0])
    world_from_camera[:3, 3] = world_from_camera[:3, 2] * WALKED
    return inverse_transform(world_from_camera)


class Walk:
    """Maps views of a world one by one, as tracking and local mapping would, with drift instead of noise.

    Attributes:
        truth: camera from world of each keyframe.
    """

    def __init__(self, world: World, seed: int, drift: float, advisor: LoopAdvisor = NO_ADVICE) -> None:
        self.world, self.random, self.drift = world, np.random.default_rng(seed), drift
        config = SlamConfig()
        self.map = SlamMap(600, SENSOR.scales)
        self.places = PlaceIndex()
        locator = Locator(self.map, SENSOR, config.tracking, config.locating)
        self.closer = LoopCloser(self.map, SENSOR, self.places, locator, config, advisor)
        self.truth: list[np.ndarray] = []
        self._known: dict[int, tuple[int, int]] = {}  # world point: map point, last keyframe that saw it

    def step(self, camera_from_world: np.ndarray, anew_at: np.ndarray | None = None) -> int:
        """Add a keyframe; `anew_at` begins a sub-map whose first keyframe has this pose."""
        random = self.random
        if anew_at is not None:
            estimate, parent = anew_at, -1
            self._known.clear()
        elif not self.truth:
            estimate, parent = camera_from_world, -1
        else:
            parent = len(self.truth) - 1
            step = camera_from_world @ inverse_transform(self.truth[-1])
            astray = exponential(random.normal(0, self.drift, 6) / [1, 1, 1, 3, 3, 3] + [0, 0, 0, 0, self.drift / 3, 0])
            estimate = astray @ step @ self.map.camera_from_world(parent)
        in_camera = transform_points(camera_from_world, self.world.points)
        pixels = CAMERA.project(np.where(in_camera[:, 2:] > 0.3, in_camera, [0, 0, -1.0]))
        inside = (in_camera[:, 2] > 0.3) & (pixels > 5).all(1) & (pixels < [CAMERA.width - 5, CAMERA.height - 5]).all(1)
        seen = random.permutation(np.flatnonzero(inside))[:600]
        distance = np.linalg.norm(in_camera[seen], axis=1)
        features = features_at(
            pixels[seen] + random.normal(0, 0.3, (len(seen), 2)),
            in_camera[seen, 2] * (1 + random.normal(0, 0.002, len(seen))),
            flip_bits(random, self.world.descriptors[seen], 6),
            np.clip(np.round(np.log(4.0 / distance) / np.log(1.2)), 0, 7),
        )
        keyframe = add_view(self.map, estimate, features, parent)
        self.truth.append(camera_from_world)
        slot = int(self.map.columns.keyframe_slot[keyframe])
        points = np.full(len(seen), -1, np.int32)
        for row, number in enumerate(seen.tolist()):
            point, last = self._known.get(number, (-1, -REMEMBERED))
            if point >= 0 and keyframe - last <= REMEMBERED and self.map.columns.point_alive[point]:
                points[row] = point
        graph.link_all(self.map.columns, points, slot)
        new = np.flatnonzero(points < 0).astype(np.int32)
        in_world = transform_points(
            inverse_transform(estimate), SENSOR.back_project(features.pixels[new], features.depth[new])
        )
        first = self.map.add_points(keyframe, new, in_world)
        points[new] = np.arange(first, first + len(new))
        graph.refresh_points(self.map.columns, points, SENSOR.scales)
        self._known.update({n: (int(points[row]), keyframe) for row, n in enumerate(seen.tolist())})
        return keyframe

    def errors(self) -> np.ndarray:
        """(K,) metres by which each keyframe is off, in the frame of the first."""
        return np.array(
            [
                np.linalg.norm((self.map.world_from_keyframe(k) - inverse_transform(true))[:3, 3])
                for k, true in enumerate(self.truth)
            ]
        )
