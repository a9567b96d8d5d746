"""The measuring model of the camera: intrinsics as kernels take them, and the weights of what it measures."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SlamConfig


@dataclass(frozen=True, slots=True, eq=False)
class SensorModel:
    """Constants of one camera under one configuration.

    Attributes:
        intrinsics: (fx, fy, cx, cy, b·fx), with the virtual baseline b that turns depth into disparity.
        image_size: width, height.
        scales: (levels,) size of each pyramid level.
        pixel_information: (levels,) 1/σ² of a keypoint at each level.
        log_scale: logarithm of the scale factor.
    """

    intrinsics: NDArray[np.float64]
    image_size: tuple[int, int]
    scales: NDArray[np.float64]
    pixel_information: NDArray[np.float32]
    log_scale: float
    depth_sigma: float
    depth_sigma_quadratic: float

    @classmethod
    def of(cls, camera: PinholeCamera, config: SlamConfig) -> "SensorModel":
        """The model of a camera."""
        scales: NDArray[np.float64] = config.features.scale_factor ** np.arange(config.features.levels, dtype=float)
        return cls(
            intrinsics=np.array(
                [camera.fx, camera.fy, camera.cx, camera.cy, camera.fx * config.features.virtual_baseline]
            ),
            image_size=(camera.width, camera.height),
            scales=scales,
            pixel_information=(
                1.0 / (config.noise.pixel_sigma**2 + (config.noise.level_pixel_sigma * scales) ** 2)
            ).astype(np.float32),
            log_scale=float(np.log(config.features.scale_factor)),
            depth_sigma=config.noise.depth_sigma,
            depth_sigma_quadratic=config.noise.depth_sigma_quadratic,
        )

    def depth_sigma_at(self, z: NDArray[np.float64]) -> NDArray[np.float64]:
        """Metres, of depths (n,) in metres: σ_z = c + q z², since disparity noise is seen through a baseline."""
        return self.depth_sigma + self.depth_sigma_quadratic * z**2

    def disparity(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """The virtual disparity u − u_r = b·fx / z, pixels, of depths (n,) in metres; 0 where there is none."""
        disparity = np.zeros(len(depth), np.float32)
        np.divide(self.intrinsics[4], depth, out=disparity, where=depth > 0, casting="unsafe")
        return disparity

    def disparity_information(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """1/σ² of the disparity b·fx / z for depths (n,) in metres; 0 where there is none.

        The sensor's noise σ_z makes σ_d = b·fx / z² · σ_z.
        """
        z = np.where(depth > 0, depth, 1.0).astype(np.float64)
        sigma = self.intrinsics[4] / z**2 * self.depth_sigma_at(z)
        return np.where(depth > 0, 1.0 / sigma**2, 0.0).astype(np.float32)

    def back_project(self, pixels: NDArray[np.float32], depth: NDArray[np.float32]) -> NDArray[np.float64]:
        """(n, 3) metres in the camera frame of pixels (n, 2) with depth (n,) (Eq. 7)."""
        fx, fy, cx, cy, _ = self.intrinsics
        z = depth.astype(np.float64)
        return np.column_stack([(pixels[:, 0] - cx) / fx * z, (pixels[:, 1] - cy) / fy * z, z])


class Reach:
    """How far a sensor reads depth, by the keypoints that have any.

    Args:
        least: keypoints with depth in a view that tell it.
        share: of the readings within the reach; the last few may be false.

    Attributes:
        metres: beyond which depth has been read nowhere, but for those few; infinite before any view told it.
    """

    def __init__(self, least: int, share: float) -> None:
        self._least = least
        self._share = share
        self.metres = np.inf

    def see(self, depths: NDArray[np.float32]) -> float:
        """Take the depths (n,) of a view's keypoints, metres; the reach by now."""
        if len(depths) >= self._least:
            seen = float(np.quantile(depths, self._share))
            self.metres = seen if np.isinf(self.metres) else max(self.metres, seen)
        return self.metres
