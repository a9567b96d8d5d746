"""The camera's way from surfaces and faint patterns where keypoints do not tell it (Steinbrücker 2011; Kerl 2013)."""

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.config import SurfaceConfig
from lpslam.slam.kernels.dense import align_terms
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
    """

    image_from_reference: _Matrix
    shared: float
    holds: bool
    tells_turn: bool
    likeness: float = 0.0
    is_proven: bool = False


class SmallImages:
    """Makes small images without lens distortion of a camera's frames.

    Args:
        camera: of the frames.
        width: pixels across the small images.
        around: pixels of them over which grey values are compared with those about them.
    """

    def __init__(self, camera: PinholeCamera, width: int, around: float) -> None:
        self._around = around
        self._depth = SmallDepth(camera, max(min(width, camera.width // LEAST_SHRINK), 16))
        self._size, self.intrinsics = self._depth.size, self._depth.intrinsics
        small = ((self._depth.raw + 0.5) / self._depth.shrink - 0.5).astype(np.float32)
        small = small.reshape(*self._size[::-1], 2)
        self._shades_at = np.ascontiguousarray(small[..., 0]), np.ascontiguousarray(small[..., 1])

    def reference(self, gray: NDArray[np.uint8], depth: _Image) -> _Image:
        """(2, h, w) relief of the grey values and depth, as `align_terms` takes them."""
        shades = cv2.resize(gray.astype(np.float32), self._size, interpolation=cv2.INTER_AREA)
        shades = cv2.remap(shades, *self._shades_at, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.stack([relief(np.asarray(shades, np.float32), self._around), self._depth.read(depth)])


def sloped(reference: _Image, edge: float) -> _Image:
    """(6, h, w) of (2, h, w): with slopes along u and v; depth where neighbours differ by less than `edge` of it."""
    shades, depth = reference
    kernel = np.ones((3, 3), np.uint8)
    far, near = cv2.dilate(depth, kernel), cv2.erode(depth, kernel)
    smooth = np.where((near > 0) & (far - near < edge * far), depth, np.nan).astype(np.float32)
    slopes = [cv2.Sobel(depth, cv2.CV_32F, *way, ksize=3, scale=0.125) for way in _WAYS]
    shade_slopes = [cv2.Sobel(shades, cv2.CV_32F, *way, ksize=3, scale=0.125) for way in _WAYS]
    return np.stack([shades, *shade_slopes, smooth, *slopes])


class Surfaces:
    """Aligns frames with a reference by what every pixel shows.

    Args:
        camera, sensor: of the frames.
        config: thresholds.
    """

    def __init__(self, camera: PinholeCamera, sensor: SensorModel, config: SurfaceConfig) -> None:
        self.images = SmallImages(camera, config.width, config.around)
        self._noise = (sensor.depth_sigma, sensor.depth_sigma_quadratic)
        self._config = config

    def align(
        self, reference: _Image, image: _Image, guess: _Matrix, seconds: float, before: _Matrix | None = None
    ) -> Aligned | None:
        """Find the pose between two small images (2, h, w) from a guess of it (4×4, image from reference).

        Where they say nothing, the guess stays, which has been made for so many seconds. Where they do not prove it,
        the pose `before` is tried as well, and where the pictures as a whole lie. None if they hardly overlap.
        """
        before = guess if before is None else before
        best: Aligned | None = None
        for start in self._starts(reference, image, guess, before):
            found = self._from(reference, image, start, seconds)
            if found is not None and (best is None or found.likeness > best.likeness):
                best = found
            if found is not None and found.is_proven:
                return found
        return best

    def _starts(self, reference: _Image, image: _Image, guess: _Matrix, before: _Matrix) -> Iterator[_Matrix]:
        """Poses from which to align: the guess, and where the camera was, either also turned as the pictures lie."""
        intrinsics = self.images.intrinsics
        for pose in (guess, before):
            yield pose
            shift = shift_between(reference[0], image[0], pose[:3, :3], intrinsics)
            if max(abs(shift.across), abs(shift.down)) > 1 and shift.lead > self._config.lead:
                yield exponential(np.concatenate([np.zeros(3), shift.turn(intrinsics)])) @ pose

    def _from(self, reference: _Image, image: _Image, start: _Matrix, seconds: float) -> Aligned | None:
        """The same from one pose, which also stays where they say nothing: coarse images first, for the reach."""
        pose = start
        for halvings in (1, 0):
            levels = halved(reference, halvings), sloped(halved(image, halvings), self._config.edge)
            aligned = self._aligned(*levels, pose, start, halvings, max(seconds, LEAST_SECONDS))
            if aligned is None:
                return None
            pose = aligned.image_from_reference
        return aligned

    def _aligned(
        self, reference: _Image, image: _Image, pose: _Matrix, guess: _Matrix, halvings: int, seconds: float
    ) -> Aligned | None:
        """Gauss-Newton from a pose on one level; `image` as of `sloped`."""
        config, shrink = self._config, 2.0**halvings
        intrinsics = self.images.intrinsics / shrink
        intrinsics[2:] += 0.5 / shrink - 0.5
        hessian, gradient, residuals = np.empty((6, 6)), np.empty(6), np.empty((2, image[0].size))
        sigmas = np.repeat([config.guess_speed, config.guess_turn], 3) * seconds
        prior = np.diag(sigmas**-2)
        sigma, offset = _FIRST_SIGMA, float(np.median(reference[0]) - np.median(image[0]))
        known = max(int((reference[1] > 0).sum()), 1)
        for _ in range(config.steps):
            brightness = offset, _TOGETHER * sigma
            inside, measured, agreeing = align_terms(
                reference, image, intrinsics, pose, brightness, self._noise, hessian, gradient, residuals
            )
            if inside < config.least_shared * known or measured < config.least_measured * image[0].size:
                return None
            sigma = max(1.4826 * float(np.median(np.abs(residuals[0, :inside]))), config.least_shade)
            hessian += np.triu(hessian, 1).T
            astray = logarithm(pose @ inverse_transform(guess))
            step = np.asarray(np.linalg.solve(hessian + prior, -(gradient + prior @ astray)), np.float64)
            pose = exponential(step) @ pose
            if np.abs(step).max() < _SMALL_STEP:
                break
        if halvings:
            return Aligned(pose, inside / known, False, False)  # only the finest images are asked whether they hold
        alike = likeness(residuals[1, :inside], residuals[0, :inside] + residuals[1, :inside])
        is_proven = self._is_proven(reference, image, pose, intrinsics)
        is_like = is_proven or alike > config.least_likeness
        told = self._told(reference, image, pose, intrinsics, hessian, measured / inside, is_like)
        # By eigenvalues in units of the guess: in the direction that the images tell worst.
        told *= np.outer(sigmas, sigmas) * config.told_share**2
        is_firm = bool(np.linalg.eigvalsh(told)[0] > 1.0)
        # Of the turn alone, wherever the camera has stepped.
        turn = told[3:, 3:] - told[3:, :3] @ np.linalg.pinv(told[:3, :3], hermitian=True) @ told[:3, 3:]
        is_blank = not is_like and (self._is_blank(reference[0]) or self._is_blank(image[0]))
        # A wall tells how the camera turns away from it; where nothing is on it, nothing tells how it rolls before it.
        is_turn_firm = is_firm or bool(np.linalg.eigvalsh(turn)[1 if is_blank else 0] > 1.0)
        least = config.proven_agreement if is_like else config.least_agreement
        agrees = agreeing >= least * measured and (is_like or is_blank)
        astray = logarithm(pose @ inverse_transform(guess))
        agrees &= is_proven or bool((np.abs(astray) <= config.guess_sigmas * sigmas).all())
        return Aligned(pose, inside / known, is_firm and agrees, is_turn_firm and agrees, alike, is_proven)

    def _is_proven(self, reference: _Image, image: _Image, pose: _Matrix, intrinsics: _Matrix) -> bool:
        """Whether reliefs that a pose brings together lie on each other, and nowhere else nearly as well."""
        fx, fy, cx, cy = intrinsics
        v, u = np.mgrid[: reference.shape[1], : reference.shape[2]]
        depth = reference[1].astype(np.float64)
        points = np.stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth], axis=2) @ pose[:3, :3].T + pose[:3, 3]
        z = points[..., 2]
        is_seen = (depth > 0) & (z > NEAREST)
        z = np.where(is_seen, z, 1.0)
        across = np.where(is_seen, fx * points[..., 0] / z + cx, -1.0).astype(np.float32)
        down = np.where(is_seen, fy * points[..., 1] / z + cy, -1.0).astype(np.float32)
        there = cv2.remap(image[0], across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0.0)
        shift = shift_of(reference[0], np.asarray(there, np.float32))
        return max(abs(shift.across), abs(shift.down)) <= 1 and shift.lead > self._config.lead

    def _told(
        self,
        reference: _Image,
        image: _Image,
        pose: _Matrix,
        intrinsics: _Matrix,
        hessian: _Matrix,
        measured_share: float,
        by_shades: bool,
    ) -> _Matrix:
        """(6, 6) what two images tell of a pose, of the hessian there: less what noise alone would."""
        noise, by_depth = self._depth_noise(image[3]), np.empty((6, 6))
        gradient, residuals = np.empty(6), np.empty((2, image[0].size))
        no_shades = (0.0, _NEVER)
        align_terms(reference, image, intrinsics, pose, no_shades, self._noise, by_depth, gradient, residuals)
        by_depth += np.triu(by_depth, 1).T
        by_noise = self._told_by_noise(reference, pose, intrinsics)
        told = (by_depth - noise**2 * measured_share * by_noise) / max(noise, self._config.least_noise) ** 2
        return told + (hessian - by_depth - _SMOOTHED / _TOGETHER**2 * by_noise) if by_shades else told

    def _depth_noise(self, depth: _Image) -> float:
        """How many sigmas the readings (h, w) of smooth surfaces are off, by how little they lie in planes."""
        off_plane = np.abs(cv2.Laplacian(depth, cv2.CV_32F)) / (self._noise[0] + self._noise[1] * depth**2)
        known = off_plane[np.isfinite(off_plane)]
        return 1.4826 * float(np.median(known)) / _LAPLACE_NOISE if len(known) else 1.0

    def _told_by_noise(self, reference: _Image, pose: _Matrix, intrinsics: _Matrix) -> _Matrix:
        """(6, 6) what slopes of depth that are noise alone add to the hessian, where readings are off by a sigma.

        A slope's noise is a share of the reading's, by which it is weighed: how large it is plays no part.
        """
        fx, fy, cx, cy = intrinsics
        v, u = np.nonzero(reference[1] > 0)
        depth = reference[1][v, u].astype(np.float64)
        points = np.column_stack([(u - cx) / fx * depth, (v - cy) / fy * depth, depth]) @ pose[:3, :3].T + pose[:3, 3]
        x, y, z = points[points[:, 2] > NEAREST].T
        nothing = np.zeros_like(z)
        across = np.stack([fx / z, nothing, -fx * x / (z * z)]), np.stack([nothing, fy / z, -fy * y / (z * z)])
        jacobians = [np.concatenate([along, np.cross([x, y, z], along, axis=0)]) for along in across]
        told: _Matrix = _SOBEL_NOISE**2 * sum((each @ each.T for each in jacobians), np.zeros((6, 6)))
        return told

    def _is_blank(self, shades: _Image) -> bool:
        """Whether a relief (h, w) is hardly more than noise: then pictures need not be alike."""
        noise = 1.4826 * float(np.median(np.abs(cv2.Laplacian(shades, cv2.CV_32F)))) / _LAPLACE_NOISE
        return float(shades.std()) < max(self._config.blank_contrast * noise, self._config.least_contrast)


def halved(image: _Image, times: int) -> _Image:
    """(2, h, w) at half the size, so many times."""
    for _ in range(times):
        shades = cv2.resize(image[0], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        image = np.stack([shades, image[1, : 2 * shades.shape[0] : 2, : 2 * shades.shape[1] : 2]])
    return image


LEAST_SHRINK = 4
"""Pixels of the camera to one of a small image: neighbours have no reading in common, and shades less noise."""

_WAYS = ((1, 0), (0, 1))

NEAREST = 0.05
"""Metres before the camera; what is nearer is not seen."""

_NEVER = 1e9
"""Grey values: a sigma with which shades say nothing."""

_TOGETHER = 2.8
"""Times a sigma: so much less do shades tell whose noise is smoothed over eight pixels."""

_SMOOTHED = 1.5
"""Times the square of a slope's noise: that of smoothed noise, against independent pixels of the same sigma."""

_FIRST_SIGMA = 5.0
"""Grey values: of the residuals, before they are known."""

_SOBEL_NOISE = 0.31
"""Slope that noise of one grey value makes: √12 / 8 of independent pixels; a residual has the noise of two."""

_LAPLACE_NOISE = 4.47
"""What noise of one makes of the difference between four neighbours and the pixel: √20."""

LEAST_SECONDS = 0.01
"""Seconds for which a guess has been made at least: clocks are rounded."""

_SMALL_STEP = 1e-5
"""Metres and radians: no further step is made."""
