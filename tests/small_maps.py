"""Maps of any signs at any places, made without a camera: for whoever serves, asks or draws maps."""

from collections.abc import Sequence

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import GroundConfig, TextConfig
from lpslam.ground.scans import Scans
from lpslam.language.model import Naming
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap
from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.slam.trajectory import Trajectory
from lpslam.text.remembering.memory import Pool, TextClass, Variant
from lpslam.text.text_map import TextMap
from lpslam.text.types import Placement, TextObservation

CAMERA = PinholeCamera(width=320, height=240, fx=300.0, fy=300.0, cx=159.5, cy=119.5)
MALL = ("Starbucks", "Pizza Hut 必胜客", "新华书店", "Toilets", "EXIT 1", "ATM", "Meeting Room", "KFC")
# Map from the optical frame of a camera that looks along x.
WORLD_FROM_CAMERA = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])


def small_map(signs: Sequence[str] = MALL, spacing: float = 4.0, source: str = "small") -> LanguageMap:
    """A map of one keyframe at the origin that looks along x, with one board for each sign, in rows of 40."""
    slam = SlamMap(16, np.ones(8))
    count = 4
    features = Features(
        pixels=np.zeros((count, 2), np.float32),
        u_right=np.zeros(count, np.float32),
        depth=np.ones(count, np.float32),
        has_depth=np.ones(count, bool),
        octave=np.zeros(count, np.uint8),
        angle=np.zeros(count, np.float32),
        descriptor=np.zeros((count, 4), np.uint64),
    )
    slam.add_keyframe(np.linalg.inv(WORLD_FROM_CAMERA), features, np.ones(count, np.float32), 0.0, 0, -1)
    slam.add_points(0, np.arange(count, dtype=np.int32), np.random.default_rng(1).uniform(0, 9, (count, 3)))
    trajectory = Trajectory()
    trajectory.append(TrackedFrame(0, 0.0, TrackingState.TRACKING, 0, np.eye(4), WORLD_FROM_CAMERA, count, True))
    text = TextMap(TextConfig())
    for number, sign in enumerate(signs):
        text.memory.long_term[number] = _board(number, sign, (number % 40) * spacing, (number // 40) * spacing)
    text.memory.next_id = len(signs)
    return LanguageMap(CAMERA, slam, trajectory, text, source)


def with_floor(world: LanguageMap, height: float = 1.2) -> LanguageMap:
    """The same with what its keyframe sees of a floor so far below the camera, metres."""
    rows = np.arange(CAMERA.height, dtype=np.float64)[:, None]
    with np.errstate(divide="ignore"):
        ahead = height * CAMERA.fy / (rows - CAMERA.cy)
    depth = np.where((ahead > 0) & (ahead < 8), ahead, 0.0) * np.ones((1, CAMERA.width))
    world.scans = Scans(CAMERA, GroundConfig().width)
    world.scans.take(0, np.full((CAMERA.height, CAMERA.width, 3), 120, np.uint8), depth.astype(np.float32))
    return world


def _board(number: int, sign: str, x: float, y: float) -> TextClass:
    """A class seen five times at (x, y, 1) of the map, its board facing the camera."""
    placement = Placement((-y, -1.0, x), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 1.2, 0.3, 0.01)
    seen = [
        TextObservation(at, float(at), 0, sign, 0.9, placement, 30.0, ground=(number % 256, number // 256, 40))
        for at in range(5)
    ]
    return TextClass(
        number, 0.0, 4.0, {sign: Variant(5, 4.5)}, 3.0, Pool.LONG_TERM, observations=seen,
        naming=Naming(sign, 0.95, "given", "test"), named_at_count=5,
    )  # fmt: skip
