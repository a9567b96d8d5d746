"""Calibration of a recording, from its frames to what is known of the camera and how surely."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.calibration.lens import gap
from lpslam.calibration.metric import TrueScale, true_scale
from lpslam.calibration.solving import Solution, part, solve
from lpslam.calibration.views import View, chosen, travel_of, views_of
from lpslam.camera import PinholeCamera
from lpslam.config import CalibratingConfig, Config
from lpslam.errors import UserError
from lpslam.poses import StampedPoses
from lpslam.sources.focal_check import FocalCurve, focal_curve
from lpslam.sources.followed_pairs import pairs_of
from lpslam.sources.image_pairs import ImagePairSource
from lpslam.sources.recorded import RecordedSource
from lpslam.sources.registering.by_contours import FoundDisplacement, find_displacement

Array = NDArray[np.float64]

_CENTRE_AND_FOCAL = 4
"""Numbers by which halves are compared: fx, fy, cx, cy. Terms of distortion stand in for each other."""


@dataclass(frozen=True, slots=True, eq=False)
class Halves:
    """The lenses of the two halves of a recording, and how far they differ.

    Attributes:
        first, second: what each half alone says.
        deviations: root mean square of the differences of fx, fy, cx and cy, in their standard deviations.
        pixels: mean distance at which they show the same ray, apart from a turn.
        agree: whether one of the two is within what is allowed.
    """

    first: PinholeCamera
    second: PinholeCamera
    deviations: float
    pixels: float
    agree: bool


@dataclass(frozen=True, slots=True, eq=False)
class Calibrated:
    """What a recording says of its camera.

    Attributes:
        camera: the calibration.
        sigma: (10,) standard deviations of its lens in the order of `lens.NAMES`; at least half of what the halves
            differ by.
        readout: seconds that the shutter rolls from the first line to the last, with its standard deviation.
        guess: the focal length at which pairs of views were most rigid, before anything was adjusted.
        solution: the adjustment.
        halves: None where a half is too little.
        scale: true metres in a metre of depth; None without a true path, or one that tells too little.
        displacement: how depth lies beside colour; None where it is registered, as far as its contours tell.
    """

    camera: PinholeCamera
    sigma: Array
    readout: tuple[float, float]
    guess: float
    solution: Solution
    halves: Halves | None
    scale: TrueScale | None
    displacement: FoundDisplacement | None = None


def calibrate(
    source: RecordedSource,
    config: Config,
    truth: StampedPoses | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Calibrated:
    """Estimate focal lengths, principal point and distortion; with a true path also the depth scale.

    Of a folder whose depth is not registered to colour, how it lies is estimated first.

    Args:
        source: a recording, opened with any calibration: only the size of its images and its depth scale are believed.
        config: thresholds.
        truth: the camera's true path, if it is known.
        on_progress: called with (frames looked at, frames in all).

    Raises:
        UserError: the recording does not tell; says what it lacks.
    """
    settings = config.calibrating
    source, displacement = _registered(source, config)
    guess = _guessed_focal(source, config)
    travel = travel_of(source.frame, len(source), settings, on_progress)
    views = views_of(source.frame, chosen(travel, settings), source.camera, settings)
    start = _plain(source.camera, guess)
    solution = solve(views, start, config.slam.noise, settings) if len(views) >= settings.min_views else None
    if solution is None:
        raise UserError(
            f"{source.name}: too few of its {len(views)} views hang together to calibrate by; "
            "move slowly through a textured room, and let what is seen come back into view"
        )
    focal_sigma = float(solution.sigma[0] / solution.camera.fx)
    if not focal_sigma <= settings.max_focal_sigma:
        raise UserError(
            f"{source.name}: it tells the focal length to {focal_sigma:.0%} only; "
            "turn the camera left and right, up and down, and about its axis"
        )
    halves = _halves(solution, settings)
    # Where the cameras stand apart, nothing says of which of them the true path is.
    scale = _scale(views, solution, None if displacement else truth, settings)
    sigma = solution.sigma
    if halves is not None:
        sigma = np.maximum(sigma, _apart(halves) / 2.0)
    camera = solution.camera
    if scale is not None:
        camera = replace(camera, depth_scale=camera.depth_scale / scale.ratio)
    readout = (float(solution.state.lens[-1]), float(solution.sigma[-1]))
    return Calibrated(camera, sigma, readout, guess, solution, halves, scale, displacement)


def _registered(source: RecordedSource, config: Config) -> tuple[RecordedSource, FoundDisplacement | None]:
    """Frames with depth registered to colour, and how it was found to lie; bags say that themselves."""
    if not isinstance(source, ImagePairSource):
        return source, None
    check = config.calibration.registration
    found = find_displacement(source.sample_frames(check.estimating_frames), check)
    if found is not None and (found.is_displaced or (found.is_told and not source.is_of_one_size)):
        return source.registered(found.displacement), found
    if source.is_of_one_size:
        return source, None
    raise UserError(
        f"{source.name}: depth has other images than colour, and too few contours of things to tell how it lies; "
        "record where chairs, boxes or door frames stand before what is farther"
    )


def _plain(camera: PinholeCamera, focal: float) -> PinholeCamera:
    """A camera of which only a focal length is guessed."""
    middle = ((camera.width - 1) / 2, (camera.height - 1) / 2)
    return PinholeCamera(
        camera.width, camera.height, focal, focal, *middle, depth_scale=camera.depth_scale, fps=camera.fps
    )


def _guessed_focal(source: RecordedSource, config: Config) -> float:
    """The focal length at which pairs of views are most rigid, whatever the calibration says."""
    check = config.calibration.focal.model_copy(update={"pairs": config.calibrating.search_pairs})
    pairs = pairs_of(source.frame, source.timestamps, check)
    if len(pairs) < check.min_pairs:
        raise UserError(
            f"{source.name}: only {len(pairs)} pairs of its frames show the same places with depth after a motion; "
            "record a textured room, in light, within reach of the depth sensor, with the camera moving"
        )
    least, most = config.calibrating.search_focals
    width = source.camera.width
    middle = _plain(source.camera, float(width))
    ratios = np.geomspace(least, most, config.calibrating.search_steps)
    curve = focal_curve(pairs, middle, ratios, check)
    if _is_flat(curve, config.calibrating):
        raise UserError(
            f"{source.name}: its frames look as rigid with any focal length, since the camera hardly turns; "
            "turn it left and right, up and down, and about its axis"
        )
    return curve.best


def _is_flat(curve: FocalCurve, config: CalibratingConfig) -> bool:
    """Whether draws of the pairs do not agree on a focal length, even roughly."""
    low, high = np.percentile(curve.redrawn(200), (5, 95))
    return bool(high / low > config.max_guess_ratio)


def _halves(solution: Solution, config: CalibratingConfig) -> Halves | None:
    is_first = np.arange(len(solution.views)) < len(solution.views) / 2
    first, second = part(solution, is_first, config), part(solution, ~is_first, config)
    if first is None or second is None:
        return None
    difference = (first.state.lens - second.state.lens)[:_CENTRE_AND_FOCAL]
    covariance = (first.covariance + second.covariance)[:_CENTRE_AND_FOCAL, :_CENTRE_AND_FOCAL]
    squared = difference @ np.linalg.solve(covariance, difference)
    deviations = float(np.sqrt(squared / _CENTRE_AND_FOCAL))
    pixels = float(gap(first.camera, second.camera).mean())
    agree = deviations <= config.half_deviations or pixels <= config.half_pixels
    return Halves(first.camera, second.camera, deviations, pixels, agree)


def _apart(halves: Halves) -> Array:
    """(10,) by how much the numbers of the halves differ; the shutter's is not compared."""
    first, second = halves.first, halves.second
    return np.abs(
        [
            *(getattr(first, name) - getattr(second, name) for name in ("fx", "fy", "cx", "cy")),
            *np.subtract(first.distortion, second.distortion),
            0.0,
        ]
    )


def _scale(
    views: list[View], solution: Solution, truth: StampedPoses | None, config: CalibratingConfig
) -> TrueScale | None:
    if truth is None:
        return None
    timestamps = np.array([views[view].timestamp for view in solution.views])
    scale = true_scale(timestamps, solution.state.camera_from_world, truth)
    return scale if scale is not None and 0 < scale.sigma < config.max_scale_sigma * scale.ratio else None
