"""How depth lies beside colour, by contours of things: where their depth ends, the picture changes."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from lpslam.config import RegistrationCheckConfig
from lpslam.frames import RgbdFrame
from lpslam.sources.registering.contours import Contours, Picture, changes_of, contours_of
from lpslam.sources.registering.displacement import DepthDisplacement, Size

Array = NDArray[np.float64]
_STEPS = np.array([0.01, 4.0, 4.0, 6.0, 6.0])
"""About what matters of scale, shifts (pixels of 640) and parallax (the same times metres)."""


_ROW = 1000


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    contours: Contours
    changes: tuple[Picture, Picture]


@dataclass(frozen=True, slots=True, eq=False)
class FoundDisplacement:
    """What the contours say.

    Attributes:
        displacement: between depth and colour.
        sigma: (5,) standard deviations of its numbers: half of what two halves of the frames differ by.
        pixels: by which contours move, root mean square, pixels of the colour image.
        gain: times as much that pictures change at the contours, once moved.
        chance: times as much that they change as at best in the same pictures turned upside down.
        agreeing: share of the frames in which they change more.
        is_told: whether contours tell how depth lies: two halves of the frames agree, beyond chance.
        is_displaced: whether depth is not registered to colour.
    """

    displacement: DepthDisplacement
    sigma: Array
    pixels: float
    gain: float
    chance: float
    agreeing: float
    is_told: bool
    is_displaced: bool


def find_displacement(frames: Iterable[RgbdFrame], config: RegistrationCheckConfig) -> FoundDisplacement | None:
    """Look for the displacement at which pictures change most where the depth of things ends.

    Args:
        frames: some, spread over a recording; depth may be of another size than colour.
        config: thresholds.

    Returns:
        What was found; None where the frames have too few contours to tell.
    """
    search = _search_of(frames, config)
    if search is None:
        return None
    return search.judged(search.best())


def looks_displaced(frames: Iterable[RgbdFrame], config: RegistrationCheckConfig) -> bool:
    """Whether a first look at some frames finds depth far beside colour: then `find_displacement` is worth its time."""
    search = _search_of(frames, config)
    if search is None:
        return False
    found, gain = search.coarse()
    return gain > config.gain and search.pixels_moved(DepthDisplacement.of(found)) > search.least_pixels


def _search_of(frames: Iterable[RgbdFrame], config: RegistrationCheckConfig) -> "_Search | None":
    views, sizes = [], set()
    for frame in frames:
        contours, changes = contours_of(frame.depth, config), changes_of(frame.rgb, config.side)
        if len(contours.depths) < config.min_view_pixels or min(changes[0].shape) < config.least_side:
            continue
        sizes.add(((frame.depth.shape[1], frame.depth.shape[0]), (frame.rgb.shape[1], frame.rgb.shape[0])))
        views.append(_View(contours, changes))
    if len(sizes) != 1 or len(views) < config.min_views:
        return None
    return _Search(views, *sizes.pop(), config)


def _turned(views: list[_View]) -> list[_View]:
    """The same contours, with pictures turned upside down: what is found there is chance."""
    return [_View(view.contours, (view.changes[0][::-1, ::-1], view.changes[1][::-1, ::-1])) for view in views]


class _Search:
    """Views of one recording, and how well a displacement fits them.

    Args:
        views: of frames with depth.
        depth_size, colour_size: width and height, pixels.
        config: thresholds.
    """

    def __init__(
        self, views: list[_View], depth_size: Size, colour_size: Size, config: RegistrationCheckConfig
    ) -> None:
        self._views = views
        self._sizes = (depth_size, colour_size)
        self._pixels = np.concatenate([view.contours.pixels for view in views])
        self._depths = np.concatenate([view.contours.depths for view in views])
        self._axis = np.concatenate([view.contours.axis for view in views])
        self._view = np.repeat(np.arange(len(views)), [len(view.contours.depths) for view in views])
        self._config = config
        self._reduced = views[0].changes[0].shape[1] / colour_size[0]
        self._steps = _STEPS * np.array([1.0, *[colour_size[0] / 640.0] * 4])
        self._blurred: dict[float, Picture] = {}
        self.registered = DepthDisplacement.between(depth_size, colour_size)

    def best(self) -> Array:
        """(5,) where the pictures change most at the contours."""
        start, _ = self.coarse()
        return max((self.refined(first) for first in (start, self.registered.numbers)), key=self.score)

    def coarse(self) -> tuple[Array, float]:
        """The best (5,) of all scales and shifts without parallax, and how many times better than near registered.

        All shifts at once, by correlation (convolution theorem), at half of the reduced size.
        """
        least, most = self._config.scales
        ratios = np.geomspace(least, most, self._config.scale_steps)
        changes = [[_halved(_blurred(each, self._config.blurs[0])) for each in view.changes] for view in self._views]
        height, width = changes[0][0].shape
        spectra = [[np.conj(np.fft.rfft2(each)) for each in pair] for pair in changes]
        reach, near = round(self._config.reach * width), round(self._config.near * width)
        best, best_near, found = -np.inf, 1e-9, self.registered.numbers
        for ratio in ratios:
            drawn = [[self._drawn(view, axis, ratio, (height, width)) for axis in (0, 1)] for view in self._views]
            total = np.zeros((height, width // 2 + 1), np.complex128)
            for spectrum, pair in zip(spectra, drawn, strict=True):
                total += spectrum[0] * np.fft.rfft2(pair[0]) + spectrum[1] * np.fft.rfft2(pair[1])
            # Contours that are moved by k meet the changes at -k of the correlation.
            fits = np.roll(np.fft.irfft2(total, (height, width))[::-1, ::-1], (reach + 1, reach + 1), (0, 1))
            fits = fits[: 2 * reach + 1, : 2 * reach + 1]
            row, column = np.unravel_index(int(fits.argmax()), fits.shape)
            if fits[row, column] > best:
                shift = 2.0 * (np.array([column, row]) - reach) / self._reduced
                best = float(fits[row, column])
                found = np.array([self.registered.scale * ratio, *shift, 0.0, 0.0])
            if abs(np.log(ratio)) < self._config.near:
                around = slice(reach - near, reach + near + 1)
                best_near = max(best_near, float(fits[around, around].max()))
        return found, best / best_near

    def _drawn(self, view: _View, axis: int, ratio: float, shape: tuple[int, int]) -> Array:
        """Contour pixels of one axis as a picture of counts, scaled about its middle."""
        height, width = shape
        of_axis = view.contours.axis == axis
        displacement = DepthDisplacement(self.registered.scale * ratio, (0.0, 0.0), (0.0, 0.0))
        moved = displacement.moved(view.contours.pixels[of_axis], view.contours.depths[of_axis], *self._sizes)
        column, row = np.floor((moved + 0.5) * self._reduced / 2.0).astype(int).T
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        counts = np.bincount(row[inside] * width + column[inside], minlength=height * width)
        return counts.reshape(height, width).astype(np.float64)

    def _changes(self, sigma: float) -> Picture:
        """Changes of all views below each other, sideways beside downwards; blurred, less their mean."""
        if sigma not in self._blurred:
            rows = [np.hstack([_blurred(each, sigma) for each in view.changes]) for view in self._views]
            self._blurred[sigma] = np.ascontiguousarray(np.vstack(rows))
        return self._blurred[sigma]

    def each(self, numbers: Array, sigma: float) -> Array:
        """(n,) of each contour pixel, how much more than elsewhere the picture changes there."""
        height, width = self._views[0].changes[0].shape
        moved = DepthDisplacement.of(numbers).moved(self._pixels, self._depths, *self._sizes)
        u, v = ((moved + 0.5) * self._reduced - 0.5).T
        inside = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
        u, v = np.where(inside, u + self._axis * width, -9.0), np.where(inside, v + self._view * height, -9.0)
        # OpenCV reads pictures, of at most 32,767 rows: places stand in rows of a thousand.
        rows = -(-len(u) // _ROW)
        places = np.full((2, rows * _ROW), -9.0, np.float32)
        places[:, : len(u)] = u, v
        at_u, at_v = places.reshape(2, rows, _ROW)
        read = cv2.remap(self._changes(sigma), at_u, at_v, cv2.INTER_LINEAR, borderValue=(0.0,))
        return np.asarray(read, np.float64).ravel()[: len(u)]

    def _of_views(self, each: Array) -> Array:
        """(views,) sums over the contour pixels of each view."""
        return np.asarray(np.bincount(self._view, each, len(self._views)), np.float64)

    def score(self, numbers: Array) -> float:
        """The sum over all contour pixels, at the finest blur."""
        return float(self.each(numbers, self._config.blurs[-1]).sum())

    def refined(self, start: Array) -> Array:
        """(5,) the best near `start`, finer and finer."""
        numbers = start
        for sigma in self._config.blurs:
            numbers = self._best_near(numbers, sigma, np.ones(len(self._depths)))
        return numbers

    def _best_near(self, start: Array, sigma: float, weights: Array) -> Array:
        options: Any = {
            "initial_simplex": np.vstack([np.zeros(5), np.eye(5) * sigma / self._config.blurs[0]]) * 2.0,
            "xatol": 0.02,
            "fatol": 1e-3,
            "maxiter": 200,
        }

        def cost(steps: Array) -> float:
            return -self._fit(start + steps * self._steps, sigma, weights)

        found = minimize(cost, np.zeros(5), method="Nelder-Mead", options=options)
        return np.asarray(start + found.x * self._steps)

    def _fit(self, numbers: Array, sigma: float, weights: Array) -> float:
        least, most = self._config.scales
        width = self._sizes[1][0]
        is_possible = (
            least <= numbers[0] / self.registered.scale <= most
            and np.abs(numbers[1:3]).max() <= self._config.reach * width
            and np.abs(numbers[3:]).max() <= self._config.baseline * width
        )
        return float(self.each(numbers, sigma) @ weights) if is_possible else 0.0

    def judged(self, numbers: Array) -> FoundDisplacement:
        """How sure the displacement is, and whether it is one."""
        config, finest = self._config, self._config.blurs[-1]
        halves = [self._best_near(numbers, finest, self._view % 2 == half) for half in (0, 1)]
        now, before = (self._of_views(self.each(each, finest)) for each in (numbers, self.registered.numbers))
        gain = float(now.sum() / max(before.sum(), 1e-9))
        turned = _Search(_turned(self._views), *self._sizes, config)
        chance = float(now.sum() / max(turned.score(turned.best()), 1e-9))
        agreeing = float((now > before).mean())
        displacement = DepthDisplacement.of(numbers)
        pixels = self.pixels_moved(displacement)
        apart = self.pixels_moved(DepthDisplacement.of(halves[0]), DepthDisplacement.of(halves[1]))
        is_told = apart < config.halves_apart * max(pixels, self.least_pixels) and chance > config.beyond_chance
        is_better = gain > config.gain and agreeing >= config.agreeing
        is_displaced = is_told and is_better and pixels > self.least_pixels
        sigma = np.abs(halves[0] - halves[1]) / 2.0
        return FoundDisplacement(displacement, sigma, pixels, gain, chance, agreeing, is_told, is_displaced)

    @property
    def least_pixels(self) -> float:
        """By which contours move at least, where depth is not registered."""
        return self._config.displaced * self._sizes[1][0]

    def pixels_moved(self, displacement: DepthDisplacement, other: DepthDisplacement | None = None) -> float:
        """By which two displacements, or one and none, move contours apart: root mean square, pixels of colour."""
        other = other or self.registered
        apart = displacement.moved(self._pixels, self._depths, *self._sizes) - other.moved(
            self._pixels, self._depths, *self._sizes
        )
        return float(np.sqrt((apart**2).sum(axis=1).mean()))


def _blurred(changes: Picture, sigma: float) -> Picture:
    smooth = cv2.GaussianBlur(changes, (0, 0), sigma)
    return np.asarray(smooth - smooth.mean(), np.float32)


def _halved(changes: Picture) -> Picture:
    size = (changes.shape[1] // 2, changes.shape[0] // 2)
    return np.asarray(cv2.resize(changes, size, interpolation=cv2.INTER_AREA), np.float32)
