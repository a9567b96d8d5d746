"""From views to a lens: matches, a first guess of everything, and rounds of adjustment, each with better matches."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.calibration.adjustment import Observations, Prior, State, adjust, errors, lens_covariance
from lpslam.calibration.lens import K3, with_lens
from lpslam.calibration.tracks import Likeness, first_poses, likenesses, observe, rigid_matches
from lpslam.calibration.views import View
from lpslam.camera import PinholeCamera
from lpslam.config import CalibratingConfig, SensorNoiseConfig

Array = NDArray[np.float64]

_ROUNDS = 3
"""Of judging outliers and the noise anew after an adjustment."""

_MEDIAN_PIXEL, _MEDIAN_DEPTH = 1.3863, 0.4549
"""Medians of the χ² distribution with two degrees of freedom and with one."""


@dataclass(frozen=True, slots=True, eq=False)
class Solution:
    """A lens and what it was found from.

    Attributes:
        camera: with the lens.
        covariance: (10, 10) of the lens, in the order of `lens.NAMES`; scaled by how far the observations really stray.
        seen: the observations that agree, with their sigmas as they turned out.
        state: poses and points.
        views: (v,) numbers of the views whose poses these are.
        pixel_rms: pixels, root mean square of the reprojection errors.
    """

    camera: PinholeCamera
    covariance: Array
    seen: Observations
    state: State
    views: NDArray[np.int64]
    pixel_rms: float

    @property
    def sigma(self) -> Array:
        """(10,) standard deviations."""
        return np.sqrt(np.diag(self.covariance))


def solve(
    views: Sequence[View], camera: PinholeCamera, noise: SensorNoiseConfig, config: CalibratingConfig
) -> Solution | None:
    """The lens that explains the views; None where too few of them hang together.

    Args:
        views: the chosen frames.
        camera: a first guess; its focal length good to a tenth.
        noise: how far keypoints and depths stray, before it is seen.
        config: thresholds.
    """
    alike = likenesses(views, config)
    solution = None
    for tolerance in (config.first_match_pixels, config.match_pixels):
        guess = camera if solution is None else solution.camera
        found = _gathered(views, alike, guess, tolerance, noise, config)
        if found is None:
            return None
        together, seen, start = found
        solution = _settled(camera, seen, start, together, prior_of(camera, config, with_k3=False), config)
    return solution if solution is None else _with_k3(camera, solution, config)


def prior_of(camera: PinholeCamera, config: CalibratingConfig, *, with_k3: bool) -> Prior:
    """What is known of any lens: the focal length nothing, the rest within what cameras have."""
    off_centre = config.centre_prior * camera.width
    sigma = np.array([1e6, 1e6, off_centre, off_centre, *config.distortion_prior, config.readout_prior])
    if not with_k3:
        sigma[K3] = 0.0
    mean = np.array([camera.fx, camera.fx, (camera.width - 1) / 2, (camera.height - 1) / 2, *(6 * [0.0])])
    return Prior(mean, sigma, config.aspect_prior)


def part(solution: Solution, views: NDArray[np.bool_], config: CalibratingConfig) -> Solution | None:
    """The lens by some of a solution's views (v,) alone, with the matches that it has; None where they are too few."""
    number = np.cumsum(views) - 1
    if views.sum() < config.min_views // 2:
        return None
    seen = _shared(solution.seen.where(views[solution.seen.view]))
    if len(seen.view) < config.min_observations // 2:
        return None
    seen = replace(seen, view=number[seen.view])
    points, rows = np.unique(seen.point, return_inverse=True)
    poses = solution.state.camera_from_world[views]
    start = State(solution.state.lens, poses, solution.state.points[points])
    prior = prior_of(solution.camera, config, with_k3=solution.state.lens[K3] != 0)
    seen = replace(seen, point=rows)
    state = adjust(seen, start, prior, config.steps)
    return _solution(solution.camera, seen, state, solution.views[views], prior)


def _gathered(
    views: Sequence[View],
    alike: Sequence[Likeness],
    guess: PinholeCamera,
    tolerance: float,
    noise: SensorNoiseConfig,
    config: CalibratingConfig,
) -> tuple[NDArray[np.int64], Observations, State] | None:
    """Views that hang together, what they see, and a first state; None where it is too little."""
    matches = rigid_matches(views, alike, guess, tolerance, config)
    if not matches:
        return None
    together, poses = first_poses(matches, len(views))
    seen, start = observe(views, matches, together, guess, poses, noise, config)
    if len(together) < config.min_views or len(seen.view) < config.min_observations:
        return None
    return together, seen, start


def _settled(
    camera: PinholeCamera,
    seen: Observations,
    start: State,
    together: NDArray[np.int64],
    prior: Prior,
    config: CalibratingConfig,
) -> Solution:
    """Adjust, judge what agrees and how far it strays, and again."""
    state = adjust(seen, start, prior, config.steps)
    everything = seen
    for _ in range(_ROUNDS):
        scaled, agrees = _judged(everything, seen, state, config.gate)
        everything, seen = scaled, _shared(scaled.where(agrees))
        state = adjust(seen, state, prior, config.steps)
    return _solution(camera, seen, state, together, prior)


def _with_k3(camera: PinholeCamera, solution: Solution, config: CalibratingConfig) -> Solution:
    """The same with k3 free, where the views tell it."""
    start, seen = solution.state, solution.seen
    freer = _settled(camera, seen, start, solution.views, prior_of(camera, config, with_k3=True), config)
    return freer if abs(freer.state.lens[K3]) > config.k3_significance * freer.sigma[K3] else solution


def _judged(
    everything: Observations, used: Observations, state: State, gate: float
) -> tuple[Observations, NDArray[np.bool_]]:
    """All observations with sigmas as large as the used ones stray, and which of them agree within the gate.

    The least-squares fit has taken part of the noise: as much as it has unknowns for its equations.
    """
    pixel, depth = errors(used, state)
    has_depth = used.inverse_depth > 0
    equations = 2 * len(pixel) + int(has_depth.sum())
    unknowns = 3 * len(np.unique(used.point)) + 6 * len(state.camera_from_world) + 3
    taken = np.sqrt(equations / max(equations - unknowns, equations / 10))
    pixel_scale = np.sqrt(np.median((pixel**2).sum(axis=1)) / _MEDIAN_PIXEL) * taken
    depth_scale = np.sqrt(np.median(depth[has_depth] ** 2) / _MEDIAN_DEPTH) * taken if has_depth.any() else 1.0
    scaled = everything.scaled(max(float(pixel_scale), 1e-3), max(float(depth_scale), 1e-3))
    pixel, depth = errors(scaled, state)
    agrees = np.linalg.norm(pixel, axis=1) < gate
    wrong_depth = np.abs(depth) > gate
    inverse_depth = np.where(wrong_depth, 0.0, scaled.inverse_depth)
    return replace(scaled, inverse_depth=inverse_depth), agrees


def _shared(seen: Observations) -> Observations:
    """Without points that only one view is left for, or no depth."""
    count = int(seen.point.max(initial=-1)) + 1
    views = np.bincount(seen.point, minlength=count)
    return seen.where(views[seen.point] > 1)


def _solution(
    camera: PinholeCamera, seen: Observations, state: State, views: NDArray[np.int64], prior: Prior
) -> Solution:
    pixel, depth = errors(seen, state)
    equations = 2 * len(pixel) + int((seen.inverse_depth > 0).sum())
    unknowns = 3 * len(np.unique(seen.point)) + 6 * len(state.camera_from_world) + 3
    variance = float(((pixel**2).sum() + (depth**2).sum()) / max(equations - unknowns, 1))
    covariance = lens_covariance(seen, state, prior) * max(variance, 1e-12)
    rms = float(np.sqrt(np.mean(((pixel * seen.pixel_sigma[:, None]) ** 2).sum(axis=1))))
    return Solution(with_lens(camera, state.lens), covariance, seen, state, views, rms)
