"""Compiling the kernels before the first frame waits for them."""

import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import KeyframeConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.kernels import bundle, fusing, image, local_bundle, matching, pose
from lpslam.slam.system import RgbdSlam

_ENTRY_POINTS = (
    image.detect_corners,
    image.describe,
    matching.search_windows,
    matching.match_brute_force,
    pose.optimise_pose,
    local_bundle.gather_bundle,
    bundle.adjust_bundle,
    fusing.fuse_points,
)


def warm_up(announce: Callable[[str], None]) -> float:
    """Run every kernel once on made-up frames, so that each is compiled, or loaded from the cache of an earlier start.

    Args:
        announce: is told, in a line, when compiling is needed.

    Returns:
        Seconds that it took.
    """
    if not _is_cached():
        announce("Compiling numeric kernels: once after installing, for about a minute")
    started = time.perf_counter()
    camera = PinholeCamera(width=320, height=240, fx=300.0, fy=300.0, cx=160.0, cy=120.0)
    every_frame = KeyframeConfig(min_interval=0.0, tracked_share=2.0, min_start_depths=50)
    slam = RgbdSlam(camera, SlamConfig(keyframes=every_frame))
    picture = cv2.resize(np.random.default_rng(0).integers(0, 255, (64, 96, 3), np.uint8), (480, 320))
    depth = np.full((240, 320), 2.0, np.float32)
    # Sideways, then a hand over the lens, then back: so that losing and finding the way are compiled too.
    for index, shift in enumerate((0, 6, 12, 18, 24, None, 24, 30)):
        seen = np.zeros((240, 320, 3), np.uint8) if shift is None else picture[40:280, shift : shift + 320]
        slam.process(RgbdFrame(index, index / 30.0, np.ascontiguousarray(seen), depth))
    slam.finish()
    return time.perf_counter() - started


def _is_cached() -> bool:
    for kernel in _ENTRY_POINTS:
        stem = f"{Path(kernel.py_func.__code__.co_filename).stem}.{kernel.py_func.__name__}-"
        folder = Path(str(kernel.stats.cache_path))
        if not folder.is_dir() or not any(found.name.startswith(stem) for found in folder.glob("*.nbi")):
            return False
    return True
