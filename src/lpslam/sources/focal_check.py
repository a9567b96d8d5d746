"""Whether a stated focal length fits the motion of the recording: wrong by a third, it shows in turns."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FocalCheckConfig
from lpslam.sources.plausibility import Doubt
from lpslam.sources.rigidity import MeasuringNoise, ViewPair, bending

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class FocalCurve:
    """How rigid the pairs are at some focal lengths.

    Attributes:
        focals: (f,) pixels, rising.
        bending: (p, f) of each pair; see `rigidity.bending`.
    """

    focals: Array
    bending: Array

    @property
    def best(self) -> float:
        """The focal length at which all pairs together are most rigid, between the samples."""
        return float(_lowest(self.focals, self.bending.mean(axis=0)[None])[0])

    def redrawn(self, count: int) -> Array:
        """The best focal lengths (count,) of as many draws of the pairs with replacement (Efron 1979).

        Each pair is one witness: what its places have in common (a moving person, a depth that lags) counts once.
        """
        pairs = len(self.bending)
        drawn = np.random.default_rng(0).integers(0, pairs, (count, pairs))
        return _lowest(self.focals, self.bending[drawn].mean(axis=1))

    def gain(self, focal: float) -> float:
        """By which share all pairs bend more at `focal` than at the best sample."""
        total = self.bending.mean(axis=0)
        return float(np.interp(np.log(focal), np.log(self.focals), total) / total.min() - 1.0)


def _lowest(focals: Array, curves: Array) -> Array:
    """Where curves (n, f) are lowest, by a parabola in log f through the lowest sample and its neighbours; (n,)."""
    x = np.log(focals)
    k = np.clip(curves.argmin(axis=1), 1, len(focals) - 2)
    rows = np.arange(len(curves))
    before, after = x[k] - x[k - 1], x[k + 1] - x[k]
    fall = (curves[rows, k] - curves[rows, k - 1]) / before
    rise = (curves[rows, k + 1] - curves[rows, k]) / after
    bend = np.maximum(rise - fall, 1e-12)
    # The slope at the middle sample over the change of slope.
    offset = -(fall * after + rise * before) / (2.0 * bend)
    return np.asarray(np.exp(x[k] + np.clip(offset, -before, after)))


def focal_curve(
    pairs: Sequence[ViewPair], camera: PinholeCamera, ratios: Array, config: FocalCheckConfig
) -> FocalCurve:
    """The curve at some ratios (f,), rising, to the camera's focal length; lenses are taken to be free of distortion.

    Leaving distortion out moves the best focal length by a few per cent, and spares what a wrong one would do.
    """
    stretch = np.array([1.0, camera.fx / camera.fy])
    centre = np.array([camera.cx, camera.cy])
    square = [
        ViewPair((pair.pixels - centre) * stretch, pair.depth, (pair.other_pixels - centre) * stretch, pair.other_depth)
        for pair in pairs
    ]
    noise = MeasuringNoise(config.pixel_sigma, config.depth_sigma, config.depth_sigma_quadratic)
    focals = camera.fx * ratios
    return FocalCurve(focals, bending(square, (0.0, 0.0), focals, noise))


def doubts_about_focal(pairs: Sequence[ViewPair], camera: PinholeCamera, config: FocalCheckConfig) -> list[Doubt]:
    """Whether another focal length makes the recording much more rigid than the stated one.

    Args:
        pairs: views of the recording.
        camera: the stated calibration.
        config: thresholds.
    """
    if len(pairs) < config.min_pairs:
        return []
    curve = focal_curve(pairs, camera, np.array(config.ratios), config)
    if not _is_doubtful(curve, camera.fx, config):
        return []
    if camera.is_distorted:
        # A strong lens bends the room as another focal length would: the stated one must not explain it either.
        straight = focal_curve(_undistorted(pairs, camera), camera, np.array(config.ratios), config)
        if not _is_doubtful(straight, camera.fx, config):
            return []
    better = float(f"{curve.best:.2g}")
    return [
        Doubt(
            f"with fx {camera.fx:g} the room bends when the camera turns; about {better:g} would keep it rigid: "
            "run 'lpslam calibrate' on the recording, and give what it writes with --camera"
        )
    ]


def _is_doubtful(curve: FocalCurve, focal: float, config: FocalCheckConfig) -> bool:
    """Whether nearly all draws of the pairs are much more rigid at a focal length far off on one side."""
    if curve.gain(focal) < config.min_gain:
        return False
    ratios = np.log(curve.redrawn(config.redraws) / focal)
    limit = np.log(config.doubtful_ratio)
    return bool(max((ratios > limit).mean(), (ratios < -limit).mean()) >= config.min_agreement)


def _undistorted(pairs: Sequence[ViewPair], camera: PinholeCamera) -> list[ViewPair]:
    return [
        ViewPair(camera.undistort(pair.pixels), pair.depth, camera.undistort(pair.other_pixels), pair.other_depth)
        for pair in pairs
    ]
