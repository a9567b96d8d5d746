"""The camera's way from surfaces and faint patterns where keypoints do not tell it (Steinbrücker 2011; Kerl 2013)."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import SurfaceConfig
from lpslam.slam.kernels.dense import align_terms, bring, descend
from lpslam.slam.kernels.geometry import exponential, logarithm
from lpslam.slam.sensor import SensorModel
from lpslam.slam.tracking.relief import likeness, relief, shift_between, shift_of
from lpslam.small_depth import SmallDepth

_Matrix = NDArray[np.float64]
_Image = NDArray[np.float32]


@dataclass(frozen=True, slots=True, eq=False)
class Aligned:
    """How an image lies to a reference.

    Attributes:
        image_from_reference: 4×4.
        shared: of the reference's pixels with depth, the share that the image shows.
        holds: whether the images agree, and say all six degrees of freedom by themselves.
        tells_turn: whether they agree, and say how the camera turned.
        likeness: of their grey values, in sigmas of those that have nothing in common.
        is_proven: whether they lie on each other so, and nowhere else nearly as well.
        information: (6, 6) of a twist (translation, rotation vector) from the left, what the images alone tell.
    """

    image_from_reference: _Matrix
    shared: float
    holds: bool
    tells_turn: bool
    likeness: float = 0.0
    is_proven: bool = False
    information: _Matrix = field(default_factory=lambda: np.zeros((6, 6)))


@dataclass(frozen=True, slots=True, eq=False)
class _Level:
    """Two images of one size: a reference (2, h, w), an image (h, w, 6) as of `sloped`, and fx, fy, cx, cy of both."""

    reference: _Image
    image: _Image
    intrinsics: _Matrix

    @property
    def images(self) -> tuple[_Image, _Image, _Matrix]:
        """As kernels take them."""
        return self.reference, self.image, self.intrinsics

    @property
    def shades(self) -> _Image:
        """(h, w) relief of the image."""
        return np.ascontiguousarray(self.image[..., 0])

    @property
    def smooth(self) -> _Image:
        """(h, w) depth of the image; not a number off smooth surfaces."""
        return np.ascontiguousarray(self.image[..., 3])


class _Terms(NamedTuple):
    """Normal equations of a pose.

    Attributes:
        hessian, gradient: (6, 6) and (6,).
        residuals: (2, n) of grey values, and those of the reference, of the pixels that fell into the image.
        inside, measured, agreeing: how many these are, how many have depth in both, and how many of those agree.
    """

    hessian: _Matrix
    gradient: _Matrix
    residuals: _Matrix
    inside: int
    measured: int
    agreeing: int


@dataclass(frozen=True, slots=True, eq=False)
class _Descent:
    """Where Gauss-Newton has come to on one level.

    Attributes:
        pose: 4×4 image from reference.
        terms: of the last step.
        shared: of the reference's pixels with depth, the share that fell into the image.
    """

    pose: _Matrix
    terms: _Terms
    shared: float


@dataclass(frozen=True, slots=True, eq=False)
class _Brought:
    """Where a pose brings the pixels of a reference.

    Attributes:
        across, down: (h, w) pixels in the image; -1 where there is none.
        by_noise: (6, 6) what slopes of depth that are noise alone would tell of the pose.
    """

    across: _Image
    down: _Image
    by_noise: _Matrix


class SmallImages:
    """Makes small images without lens distortion of a camera's frames.

    Args:
        camera: of the frames.
        width: pixels across the small images.
        around: pixels of them over which grey values are compared with those about them.
        edge: share of the depth by which neighbours on one surface differ at most.
    """

    def __init__(self, camera: PinholeCamera, width: int, around: float, edge: float) -> None:
        self._around = around
        self._edge = edge
        self._depth = SmallDepth(camera, max(width, 16))
        self._size, self.intrinsics = self._depth.size, self._depth.intrinsics
        small = ((self._depth.raw + 0.5) / self._depth.shrink - 0.5).astype(np.float32)
        small = small.reshape(*self._size[::-1], 2)
        self._shades_at = np.ascontiguousarray(small[..., 0]), np.ascontiguousarray(small[..., 1])

    def reference(self, gray: NDArray[np.uint8], depth: _Image) -> _Image:
        """(2, h, w) relief of the grey values and depth, as `align_terms` takes them."""
        shades = cv2.resize(gray.astype(np.float32), self._size, interpolation=cv2.INTER_AREA)
        shades = cv2.remap(shades, *self._shades_at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.stack(
            [relief(np.asarray(shades, np.float32), self._around), without_holes(self._depth.read(depth), self._edge)]
        )


def sloped(reference: _Image, edge: float) -> _Image:
    """(h, w, 6) of (2, h, w): with slopes along u and v; depth where neighbours differ by less than `edge` of it."""
    shades, depth = reference
    kernel = np.ones((3, 3), np.uint8)
    far, near = cv2.dilate(depth, kernel), cv2.erode(depth, kernel)
    smooth = np.where((near > 0) & (far - near < edge * far), depth, np.nan).astype(np.float32)
    slopes = [cv2.Sobel(depth, cv2.CV_32F, *way, ksize=3, scale=0.125) for way in _WAYS]
    shade_slopes = [cv2.Sobel(shades, cv2.CV_32F, *way, ksize=3, scale=0.125) for way in _WAYS]
    return np.stack([shades, *shade_slopes, smooth, *slopes], axis=-1)


def without_holes(depth: _Image, edge: float) -> _Image:
    """Depth (h, w) with the mean of a pixel's neighbours where most are known and lie on one surface.

    Dark and shiny surfaces have holes all over, and a slope needs all neighbours.
    """
    kernel = np.ones((3, 3), np.uint8)
    share = cv2.boxFilter((depth > 0).astype(np.float32), -1, (3, 3), borderType=cv2.BORDER_REPLICATE)
    far = cv2.dilate(depth, kernel)
    near = cv2.erode(np.where(depth > 0, depth, np.float32(np.inf)), kernel)
    is_hole = (depth <= 0) & (share >= _MOST) & (far - near < edge * far)
    mean = cv2.boxFilter(depth, -1, (3, 3), borderType=cv2.BORDER_REPLICATE) / np.maximum(share, _MOST)
    return np.where(is_hole, mean, depth).astype(np.float32)


class Surfaces:
    """Aligns frames with a reference by what every pixel shows.

    Args:
        camera, sensor: of the frames.
        config: thresholds.
    """

    def __init__(self, camera: PinholeCamera, sensor: SensorModel, config: SurfaceConfig) -> None:
        self.images = SmallImages(
            camera, min(config.width, camera.width // config.least_shrink), config.around, config.edge
        )
        self._noise = (sensor.depth_sigma, sensor.depth_sigma_quadratic)
        self._config = config

    def align(
        self, reference: _Image, image: _Image, guess: _Matrix, seconds: float, before: _Matrix | None = None
    ) -> Aligned | None:
        """Find the pose between two small images (2, h, w) from a guess of it (4×4, image from reference).

        Where they say nothing, the guess stays, which has been made for so many seconds. Where they do not prove it,
        the pose `before` is tried as well, and where the pictures as a whole lie. None if they hardly overlap.
        """
        levels = [self._level(reference, image, times) for times in (1, 0)]
        best: Aligned | None = None
        for start in self._starts(reference, image, guess, before):
            found = self._from(levels, start, max(seconds, LEAST_SECONDS))
            if found is not None and (best is None or found.likeness > best.likeness):
                best = found
            if found is not None and found.is_proven:
                return found
        return best

    def unlikeness(self, reference: _Image, image: _Image, pose: _Matrix) -> float:
        """Grey values by which most pixels of two small images differ at a pose (4×4, image from reference); median.

        Infinite where they do not overlap.
        """
        brightness = float(np.median(reference[0]) - np.median(image[0])), self._config.first_shade
        terms = self._terms(self._level(reference, image, 0), pose, brightness)
        return float(np.median(np.abs(terms.residuals[0]))) if terms.inside else np.inf

    def _starts(self, reference: _Image, image: _Image, guess: _Matrix, before: _Matrix | None) -> Iterator[_Matrix]:
        """Poses from which to align: the guess, and where the camera was, either also turned as the pictures lie."""
        intrinsics = self.images.intrinsics
        for pose in (guess,) if before is None or np.array_equal(before, guess) else (guess, before):
            yield pose
            shift = shift_between(reference[0], image[0], pose[:3, :3], intrinsics)
            if max(abs(shift.across), abs(shift.down)) > 1 and shift.lead > self._config.lead:
                yield exponential(np.concatenate([np.zeros(3), shift.turn(intrinsics)])) @ pose

    def _level(self, reference: _Image, image: _Image, times: int) -> "_Level":
        """Two small images (2, h, w), halved so many times."""
        shrink = 2.0**times
        intrinsics = self.images.intrinsics / shrink
        intrinsics[2:] += 0.5 / shrink - 0.5
        edge = self._config.edge
        return _Level(halved(reference, times, edge), sloped(halved(image, times, edge), edge), intrinsics)

    def _from(self, levels: Sequence["_Level"], start: _Matrix, seconds: float) -> Aligned | None:
        """The same from one pose, which also stays where they say nothing: coarse images first, for the reach."""
        descent: _Descent | None = None
        for level in levels:
            descent = self._descended(level, start if descent is None else descent.pose, start, seconds)
            if descent is None:
                return None
        assert descent is not None
        return self._judged(levels[-1], descent, start, seconds)

    def guess_sigmas(self, seconds: float) -> _Matrix:
        """(6,) of a guess, in metres and radians, made for so many seconds."""
        return np.repeat([self._config.guess_speed, self._config.guess_turn], 3) * seconds

    def _descended(self, level: "_Level", pose: _Matrix, guess: _Matrix, seconds: float) -> "_Descent | None":
        """Gauss-Newton from a pose on one level, until a step is a small part of what the images can tell."""
        config, reference, every = self._config, level.reference, self._config.thinned
        known = max((reference[1] > 0).sum() / every, 1.0)
        offset = float(np.median(reference[0]) - np.median(level.shades))
        pose, hessian, gradient = pose.copy(), np.empty((6, 6)), np.empty(6)
        residuals = self._room_for_residuals(level)
        counts = descend(
            level.images,
            pose,
            (inverse_transform(guess), self.guess_sigmas(seconds) ** -2),
            (offset, config.first_shade, config.shade_doubt, config.least_shade),
            self._noise,
            every,
            (
                config.steps,
                config.least_shared * known,
                config.least_measured * reference[0].size / every,
                config.settled**2,
            ),
            (hessian, gradient, residuals),
        )
        if counts[0] < 0:
            return None
        terms = _Terms(_symmetric(hessian), gradient, residuals[:, : counts[0]], *counts)
        return _Descent(pose, terms, terms.inside / known)

    def _terms(self, level: "_Level", pose: _Matrix, brightness: tuple[float, float]) -> "_Terms":
        """`align_terms` of a level."""
        hessian, gradient, residuals = np.empty((6, 6)), np.empty(6), self._room_for_residuals(level)
        every = self._config.thinned
        counts = align_terms(*level.images, pose, brightness, self._noise, every, hessian, gradient, residuals)
        return _Terms(_symmetric(hessian), gradient, residuals[:, : counts[0]], *counts)

    def _room_for_residuals(self, level: "_Level") -> _Matrix:
        """(2, n) for the pixels of a level that are asked."""
        height, width = level.reference.shape[1:]
        return np.empty((2, height * (width // self._config.thinned + 1)))

    def _judged(self, level: "_Level", descent: "_Descent", guess: _Matrix, seconds: float) -> Aligned:
        """What a descent on the finest images has come to."""
        config, pose, sigmas = self._config, descent.pose, self.guess_sigmas(seconds)
        terms = descent.terms
        alike = likeness(terms.residuals[1], terms.residuals[0] + terms.residuals[1])
        seen = self._brought(level.reference, pose)
        is_proven = self._is_proven(level, seen)
        is_like = is_proven or alike > config.least_likeness
        told = self._told(level, descent, seen, is_like)
        # By eigenvalues in units of the guess: in the direction that the images tell worst.
        information = told
        told = told * np.outer(sigmas, sigmas) * config.told_share**2
        is_firm = bool(np.linalg.eigvalsh(told)[0] > 1.0)
        is_blank = self._is_blank(level.reference[0]) or self._is_blank(level.shades)
        # A wall tells how the camera turns away from it; where nothing is on it, nothing tells how it rolls before it.
        is_turn_firm = is_firm or bool(np.linalg.eigvalsh(_of_turn(told))[1 if is_blank else 0] > 1.0)
        least = config.proven_agreement if is_like else config.least_agreement
        astray = logarithm(pose @ inverse_transform(guess))
        is_near = is_proven or bool((np.abs(astray) <= config.guess_sigmas * sigmas).all())
        agrees = terms.agreeing >= least * terms.measured and (is_like or is_blank) and is_near
        return Aligned(pose, descent.shared, is_firm and agrees, is_turn_firm and agrees, alike, is_proven, information)

    def _brought(self, reference: _Image, pose: _Matrix) -> "_Brought":
        """Where a pose brings the pixels of a reference that have depth."""
        across, down = np.empty((2, *reference[0].shape), np.float32)
        by_noise = bring(reference[1], self.images.intrinsics, pose, self._config.nearest, _SOBEL_NOISE, across, down)
        return _Brought(across, down, by_noise)

    def _is_proven(self, level: "_Level", seen: "_Brought") -> bool:
        """Whether reliefs that a pose brings together lie on each other, and nowhere else nearly as well."""
        there = cv2.remap(
            level.shades, seen.across, seen.down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0
        )
        shift = shift_of(level.reference[0], np.asarray(there, np.float32))
        return max(abs(shift.across), abs(shift.down)) <= 1 and shift.lead > self._config.lead

    def _told(self, level: "_Level", descent: "_Descent", seen: "_Brought", by_shades: bool) -> _Matrix:
        """(6, 6) what two images tell of a pose: less what noise alone would."""
        noise, measured = self._depth_noise(level.smooth), descent.terms.measured / descent.terms.inside
        by_depth = self._terms(level, descent.pose, (0.0, _NEVER)).hessian
        told = (by_depth - noise**2 * measured * seen.by_noise) / max(noise, self._config.least_noise) ** 2
        if not by_shades:
            return told
        return told + (descent.terms.hessian - by_depth - _SMOOTHED / self._config.shade_doubt**2 * seen.by_noise)

    def _depth_noise(self, depth: _Image) -> float:
        """How many sigmas the readings (h, w) of smooth surfaces are off, by how little they lie in planes."""
        off_plane = np.abs(cv2.Laplacian(depth, cv2.CV_32F)) / (self._noise[0] + self._noise[1] * depth**2)
        known = off_plane[np.isfinite(off_plane)]
        return 1.4826 * float(np.median(known)) / _LAPLACE_NOISE if len(known) else 1.0

    def _is_blank(self, shades: _Image) -> bool:
        """Whether a relief (h, w) is hardly more than noise: then pictures need not be alike."""
        noise = 1.4826 * float(np.median(np.abs(cv2.Laplacian(shades, cv2.CV_32F)))) / _LAPLACE_NOISE
        return float(shades.std()) < max(self._config.blank_contrast * noise, self._config.least_contrast)


def _of_turn(told: _Matrix) -> _Matrix:
    """(3, 3) what is told of the turn alone, wherever the camera has stepped."""
    turn: _Matrix = told[3:, 3:] - told[3:, :3] @ np.linalg.pinv(told[:3, :3], hermitian=True) @ told[:3, 3:]
    return turn


def _symmetric(upper: _Matrix) -> _Matrix:
    return upper + np.triu(upper, 1).T


def halved(image: _Image, times: int, edge: float) -> _Image:
    """(2, h, w) at half the size, so many times."""
    for _ in range(times):
        shades = cv2.resize(image[0], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        depth = image[1, : 2 * shades.shape[0] : 2, : 2 * shades.shape[1] : 2]
        image = np.stack([shades, without_holes(depth, edge)])
    return image


_WAYS = ((1, 0), (0, 1))

_MOST = 0.4
"""Share of a pixel and its neighbours with depth, from which their mean stands for it: half of those around it."""

_NEVER = 1e9
"""Grey values: a sigma with which shades say nothing."""

_SMOOTHED = 1.5
"""Times the square of a slope's noise: that of smoothed noise, against independent pixels of the same sigma."""

_SOBEL_NOISE = 0.31
"""Slope that noise of one grey value makes: √12 / 8 of independent pixels; a residual has the noise of two."""

_LAPLACE_NOISE = 4.47
"""What noise of one makes of the difference between four neighbours and the pixel: √20."""

LEAST_SECONDS = 0.01
"""Seconds for which a guess has been made at least: clocks are rounded."""
