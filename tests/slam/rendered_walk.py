"""Sixty frames of a mall as they are rendered, with the true path, for tests of whole ways."""

import pickle
from pathlib import Path

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.simulation.source import MallSource

FRAMES = 60


def render(folder: Path) -> None:
    """Write the frames' pixels, which take ten seconds to render and a tenth of one to read."""
    source = MallSource(3, frames=FRAMES)
    frames = list(source)
    np.save(folder / "rgb.npy", np.array([frame.rgb for frame in frames]))
    np.save(folder / "depth.npy", np.array([frame.depth for frame in frames]))
    truth = source.ground_truth
    known = source.camera, StampedPoses(truth.timestamps, truth.world_from_camera)
    (folder / "known.pickle").write_bytes(pickle.dumps(known))


class RenderedWalk:
    """The frames, not to be written to; the nearest surfaces are two and a half metres off.

    Args:
        folder: that `render` has filled.
    """

    def __init__(self, folder: Path) -> None:
        self.camera: PinholeCamera
        self.truth: StampedPoses
        self.camera, self.truth = pickle.loads((folder / "known.pickle").read_bytes())
        rgb, depth = (np.load(folder / f"{name}.npy", mmap_mode="r") for name in ("rgb", "depth"))
        times = self.truth.timestamps.tolist()
        self.frames = [RgbdFrame(at, time, np.asarray(rgb[at]), np.asarray(depth[at])) for at, time in enumerate(times)]
