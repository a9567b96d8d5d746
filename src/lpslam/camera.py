"""The pinhole camera of an RGB-D sensor: projection and back-projection (paper, Eq. 4-7)."""

from dataclasses import dataclass
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError

Points = NDArray[np.float64]
_LARGEST = 1e9
"""Pixels, units in a metre, frames a second: what single precision still computes with."""
_MOST_PIXELS = 64_000_000


@dataclass(frozen=True, slots=True)
class PinholeCamera:
    """Intrinsics of a colour camera with depth registered to it.

    The optical frame is x right, y down, z forward. Pixel centres are at whole numbers.

    Attributes:
        width, height: pixels.
        fx, fy, cx, cy: pixels.
        distortion: Brown-Conrady (k1, k2, p1, p2, k3); zeros for rectified images.
        depth_scale: raw depth units in a metre (5000 for TUM, 1000 for millimetres).
        fps: nominal frames a second.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    depth_scale: float = 1000.0
    fps: float = 30.0

    def __post_init__(self) -> None:
        """Refuse what no camera can be."""
        for label in ("width", "height", "fx", "fy", "depth_scale", "fps"):
            value = getattr(self, label)
            if not _is_finite(value) or value <= 0:
                raise UserError(f"camera calibration: {label} is {_said(value)}; it must be a positive number")
            if label not in ("width", "height") and not 1 / _LARGEST <= value <= _LARGEST:
                raise UserError(f"camera calibration: {label} is {value:g}, which no camera has; is it in its unit?")
        if not float(self.width).is_integer() or not float(self.height).is_integer():
            raise UserError(f"camera calibration: {self.width}×{self.height} is no size in whole pixels")
        if self.width * self.height > _MOST_PIXELS:
            raise UserError(f"camera calibration: {self.width:g}×{self.height:g} pixels are more than any camera has")
        for label in ("cx", "cy"):
            value = getattr(self, label)
            if not _is_finite(value) or abs(value) > _LARGEST:
                raise UserError(f"camera calibration: {label} is {_said(value)}; it must be a finite number of pixels")
        if not all(_is_finite(term) and abs(term) <= _LARGEST for term in self.distortion):
            raise UserError(f"camera calibration: distortion is {self.distortion!r}, which no lens has; give numbers")
        for label in ("width", "height"):
            object.__setattr__(self, label, int(getattr(self, label)))

    @property
    def is_distorted(self) -> bool:
        """Whether pixels must be undistorted before they are used as rays."""
        return any(self.distortion)

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The 3×3 intrinsic matrix K."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, points_in_camera: Points) -> Points:
        """Project points of the optical frame to undistorted pixels (Eq. 5-6).

        Args:
            points_in_camera: (n, 3) metres, z > 0.

        Returns:
            (n, 2) pixels u, v.
        """
        x, y, z = points_in_camera.T
        return np.column_stack([self.fx * x / z + self.cx, self.fy * y / z + self.cy])

    def back_project(self, pixels: Points, depths: NDArray[np.float64]) -> Points:
        """Lift undistorted pixels with a depth to the optical frame (Eq. 7 without the pose).

        Args:
            pixels: (n, 2) u, v.
            depths: (n,) metres along the optical axis.

        Returns:
            (n, 3) metres.
        """
        u, v = pixels.T
        return np.column_stack([(u - self.cx) / self.fx * depths, (v - self.cy) / self.fy * depths, depths])

    def undistort(self, pixels: Points) -> Points:
        """Move raw pixels (n, 2) to where an ideal pinhole camera would see them."""
        if not self.is_distorted or not len(pixels):
            return pixels
        import cv2

        raw = np.ascontiguousarray(pixels, dtype=np.float64).reshape(-1, 1, 2)
        # The five steps that OpenCV takes by itself leave a tenth of a pixel near the corners of a strong lens.
        until = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1e-7)
        undistorted = cv2.undistortPoints(raw, self.matrix, np.array(self.distortion), P=self.matrix, criteria=until)
        return np.asarray(undistorted, dtype=np.float64).reshape(-1, 2)

    def distort(self, pixels: Points) -> Points:
        """Move undistorted pixels (n, 2) to where the real lens shows them (Brown-Conrady)."""
        if not self.is_distorted:
            return pixels
        k1, k2, p1, p2, k3 = self.distortion
        x, y = (pixels[:, 0] - self.cx) / self.fx, (pixels[:, 1] - self.cy) / self.fy
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        raw_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        raw_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
        return np.column_stack([self.fx * raw_x + self.cx, self.fy * raw_y + self.cy])


def _is_finite(value: object) -> bool:
    # Whole numbers of any length are real, and beyond a float's reach.
    if isinstance(value, int):
        return abs(value) < 1 << 1000
    return isinstance(value, Real) and -np.inf < float(value) < np.inf


def _said(value: object) -> str:
    return repr(value) if isinstance(value, float) else f"{value!s:.40}"


def transform_points(to_from_frame: NDArray[np.float64], points: Points) -> Points:
    """Take (n, 3) points from one frame to another with the 4×4 `to_from_frame` (Eq. 4)."""
    return points @ to_from_frame[:3, :3].T + to_from_frame[:3, 3]


def inverse_transform(to_from_frame: NDArray[np.float64]) -> NDArray[np.float64]:
    """Invert a rigid 4×4 transform exactly: rotation transposed, translation turned back."""
    inverse = np.eye(4)
    inverse[:3, :3] = to_from_frame[:3, :3].T
    inverse[:3, 3] = -to_from_frame[:3, :3].T @ to_from_frame[:3, 3]
    return inverse


def centre_distance(camera_from_world: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Metres between the centres of two cameras, by their poses (4×4) in one world."""
    return float(np.linalg.norm(inverse_transform(camera_from_world)[:3, 3] - inverse_transform(other)[:3, 3]))


def are_rigid(transforms: Points) -> bool:
    """Whether all of (n, 4, 4) turn and shift only, as numbers that were kept in a file still do.

    Shifts are those of a room, not of a planet: at most 10,000 km.
    """
    if not np.isfinite(transforms).all() or (np.abs(transforms) > 1e7).any():
        return False
    turns = transforms[:, :3, :3]
    straight = np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0) < 1e-3
    return bool(straight and (np.linalg.det(turns) > 0).all() and (transforms[:, 3] == (0.0, 0.0, 0.0, 1.0)).all())
