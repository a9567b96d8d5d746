"""The mock mall as a source of frames, drawn as it is read."""

from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import SimulationConfig
from lpslam.errors import UserError
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.simulation import sensor
from lpslam.simulation.mall import Mall, build_mall
from lpslam.simulation.render import render
from lpslam.simulation.scene import Scene
from lpslam.simulation.signs import Sign
from lpslam.simulation.visibility import SignViews, views_of
from lpslam.simulation.walk import FPS, Walk, stroll

TARGET_BRIGHTNESS = 118.0  # mean grey value that the exposure aims at
MAX_GAIN = 2.0  # the exposure cannot do more: a dark mall stays dark
EXPOSURE_LAG = 0.06  # share by which the exposure moves to its aim every frame
THREADS = 2
MOST_FRAMES = 108_000  # an hour: the whole walk is planned before the first frame, at 240 poses a second
LOOK_AHEAD = 4  # frames drawn ahead of the reader


@dataclass(frozen=True, slots=True, eq=False)
class GroundTruth:
    """The camera's true path: (n,) seconds and (n, 4, 4) poses of the optical frame in the world (z up, metres)."""

    timestamps: NDArray[np.float64]
    world_from_camera: NDArray[np.float64]


class WalkSource:
    """A `FrameSource` that renders a walk through a world.

    Args:
        name: of the source.
        seed: of the camera and its noise.
        mall: the world.
        walk: through it.
        options: light, shutter and noise.
        visit: which walk through that world with that camera.
    """

    def __init__(self, name: str, seed: int, mall: Mall, walk: Walk, options: SimulationConfig, visit: int = 0) -> None:
        self._name = name
        self._seed = seed
        self._visit = visit
        self._options = options
        self._mall = mall
        self._walk = walk
        rng = np.random.default_rng([seed, 3])
        focal = float(rng.uniform(525.0, 612.0))
        cx, cy = 319.5 + rng.uniform(-6, 6), 239.5 + rng.uniform(-6, 6)
        self._camera = PinholeCamera(
            width=640, height=480, fx=round(focal, 2), fy=round(focal * rng.uniform(0.998, 1.002), 2),
            cx=round(cx, 2), cy=round(cy, 2), depth_scale=5000.0, fps=FPS,
        )  # fmt: skip
        self._noise = sensor.draw_noise(rng, self._camera.width, self._camera.height)
        strength = float(rng.uniform(0.12, 0.25)) if self._options.sensor_noise else 0.0
        self._vignette = sensor.vignette_of(self._camera, strength)
        self._gains: list[float] = []

    @property
    def name(self) -> str:
        """Of the world, with its seed."""
        return self._name

    @property
    def camera(self) -> PinholeCamera:
        """Calibration; no distortion."""
        return self._camera

    @property
    def faults(self) -> list[FrameFault]:
        """Always empty: every frame can be drawn."""
        return []

    @cached_property
    def ground_truth(self) -> GroundTruth:
        """The true poses, at the middle of each exposure."""
        timestamps = np.arange(len(self)) / FPS
        return GroundTruth(timestamps, np.array([self._walk.pose(self._instant(i)) for i in range(len(self))]))

    @property
    def scene(self) -> Scene:
        """All faces of the world."""
        return self._mall.scene

    @cached_property
    def signs(self) -> list[Sign]:
        """All signs of the world with the number of frames in which each is readable, and from when on."""
        times = np.arange(len(self)) / FPS
        return [as_seen(sign, views, times) for sign, views in zip(self._mall.signs, self.sign_views, strict=True)]

    @cached_property
    def sign_views(self) -> list[SignViews]:
        """How each sign is seen in every frame."""
        opened, closed = (np.array(poses) for poses in zip(*map(self._shutter, range(len(self))), strict=True))
        middle = self.ground_truth.world_from_camera
        return [views_of(sign, self._mall.scene, self._camera, middle, opened, closed) for sign in self._mall.signs]

    def __len__(self) -> int:
        """Number of frames."""
        return self._walk.frames

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Draw the frames in order, a few ahead on two threads."""
        pending: deque[Future[RgbdFrame]] = deque()
        with ThreadPoolExecutor(THREADS, thread_name_prefix="mall") as pool:
            try:
                for index in range(len(self)):
                    self._gain(index)
                    pending.append(pool.submit(self.frame, index))
                    if len(pending) > LOOK_AHEAD:
                        yield pending.popleft().result()
                while pending:
                    yield pending.popleft().result()
            finally:
                for future in pending:
                    future.cancel()

    def frame(self, index: int, noise: int = 0) -> RgbdFrame:
        """Draw one frame; each number of `noise` is another measurement by the same sensor from the same place."""
        world_from_camera = self._walk.pose(self._instant(index))
        opened, closed = self._shutter(index)
        scene, camera = self._mall.scene, self._camera
        colour, depth, seen = render(scene, camera, world_from_camera, self._mall.polish)
        gain = self._gain(index)
        rng = np.random.default_rng([self._seed, 13, index, *([self._visit, noise] if self._visit or noise else [])])
        if self._options.sensor_noise:
            normals = scene.normal @ world_from_camera[:3, :3]
            measured = sensor.measure_depth(rng, depth, seen, colour, normals, scene.gloss, camera, self._noise)
        else:
            measured = depth
        if self._options.exposure_time > 0:
            colour = sensor.blur_by_motion(colour, depth, camera, opened, world_from_camera, closed)
        if self._options.sensor_noise:
            rgb = sensor.expose(rng, colour, gain, self._noise, self._vignette)
        else:
            rgb = np.clip(colour * gain + 0.5, 0, 255).astype(np.uint8)
        return RgbdFrame(index, index / FPS, rgb, measured)

    def _instant(self, index: int) -> float:
        """Seconds on the walk's clock, which starts a little earlier so that the first shutter can open."""
        return index / FPS + 0.05

    def _shutter(self, index: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """World from camera when the shutter opens and when it closes; darkness keeps it open twice as long."""
        half = self._options.exposure_time * (1.0 if self._options.light > 0.6 else 2.0) / 2
        return self._walk.pose(self._instant(index) - half), self._walk.pose(self._instant(index) + half)

    def _gain(self, index: int) -> float:
        """Brightness factor of a frame: the exposure follows what small pictures of the frames before show."""
        if not self._options.sensor_noise:
            return self._options.light
        shrink = 16
        c = self._camera
        small = PinholeCamera(
            c.width // shrink, c.height // shrink, c.fx / shrink, c.fy / shrink, c.cx / shrink, c.cy / shrink
        )
        while len(self._gains) <= index:
            colour, _, _ = render(self._mall.scene, small, self._walk.pose(self._instant(len(self._gains))))
            aim = min(MAX_GAIN, max(0.5, TARGET_BRIGHTNESS / max(1.0, float(colour.mean()) * self._options.light)))
            last = self._gains[-1] / self._options.light if self._gains else aim
            self._gains.append((last + EXPOSURE_LAG * (aim - last)) * self._options.light)
        return self._gains[index]


class MallSource(WalkSource):
    """A `FrameSource` that renders a walk through a mock mall; the same seed and options give the same frames.

    Args:
        seed: of the world, the walk and the noise.
        frames: how many; None for once around the route and three metres more.
        options: size, layout, light, languages.
        visit: which walk through that world with that camera; each begins elsewhere and goes at its own pace.

    Raises:
        UserError: `frames` is not positive or more than an hour, `seed` or `visit` is negative, or more signs should
            repeat another one than there are.
    """

    def __init__(
        self, seed: int = 0, frames: int | None = None, *, options: SimulationConfig | None = None, visit: int = 0
    ) -> None:
        if frames is not None and frames < 1:
            raise UserError(f"simulation: frames is {frames}; it must be at least 1")
        if frames is not None and frames > MOST_FRAMES:
            raise UserError(f"simulation: {frames} frames are too many; {MOST_FRAMES}, an hour's, are the most")
        if seed < 0:
            raise UserError(f"simulation: seed is {seed}; it must be 0 or more")
        if visit < 0:
            raise UserError(f"simulation: visit is {visit}; it must be 0 or more")
        options = options or SimulationConfig()
        _refuse_distances(options)
        mall = build_mall(seed, options)
        _refuse_repetition(options, len(mall.signs))
        walk = stroll(seed, mall.layout, mall.signs, options, frames, visit)
        super().__init__(f"mall-{seed}", seed, mall, walk, options, visit)


def _refuse_distances(options: SimulationConfig) -> None:
    """Refuse distances between repeated signs that the mall to be built will not have."""
    farthest = max(options.duplicate_distances, default=0.0)
    if farthest > options.loop_length:
        raise UserError(
            f"simulation: duplicates {farthest:.6g} m apart do not fit a loop of {options.loop_length:g} m; ask for a "
            "shorter distance, or a longer loop"
        )


def _refuse_repetition(options: SimulationConfig, signs: int) -> None:
    """Refuse more repeated signs than a mall has."""
    repeated = options.duplicates + len(options.duplicate_distances)
    if repeated >= signs:
        raise UserError(
            f"simulation: {repeated} duplicates are asked for; this mall has {signs} signs, of which at most "
            f"{signs - 1} can repeat another one; ask for fewer, or for a larger mall"
        )


def as_seen(sign: Sign, views: SignViews, times: NDArray[np.float64]) -> Sign:
    """The sign with what its views, at `times` (n,) seconds, say of when it is readable."""
    readable = np.flatnonzero(views.readable())
    return replace(
        sign,
        lines=tuple(
            replace(line, readable_frames=int(views.readable(row).sum())) for row, line in enumerate(sign.lines)
        ),
        readable_frames=len(readable),
        readable_from=float(times[readable[0]]) if len(readable) else None,
    )
