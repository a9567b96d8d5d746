"""Neighbouring keyframes compared as whole pictures: blur spoils corners long before it spoils these."""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import SlamConfig
from lpslam.slam.kernels.geometry import logarithm
from lpslam.slam.kernels.relative import adjoint
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.relative_poses import RelativePoses
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.surfaces import Surfaces

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    """From keyframe a to b: the relative pose (4×4, camera b from a), and what pictures tell of it (6, 6)."""

    a: int
    b: int
    b_from_a: _Matrix
    information: _Matrix


class WholePictures:
    """Aligns each keyframe with the one before it, and puts what that tells into the map's relative poses.

    Args:
        slam_map: its lock is taken for a moment at a time.
        camera, sensor: of the frames.
        config: thresholds.
    """

    def __init__(self, slam_map: SlamMap, camera: PinholeCamera, sensor: SensorModel, config: SlamConfig) -> None:
        self._map = slam_map
        self._surfaces = Surfaces(camera, sensor, config.surfaces)
        self._config = config.pictures
        slam_map.relative_poses = RelativePoses(config.pictures)
        self._images: dict[int, NDArray[np.float32]] = {}
        self._newest: _Step | None = None
        self._count = 0
        self._usual: deque[float] = deque(maxlen=config.pictures.remembered_steps)

    def keep(self, keyframe: int, gray: NDArray[np.uint8], depth: NDArray[np.float32]) -> None:
        """Keep the picture (h, w) of a keyframe with its depth, metres, until it has been compared."""
        if self._config.enabled:
            image = self._surfaces.images.reference(gray, depth)
            with self._map.lock:
                self._images[keyframe] = image

    def forget(self) -> None:
        """Depth is read otherwise from now on: what was compared before does not fit what comes."""
        with self._map.lock:
            self._images.clear()
            self._map.relative_poses.forget()
        self._newest = None

    def compare(self, keyframe: int) -> None:
        """Align a keyframe that is in the map with the one before; for whoever works keyframes into the map."""
        relative = self._map.relative_poses
        with self._map.lock:
            before = self._before(keyframe)
            is_worth = relative.excess < self._config.largest_excess
        self._count += 1
        # Two keyframes one after the other are needed to look at a way round.
        if not before or not (is_worth or self._count % self._config.judged_every < 2):
            self._newest = None
            return
        step = self._aligned(before[-1], keyframe, None)
        earlier, self._newest = self._newest, step
        if step is None:
            return
        gap = self._gap(earlier, step) if earlier is not None and earlier.b == step.a and earlier.a in before else None
        with self._map.lock:
            if gap is not None:
                relative.judge(gap)
            step_of_map = self._step_of_map(step.a, step.b)
            error = logarithm(step_of_map @ inverse_transform(step.b_from_a))
            difference = float(error @ step.information @ error)
            if keyframe not in self._map.blurred:
                relative.differ(difference)
            is_denied = difference > self._config.most_disagreement * relative.excess
            if is_denied and not self._most_pixels_agree(step, step_of_map):
                return
            if not is_denied:
                self._usual.append(self._unlikeness(step, step.b_from_a))
            relative.add(step.a, step.b, step.b_from_a, step.information)

    def _most_pixels_agree(self, step: _Step, step_of_map: _Matrix) -> bool:
        """Whether by a step most pixels are more alike than by the map's, which denies it, and nearly as much as usual.

        Who walks by in a coat of strong contrasts takes the picture along; the faint wall behind him does not fit then.
        The caller holds the lock.
        """
        unlike = self._unlikeness(step, step.b_from_a)
        usual = float(np.median(self._usual)) if self._usual else 0.0
        return unlike < self._config.unusual * usual and unlike < self._unlikeness(step, step_of_map)

    def _unlikeness(self, step: _Step, b_from_a: _Matrix) -> float:
        """Grey values by which most pixels of a step's two pictures differ at a pose (4×4)."""
        return self._surfaces.unlikeness(self._images[step.a], self._images[step.b], b_from_a)

    def _step_of_map(self, a: int, b: int) -> _Matrix:
        """Camera b from camera a (4×4) as the map has them; the caller holds the lock."""
        return self._map.camera_from_world(b) @ inverse_transform(self._map.camera_from_world(a))

    def _before(self, keyframe: int) -> list[int]:
        """The newest keyframes before one with a picture, in its sub-map; the caller holds the lock."""
        slam_map = self._map
        for old in [k for k in self._images if k < keyframe - self._config.kept_pictures]:
            del self._images[old]
        if keyframe not in self._images:
            return []
        submaps = slam_map.submaps()
        return sorted(
            k for k in self._images if k < keyframe and slam_map.is_alive(k) and submaps[k] == submaps[keyframe]
        )

    def _gap(self, first: _Step, second: _Step) -> float | None:
        """χ² by which the way over the middle one of three keyframes differs from the way straight on."""
        config, judged = self._config, self._map.relative_poses.judged
        if judged >= config.judged_first and self._count % config.judged_every != 1:
            return None
        over = second.b_from_a @ first.b_from_a
        straight = self._aligned(first.a, second.b, over)
        if straight is None:
            return None
        through = adjoint(second.b_from_a)
        covariance = np.linalg.inv(straight.information) + np.linalg.inv(second.information)
        covariance += through @ np.linalg.inv(first.information) @ through.T
        error = logarithm(over @ inverse_transform(straight.b_from_a))
        return float(error @ np.linalg.solve(covariance, error))

    def _aligned(self, a: int, b: int, guess: _Matrix | None) -> _Step | None:
        """The step between two keyframes from a guess of it (4×4), the map's without; None where pictures fail."""
        slam_map = self._map
        with slam_map.lock:
            guess = self._step_of_map(a, b) if guess is None else guess
            seconds = slam_map.frame_of(b)[1] - slam_map.frame_of(a)[1]
            images = self._images.get(a), self._images.get(b)
        if seconds > self._config.longest_gap or images[0] is None or images[1] is None:
            return None
        aligned = self._surfaces.align(images[0], images[1], guess, seconds)
        if aligned is None or not aligned.holds:
            return None
        return _Step(a, b, aligned.image_from_reference, aligned.information)
