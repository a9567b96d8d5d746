"""Compiling the kernels before the first frame waits for them."""

import os
import subprocess
import time
from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numba.core import event

from lpslam import isolated
from lpslam.camera import PinholeCamera
from lpslam.config import KeyframeConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.kernels import bundle, graph, matching
from lpslam.slam.kernels.geometry import median
from lpslam.slam.kernels.pose import no_prior, prior_chi2
from lpslam.slam.kernels.rays import measure_inverse
from lpslam.slam.map import SlamMap
from lpslam.slam.mapping.far_points import FarPoints
from lpslam.slam.mapping.local_mapping import LocalMapper
from lpslam.slam.mapping.whole_pictures import WholePictures
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.loop_correction import LoopCorrector, Tie
from lpslam.slam.ranges.curve import DepthCurve
from lpslam.slam.ranges.learning import DepthRanges
from lpslam.slam.sensor import SensorModel
from lpslam.slam.shutter.readout import Correspondences, readout_between
from lpslam.slam.shutter.straightening import RollingShutter
from lpslam.slam.system import RgbdSlam

# What two more processes run, each on its core; a kernel that none of these runs reaches is compiled here, afterwards.
_HELPERS = (
    "from lpslam.slam.warm_up import run_adjustment, run_tracking; run_adjustment(); run_tracking()",
    "from lpslam.slam.warm_up import run_mapping, run_seldom; run_mapping(); run_seldom()",
)

# LLVM's level of optimisation: the first compiles in two thirds of the time of the third, and the kernels, written as
# plain loops over scalars, run as fast and give the same bits.
_LEVEL = "1"


def warm_up(announce: Callable[[str], None]) -> float:
    """Run every kernel once on made-up frames, so that each is compiled, or loaded from the cache of an earlier start.

    Where nothing is in the cache yet, two processes compile into it, with settings that are theirs alone.

    Args:
        announce: is told, in a line, when compiling is needed.

    Returns:
        Seconds that it took.
    """
    started = time.perf_counter()
    first_compiled = FirstCompiled(announce)
    with event.install_listener("numba:compile", first_compiled):
        median(np.ones(3), 3)
        if first_compiled.is_compiling:
            compile_beside()
        run_adjustment()
        run_tracking()
        run_mapping()
        run_seldom()
        run_everything()
    return time.perf_counter() - started


class FirstCompiled(event.Listener):
    """Says so when the first kernel is compiled rather than loaded."""

    def __init__(self, announce: Callable[[str], None]) -> None:
        self._announce = announce
        self.is_compiling = False

    def on_start(self, event: object) -> None:
        """A kernel is about to be compiled (`event` says which)."""
        if not self.is_compiling:
            self.is_compiling = True
            self._announce("Compiling numeric kernels: once after installing, for about half a minute")

    def on_end(self, event: object) -> None:
        """A kernel was compiled: nothing follows from it."""


def compile_beside() -> None:
    """Compile into the cache in processes of their own; leaves none behind, whatever happens."""
    if not isolated.can_start():
        return
    quiet = subprocess.DEVNULL
    environment = {"NUMBA_OPT": _LEVEL, **os.environ}
    helpers: list[subprocess.Popen[bytes]] = []
    try:
        helpers.extend(
            subprocess.Popen(isolated.python_command(code), stdin=quiet, stdout=quiet, stderr=quiet, env=environment)
            for code in _HELPERS
        )
        for helper in helpers:
            helper.wait()
    except OSError:
        # No process can be started: this one then compiles everything itself.
        pass
    finally:
        for helper in helpers:
            if helper.poll() is None:
                helper.terminate()
                helper.wait()


def run_adjustment() -> None:
    """Adjust a point and a keyframe: much of what mapping needs, compiled before the other process comes to it."""
    problem = bundle.BundleProblem(
        camera_from_world=np.tile(np.eye(4), (2, 1, 1)),
        free_count=1,
        points=np.array([[0.0, 0.0, 2.0]]),
        starts=np.array([0, 2]),
        keyframe=np.array([0, 1], np.int32),
        pixels=np.full((2, 2), 150.0, np.float32),
        disparity=np.full(2, 12.0, np.float32),
        has_depth=np.ones(2, np.bool_),
        pixel_information=np.ones(2, np.float32),
        disparity_information=np.ones(2, np.float32),
        observation=np.arange(2),
    )
    bundle.adjust_bundle(problem, SensorModel.of(_camera(), SlamConfig()).intrinsics, 1, 1, np.zeros(1, np.bool_))


def run_tracking() -> None:
    """Follow made-up frames with a map that hardly grows, and lose and find the way."""
    _show(KeyframeConfig(min_start_depths=50), (0, 0, 6, None, 0, 6))


def run_mapping() -> None:
    """Work made-up keyframes that share points into a map, close a loop of them and forget one."""
    camera, config = _camera(), SlamConfig()
    sensor = SensorModel.of(camera, config)
    random = np.random.default_rng(0)
    # Keypoints of a point that is shared, of one that each keyframe makes for itself, and without a point.
    count, shared, made = 200, 100, 150
    positions = random.uniform((-0.6, -0.6, 1.5), (0.6, 0.6, 3.0), (count, 3))
    descriptor = random.integers(0, 2**63, (count, 4), np.uint64)
    depth = positions[:, 2].astype(np.float32)
    slam_map = SlamMap(count, sensor.scales)
    shutter = RollingShutter(sensor, slam_map, config.tracking, config.shutter)
    ranges = DepthRanges(slam_map, sensor, config.features.max_depth, config.ranges)
    pictures = WholePictures(slam_map, camera, sensor, config)
    mapper = LocalMapper(
        slam_map, sensor, shutter, ranges, pictures, FarPoints(slam_map, sensor, config.far_points), config
    )
    for k in range(3):
        camera_from_world = np.eye(4)
        camera_from_world[0, 3] = -0.1 * k
        pixels = camera.project(positions + camera_from_world[:3, 3]).astype(np.float32)
        features = Features(
            pixels=pixels,
            u_right=(pixels[:, 0] - sensor.intrinsics[4] / depth).astype(np.float32),
            depth=depth,
            has_depth=np.ones(count, np.bool_),
            octave=np.zeros(count, np.uint8),
            angle=np.zeros(count, np.float32),
            descriptor=descriptor,
        )
        information = sensor.disparity_information(depth)
        keyframe = slam_map.add_keyframe(camera_from_world, features, information, float(k), k, k - 1)
        if k:
            graph.link_all(slam_map.columns, np.arange(shared, dtype=np.int32), k)
        own = np.arange(shared if k else 0, made if k else shared, dtype=np.int32)
        slam_map.add_points(keyframe, own, positions[own])
        mapper.process(keyframe)
    m, ids = slam_map.columns, np.arange(2, dtype=np.int32)
    matching.twins(descriptor[:2], ids, ids, m.point_descriptor, m.position, 0.5)
    tie = Tie(2, 0, slam_map.camera_from_world(2), np.arange(count, dtype=np.int32))
    LoopCorrector(slam_map, sensor, config.loops, config.mapping).close([tie], slam_map.version, np.zeros(1, np.bool_))
    places = PlaceIndex.of(slam_map)
    gone = int(slam_map.living_keyframes()[-1])
    places.remove(gone)
    slam_map.remove_keyframe(gone)


def run_seldom() -> None:
    """What made-up frames do not reach: rows one after the other, depth by its range, points of rays, priors, looks."""
    sensor = SensorModel.of(_camera(), SlamConfig())
    count, still = 8, np.zeros(6)
    pixels, depth = np.full((count, 2), 100.0, np.float32), np.full(count, 2.0, np.float32)
    information = np.ones(count, np.float32)
    readout_between(Correspondences(pixels, depth, still, pixels, still, information), np.eye(4), 0.0, sensor)
    DepthCurve(np.array([0.0, 0.1, 0.3]), 0.125).true(depth)
    ahead = np.tile((0.0, 0.0, 1.0), (count, 1))
    from_anchor = np.tile(np.eye(4), (count, 1, 1))
    measure_inverse(from_anchor, ahead, pixels, information, np.ones(count), np.ones(count), sensor.intrinsics)
    prior_chi2(np.eye(4), no_prior())
    extractor = FeatureExtractor(_camera(), SlamConfig().features)
    gray, nowhere = np.zeros((240, 320), np.uint8), np.zeros((1, 2), np.int32)
    extractor.unlikeness(gray, pixels, np.zeros(count, np.int32), np.zeros((count, 4), np.uint64), nowhere, 0)


def run_everything() -> None:
    """Track and map made-up frames: whatever is not compiled yet is compiled here."""
    every_frame = KeyframeConfig(min_interval=0.0, tracked_share=2.0, min_start_depths=50)
    # Sideways, then a hand over the lens, then back.
    _show(every_frame, (0, 6, 12, 18, 24, None, 24, 30))


def _camera() -> PinholeCamera:
    return PinholeCamera(width=320, height=240, fx=300.0, fy=300.0, cx=160.0, cy=120.0)


def _show(keyframes: KeyframeConfig, shifts: Sequence[int | None]) -> None:
    """A textured wall from places side by side, at these pixels; None is a dark frame."""
    slam = RgbdSlam(_camera(), SlamConfig(keyframes=keyframes))
    picture = cv2.resize(np.random.default_rng(0).integers(0, 255, (64, 96, 3), np.uint8), (480, 320))
    depth = np.full((240, 320), 2.0, np.float32)
    depth[:60] = 0.0  # there are points of which the direction alone is known
    for index, shift in enumerate(shifts):
        seen = np.zeros((240, 320, 3), np.uint8) if shift is None else picture[40:280, shift : shift + 320]
        slam.process(RgbdFrame(index, index / 30.0, np.ascontiguousarray(seen), depth))
    slam.finish()
