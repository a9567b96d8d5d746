"""The pose of a view by its depth: the map's points lie on the surfaces that it sees (Chen and Medioni 1991).

A place seen from another height or in other light looks different, and is shaped as before. Shapes alone repeat, pillar
for pillar and door for door. So the search begins where a sign says that the view was taken, and is kept near there.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import FittingConfig
from lpslam.slam.advice import Anchor
from lpslam.slam.carrying import skew
from lpslam.slam.kernels.geometry import exponential, logarithm, orthonormalise
from lpslam.small_depth import SmallDepth

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """What a view's depth shows, (h, w, 3) each, in the camera's frame; NaN where there is none.

    Attributes:
        points: metres.
        normals: unit vectors towards the camera; NaN at edges, too.
    """

    points: _Matrix
    normals: _Matrix


@dataclass(frozen=True, slots=True, eq=False)
class Fitted:
    """Where a view was taken by its depth.

    Attributes:
        camera_from_world: 4×4.
        on_surfaces: map points that lie on surfaces of the view.
        agreement: their share among them and the points that stand before a surface, and should have hidden it.
    """

    camera_from_world: _Matrix
    on_surfaces: int
    agreement: float


@dataclass(frozen=True, slots=True, eq=False)
class _Held:
    """What a pose is held by beside surfaces.

    Attributes:
        in_camera, in_world: (n, 3) metres, middles of signs.
        pose: 4×4, near which it is, ...
        doubt: ... times the usual sigmas.
    """

    in_camera: _Matrix
    in_world: _Matrix
    pose: _Matrix | None = None
    doubt: float = 1.0


class Fitting:
    """Lays map points on the surfaces of views.

    Args:
        camera: of the views.
        config: thresholds.
    """

    def __init__(self, camera: PinholeCamera, config: FittingConfig) -> None:
        self._small = SmallDepth(camera, min(config.width, camera.width))
        self._config = config
        fx, fy, cx, cy = self._small.intrinsics
        rows, columns = np.mgrid[: self._small.size[1], : self._small.size[0]]
        self._rays = np.stack([(columns - cx) / fx, (rows - cy) / fy, np.ones(rows.shape)], axis=2)

    def surfaces(self, depth: NDArray[np.float32]) -> Surfaces:
        """What a depth image (height, width), metres, shows."""
        config, small = self._config, self._small.read(depth)
        known = np.where(small > 0, small, np.nan)
        points, step = self._rays * known[..., None], config.slope_pixels
        normals = np.full_like(points, np.nan)
        across = points[step:-step, 2 * step :] - points[step:-step, : -2 * step]
        down = points[2 * step :, step:-step] - points[: -2 * step, step:-step]
        slopes = np.cross(down, across)
        normals[step:-step, step:-step] = slopes / np.linalg.norm(slopes, axis=2, keepdims=True)
        kernel = np.ones((2 * step + 1, 2 * step + 1), np.uint8)
        normals[cv2.dilate(small, kernel) - cv2.erode(small, kernel) > config.edge * small] = np.nan
        return Surfaces(points, normals)

    def by_signs(self, surfaces: Surfaces, anchor: Anchor, points: _Matrix) -> Fitted | None:
        """The pose of a view in which signs are seen; None where their surface is not known, or the rest contradicts.

        Args:
            surfaces: of the view.
            anchor: the signs.
            points: (n, 3) of the map around them, metres, world frame.
        """
        posed = [pose for row in range(len(anchor.corners)) if (pose := self._posed(surfaces, anchor, row)) is not None]
        if not posed:
            return None
        rows, poses = zip(*posed, strict=True)
        middles = anchor.middles[list(rows)]
        in_camera = np.array([transform_points(pose, middles[i : i + 1])[0] for i, pose in enumerate(poses)])
        return self._fitted(surfaces, poses[0], points, _Held(in_camera, middles))

    def near(
        self, surfaces: Surfaces, camera_from_world: _Matrix, points: _Matrix, doubt: float = 1.0
    ) -> Fitted | None:
        """The same from a first pose (4×4) alone, which stays in directions that nothing on surfaces tells.

        It may be off by `doubt` times what a frame's drift without the map is.
        """
        held = _Held(np.empty((0, 3)), np.empty((0, 3)), camera_from_world, doubt)
        return self._fitted(surfaces, camera_from_world, points, held)

    def _posed(self, surfaces: Surfaces, anchor: Anchor, row: int) -> tuple[int, _Matrix] | None:
        """Camera from world by the place, the normal and the direction of one sign of an anchor, with its row."""
        pixels, sign = anchor.pixels(self._small.intrinsics)[row], _normal(anchor.corners[row])
        about = np.ceil(np.maximum(np.ptp(pixels, axis=0) / 2, self._config.sign_pixels))
        first = np.maximum(np.rint(pixels.mean(axis=0) - about), 0).astype(int)
        last = np.maximum(np.rint(pixels.mean(axis=0) + about), 0).astype(int) + 1
        part = np.s_[first[1] : last[1], first[0] : last[0]]
        known = np.isfinite(surfaces.normals[part]).all(axis=2)
        if sign is None or np.count_nonzero(known) < _LEAST_OF_SIGN:
            return None
        normal = np.median(surfaces.normals[part][known], axis=0)
        normal /= np.linalg.norm(normal)
        # Where the rays through its corners meet its plane.
        away = float(np.median(surfaces.points[part][known] @ normal))
        rays = anchor.directions[row]
        corners = rays * (away / np.minimum(rays @ normal, -_GRAZING))[:, None]
        turn = _axes(corners, normal) @ _axes(anchor.corners[row], sign).T
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turn, corners.mean(axis=0) - turn @ anchor.corners[row].mean(axis=0)
        return (row, pose) if np.isfinite(pose).all() else None

    def _fitted(self, surfaces: Surfaces, pose: _Matrix, points: _Matrix, held: _Held) -> Fitted | None:
        """Gauss-Newton over distances of points from surfaces, whose reach narrows."""
        config, reach = self._config, self._config.first_metres
        information = (held.doubt * np.repeat([config.start_metres, config.start_radians], 3)) ** -2
        for step in range(config.steps):
            reach = max(reach * config.narrowing, config.least_metres)
            seen = self._seen(surfaces, pose, points)
            if seen is None:
                return None
            local, off, normals = seen
            scale = reach * np.maximum(local[:, 2], 1.0) / _REACH_AT
            weights = (1.0 + (off / scale) ** 2) ** -2 / scale**2
            slopes = np.hstack([normals, np.cross(local, normals)])
            hessian, gradient = (slopes * weights[:, None]).T @ slopes, slopes.T @ (weights * off)
            # What tells where to begin is loosened once surfaces hold the pose.
            loosened = 1.0 if step < config.steps // 2 else config.loosening
            sigma = loosened * config.sign_metres
            middles = transform_points(pose, held.in_world)
            for kept, middle, turned in zip(held.in_camera, middles, skew(middles), strict=True):
                lever = np.hstack([np.eye(3), -turned])
                hessian += lever.T @ lever / sigma**2
                gradient += lever.T @ (kept - middle) / sigma**2
            if held.pose is not None:
                hessian += np.diag(information) / loosened**2
                gradient += information / loosened**2 * logarithm(held.pose @ inverse_transform(pose))
            twist = np.linalg.solve(hessian + _DAMPING * np.eye(6), gradient)
            pose = exponential(np.asarray(twist, np.float64)) @ pose
            orthonormalise(pose)
        return self._judged(surfaces, pose, points)

    def _judged(self, surfaces: Surfaces, pose: _Matrix, points: _Matrix) -> Fitted | None:
        seen = self._seen(surfaces, pose, points)
        if seen is None or not np.isfinite(pose).all():
            return None
        local, off, normals = seen
        allowed = self._config.least_metres * np.maximum(local[:, 2], 1.0) / _REACH_AT * _ALLOWED
        lies = np.abs(off) < allowed
        # What was measured lies behind the point, along the ray: the point would have hidden it.
        beyond = off / np.minimum((local * normals).sum(axis=1) / local[:, 2], -_GRAZING)
        before = ~lies & (beyond > allowed)
        on_surfaces = int(lies.sum())
        agreement = on_surfaces / max(on_surfaces + int(before.sum()), 1)
        is_held = on_surfaces >= self._config.least_points and agreement >= self._config.least_agreement
        return Fitted(pose, on_surfaces, agreement) if is_held else None

    def _seen(self, surfaces: Surfaces, pose: _Matrix, points: _Matrix) -> tuple[_Matrix, _Matrix, _Matrix] | None:
        """Points (m, 3) in the camera at whose pixels a surface is known, how far it is from them, and its normals."""
        local = transform_points(pose, points)
        local = local[local[:, 2] > _NEAREST]
        fx, fy, cx, cy = self._small.intrinsics
        columns = np.rint(local[:, 0] / local[:, 2] * fx + cx)
        rows = np.rint(local[:, 1] / local[:, 2] * fy + cy)
        width, height = self._small.size
        inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
        at = rows[inside].astype(int), columns[inside].astype(int)
        local, normals, there = local[inside], surfaces.normals[at], surfaces.points[at]
        known = np.isfinite(normals).all(axis=1)
        if np.count_nonzero(known) < self._config.least_points:
            return None
        local, normals, there = local[known], normals[known], there[known]
        return local, ((there - local) * normals).sum(axis=1), normals


def _axes(corners: _Matrix, normal: _Matrix) -> _Matrix:
    """(3, 3) columns: along a sign (4, 3), across it, and its normal."""
    along = corners[1] + corners[2] - corners[0] - corners[3]
    along = along - (along @ normal) * normal
    along /= np.linalg.norm(along)
    return np.column_stack([along, np.cross(normal, along), normal])


def _normal(corners: _Matrix) -> _Matrix | None:
    """(3,) of a sign with corners (4, 3) top left, top right, bottom right, bottom left; None if it has no size."""
    normal = np.cross(corners[3] - corners[0], corners[1] - corners[0])
    size = float(np.linalg.norm(normal))
    return normal / size if size > 0.0 else None


_REACH_AT = 3.0
"""Metres at which reaches are stated; they grow with the distance, as noise does."""

_ALLOWED = 1.5
"""Times the last reach, within which a point lies on a surface."""

_NEAREST = 0.2
"""Metres before the camera; nearer, no sensor measures."""

_LEAST_OF_SIGN = 4
"""Small pixels that tell the plane of a sign."""

_GRAZING = 0.05
"""Cosine between a ray and a surface's normal, at least."""

_DAMPING = 1e-3
"""Of the normal equations, so that what nothing tells stays."""
