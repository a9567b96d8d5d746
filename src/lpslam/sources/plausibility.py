"""Whether a calibration can be that of the images it comes with: mistakes that would otherwise show as a bent map.

A `Doubt` that is fatal leaves nothing to map; the others are said, and the recording is used as it is.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import CalibrationCheckConfig
from lpslam.errors import UserError

# Raw depth units in a metre that recordings come with, the most usual first: millimetres, TUM, metres, tenths of a
# millimetre, rendered data sets, and 1/256 m.
_USUAL_SCALES = (1000.0, 5000.0, 1.0, 10000.0, 6553.5, 256.0)
# A calibration of the same camera at another resolution is off by one of these.
_USUAL_RESIZINGS = (2.0, 0.5, 1.5, 2 / 3, 3.0, 1 / 3, 4.0, 0.25)


@dataclass(frozen=True, slots=True)
class Doubt:
    """Something about a recording that is probably a mistake.

    Attributes:
        text: what, and the remedy, in one line without the recording's name.
        is_fatal: whether nothing sensible can come of it.
    """

    text: str
    is_fatal: bool = False


def doubts_about_intrinsics(camera: PinholeCamera, config: CalibrationCheckConfig) -> list[Doubt]:
    """Resolution, or else field of view, shape of the pixels, principal point and distortion, each for itself."""
    resized = _doubt_resolution(camera, config)
    if resized is not None:
        return [resized]
    doubts = [
        _doubt_field_of_view(camera, config),
        _doubt_pixel_shape(camera, config),
        _doubt_principal_point(camera, config),
        _doubt_distortion(camera),
    ]
    return [doubt for doubt in doubts if doubt is not None]


def _doubt_resolution(camera: PinholeCamera, config: CalibrationCheckConfig) -> Doubt | None:
    """A principal point at the middle of larger or smaller images: everything else is off by the same factor."""
    offset = _centre_offset(camera)
    if offset <= config.centre_offset:
        return None
    ratio = np.array([camera.cx / camera.width, camera.cy / camera.height]) * 2
    for resizing in _USUAL_RESIZINGS:
        if np.abs(ratio / resizing - 1).max() < config.centre_offset:
            return Doubt(
                f"{_principal_point(camera)}, as if calibrated at {camera.width * resizing:.0f}×"
                f"{camera.height * resizing:.0f}: divide fx, fy, cx and cy by {resizing:.4g}",
                is_fatal=offset > 0.5,
            )
    return None


def _doubt_field_of_view(camera: PinholeCamera, config: CalibrationCheckConfig) -> Doubt | None:
    view = float(np.degrees(2 * np.arctan(camera.width / (2 * camera.fx))))
    stated = f"fx {camera.fx:g} sees {view:.0f}° across {camera.width} pixels"
    if not config.possible_view[0] <= view <= config.possible_view[1]:
        return Doubt(f"{stated}, which no RGB-D camera does; give fx and fy in pixels of these images", is_fatal=True)
    if not config.usual_view[0] <= view <= config.usual_view[1]:
        return Doubt(f"{stated}, which is unusual; check that fx and fy are in pixels of these images")
    return None


def _doubt_pixel_shape(camera: PinholeCamera, config: CalibrationCheckConfig) -> Doubt | None:
    aspect = camera.fx / camera.fy
    if max(aspect, 1 / aspect) <= 1 + config.aspect:
        return None
    return Doubt(
        f"fx {camera.fx:g} and fy {camera.fy:g} differ by {abs(aspect - 1):.0%}, but pixels are square in nearly every "
        "camera; check both, and whether the images were squeezed"
    )


def _doubt_principal_point(camera: PinholeCamera, config: CalibrationCheckConfig) -> Doubt | None:
    offset = _centre_offset(camera)
    if offset > 0.5:
        return Doubt(f"{_principal_point(camera)}, outside it; give cx and cy in pixels of these images", is_fatal=True)
    if offset > config.centre_offset:
        return Doubt(f"{_principal_point(camera)}; check cx and cy, and whether the images were cropped")
    return None


def _centre_offset(camera: PinholeCamera) -> float:
    """Of the principal point from the image's middle, as a share of width or height, whichever is more."""
    across = abs(camera.cx - (camera.width - 1) / 2) / camera.width
    return max(across, abs(camera.cy - (camera.height - 1) / 2) / camera.height)


def _principal_point(camera: PinholeCamera) -> str:
    offset = _centre_offset(camera)
    return f"the principal point ({camera.cx:g}, {camera.cy:g}) is {offset:.0%} of the image off its centre"


def _doubt_distortion(camera: PinholeCamera) -> Doubt | None:
    """What lies farther out in the view must lie farther out in the image: else coefficients are wrong or misplaced."""
    if not camera.is_distorted:
        return None
    k1, k2, _, _, k3 = camera.distortion
    corners = np.array([[x, y] for x in (0.0, camera.width - 1.0) for y in (0.0, camera.height - 1.0)])
    reach = np.linalg.norm((corners - [camera.cx, camera.cy]) / [camera.fx, camera.fy], axis=1).max()
    r2 = np.linspace(0.0, reach, 64) ** 2
    growth = 1 + r2 * (3 * k1 + r2 * (5 * k2 + r2 * 7 * k3))
    if growth.min() > 0:
        return None
    return Doubt("the distortion folds the image over; its terms must be k1, k2, p1, p2, k3, or zeros if rectified")


def doubts_about_depth(
    depths: Iterable[NDArray[np.float32]], camera: PinholeCamera, config: CalibrationCheckConfig
) -> list[Doubt]:
    """Whether the readings are those of a room.

    Args:
        depths: some frames, (height, width) metres; 0 and not finite where there is none.
        camera: its depth scale is what was applied.
        config: thresholds.
    """
    readings = _readings(depths)
    if not readings:
        return []
    median = float(np.median([np.median(reading) for reading in readings]))
    farthest = float(np.median([np.percentile(reading, 95) for reading in readings]))
    nearest, remotest = config.usual_median_depth
    if nearest <= median <= remotest and farthest <= config.usual_far_depth:
        return []
    is_fatal = not config.possible_median_depth[0] <= median <= config.possible_median_depth[1]
    stated = f"at depth_scale {camera.depth_scale:g} the median depth is {median:.3g} m"
    if nearest <= median <= remotest:
        stated += f" and a twentieth lies beyond {farthest:.3g} m"
    raw = median * camera.depth_scale
    fitting = [s for s in _USUAL_SCALES if config.room_depth[0] <= raw / s <= config.room_depth[1]]
    if not fitting:
        return [Doubt(f"{stated}; state the raw units in a metre as depth_scale in the calibration", is_fatal)]
    room = raw / fitting[0]
    return [Doubt(f"{stated}; depth_scale {fitting[0]:g} in the calibration would make it {room:.2g} m", is_fatal)]


def _readings(depths: Iterable[NDArray[np.float32]]) -> list[NDArray[np.float32]]:
    """What frames measure, metres, frame by frame; without those that measure nothing."""
    found = (depth[np.isfinite(depth) & (depth > 0)] for depth in depths)
    return [reading for reading in found if len(reading)]


def fitting_depth_scale(
    depths: Iterable[NDArray[np.float32]], camera: PinholeCamera, config: CalibrationCheckConfig
) -> float:
    """Raw units in a metre, where nothing states them: the camera's if what is far then lies as far as rooms are wide.

    Else the most usual ones with which it does. What is far tells it better than the median: a hand or a desk may fill
    half of the view.

    Args:
        depths, config: as above.
        camera: its depth scale, which was applied, is the one assumed.

    Raises:
        UserError: there is one reading alone, which tells nothing.
    """
    readings = _readings(depths)
    if len(readings) > 1 and all(reading.min() == reading.max() == readings[0][0] for reading in readings):
        raise UserError(
            "its depth is the same everywhere and always, and nothing states its units; check the depth images, and "
            "state depth_scale in the calibration"
        )
    farthest = [float(np.percentile(reading, 95)) for reading in readings]
    if not farthest:
        return camera.depth_scale
    raw, (nearest, remotest) = max(farthest) * camera.depth_scale, config.usual_farthest
    scales = (camera.depth_scale, *_USUAL_SCALES)
    return next((scale for scale in scales if nearest <= raw / scale <= remotest), camera.depth_scale)


def doubts_about_timing(
    colour_times: NDArray[np.float64], depth_times: NDArray[np.float64], config: CalibrationCheckConfig
) -> list[Doubt]:
    """Whether colour and depth were taken at the same moments.

    Nearest times pair any two regular lists, also when one clock is seconds off: then the k-th images belong together,
    and their times tell by how much.

    Args:
        colour_times, depth_times: (n,), (m,) seconds, rising, all that are listed.
        config: thresholds.
    """
    if min(len(colour_times), len(depth_times)) < config.timing_frames:
        return []
    if len(colour_times) == len(depth_times):
        lags = depth_times - colour_times
        lag = float(np.median(lags))
        is_steady = float(np.percentile(np.abs(lags - lag), 90)) < config.steady_lag
        if is_steady and abs(lag) > np.median(np.diff(colour_times)) / 2:
            return [
                Doubt(
                    f"every depth image is stamped {abs(lag):.3f} s {_order(lag)} its colour image, counted "
                    "from the first; if one clock is off, shift the times of depth.txt by that"
                )
            ]
    after = np.clip(np.searchsorted(depth_times, colour_times), 1, len(depth_times) - 1)
    around = np.stack([depth_times[after - 1], depth_times[after]]) - colour_times
    lags = np.take_along_axis(around, np.abs(around).argmin(axis=0)[None], axis=0)[0]
    lag = float(np.median(lags))
    if abs(lag) <= config.usual_lag:
        return []
    return [
        Doubt(
            f"depth is taken {1000 * abs(lag):.0f} ms {_order(lag)} colour, so in quick turns it lies beside "
            "the edges; synchronise the camera, or turn slowly"
        )
    ]


def _order(lag: float) -> str:
    return "after" if lag > 0 else "before"
