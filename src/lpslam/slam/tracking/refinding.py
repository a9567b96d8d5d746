"""Where a lost camera is: what its picture shows, its depth and the signs in view are asked for it."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.advice import Anchor
from lpslam.slam.association import Associator
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.kernels import graph
from lpslam.slam.places.fitting import Fitted, Fitting, Surfaces
from lpslam.slam.places.located import Located
from lpslam.slam.places.looking import Looking
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.rays import is_unsure
from lpslam.slam.tracking.guesses import FirstGuess
from lpslam.slam.tracking.picture import Picture
from lpslam.slam.tracking.whereabouts import Whereabouts

_Matrix = NDArray[np.float64]


class Refinding:
    """Finds lost frames in the whole map.

    Args:
        relocaliser: tries places.
        associator: knows which map points are in view.
        extractor: of the camera.
        where: the camera was last; the lock of its map is held by whoever calls.
        config: thresholds.
    """

    def __init__(
        self,
        relocaliser: Relocaliser,
        associator: Associator,
        extractor: FeatureExtractor,
        where: Whereabouts,
        config: SlamConfig,
    ) -> None:
        self._relocaliser = relocaliser
        self._looking = Looking(where.map, extractor, config.locating)
        self._fitting = Fitting(extractor.camera, config.fitting)
        self._fresh_seconds = config.fitting.fresh_seconds
        self._associator = associator
        self._where = where
        self._newest: FrameDepth | None = None

    def located(self, features: Features, picture: Picture) -> Located | None:
        """The place of a frame, by its keypoints first of all."""
        where = self._where
        return self._relocaliser.confirm(
            features,
            where.reference,
            where.seen(),
            picture.timestamp,
            self._looking.at(picture.gray),
            self._depth_of(picture.frame).fit,
        )

    def by_depth(self, frame: RgbdFrame, rows: int, camera_from_world: _Matrix) -> Iterator[FirstGuess]:
        """Where a view of so many keypoints was taken by its depth, near a pose (4×4) in the world of the reference."""
        points = self._points_here()
        pose = self._laid(frame, camera_from_world, points)
        if pose is not None:
            yield FirstGuess.at(pose, rows, self._associator.predict(points, pose).points)

    def mended(self, frame: RgbdFrame, camera_from_world: _Matrix) -> _Matrix | None:
        """A pose (4×4) in the world of the reference, moved to where a frame's depth has it; None if it has none."""
        return self._laid(frame, camera_from_world, self._points_here())

    def _points_here(self) -> NDArray[np.int32]:
        """Map points (ids) of the world of the reference."""
        slam_map = self._where.map
        submaps, living = slam_map.submaps(), slam_map.living_keyframes()
        here = living[submaps[living] == submaps[self._where.reference]]
        return graph.points_of(slam_map.columns, here, slam_map.point_count)

    def _laid(self, frame: RgbdFrame, camera_from_world: _Matrix, points: NDArray[np.int32]) -> _Matrix | None:
        in_view = self._associator.predict(points, camera_from_world).points
        # Points of which only the direction is known lie on no surface.
        in_view = in_view[~is_unsure(self._where.map, in_view)]
        positions = self._where.map.columns.position[in_view]
        fitted = self._fitting.near(self._depth_of(frame).surfaces, camera_from_world, positions)
        return None if fitted is None else fitted.camera_from_world

    def _depth_of(self, frame: RgbdFrame) -> "FrameDepth":
        """A frame is asked several times in a row for what its depth shows."""
        if self._newest is None or self._newest.depth is not frame.depth:
            self._newest = FrameDepth(self._fitting, frame.depth, frame.timestamp, self._fresh_seconds)
        return self._newest

    def is_told_elsewhere(self, features: Features, camera_from_world: _Matrix) -> bool:
        """Whether a sign in view tells another place than that in which the camera was found, at a pose (4×4)."""
        return self._relocaliser.is_told_elsewhere(features, self._where.reference, camera_from_world)

    def disown(self, camera_from_world: _Matrix) -> None:
        """Believe no place around a pose (4×4) any more, until `forget`."""
        self._relocaliser.disown(self._where.reference, camera_from_world)

    def forget(self) -> None:
        """Believe every place again."""
        self._relocaliser.forget()


class FrameDepth:
    """A frame's depth (h, w), metres, and time; its surfaces are worked out when they are first asked for."""

    def __init__(self, fitting: Fitting, depth: NDArray[np.float32], timestamp: float, fresh_seconds: float) -> None:
        self._fitting = fitting
        self.depth = depth
        self._seen_since = timestamp - fresh_seconds

    @cached_property
    def surfaces(self) -> Surfaces:
        """What the depth shows."""
        return self._fitting.surfaces(self.depth)

    def fit(
        self, anchor: Anchor | None, camera_from_world: _Matrix | None, points: _Matrix, doubt: float = 1.0
    ) -> Fitted | None:
        """Where the frame was taken, as `Fit` says."""
        if anchor is not None and anchor.timestamp >= self._seen_since:
            return self._fitting.by_signs(self.surfaces, anchor, points)
        if anchor is None and camera_from_world is not None:
            return self._fitting.near(self.surfaces, camera_from_world, points, doubt)
        return None
