"""What texts add to loop closing, all parts together: sub-maps joined where looks say nothing, and kept apart."""

import numpy as np
import pytest
from loop_scenes import KEYFRAMES_A_ROUND, RADIUS, Walk, World, around
from slam_scenes import pose_error, rigid

from lpslam.camera import transform_points
from lpslam.config import AdviceConfig
from lpslam.slam.places.loop_closing import LoopEvent
from lpslam.slam.state import EventKind
from lpslam.text.advice.advising import SIGNS_DIFFER, TextAdvisor
from lpslam.text.types import Placement, TextObservation

STEP = 2 * np.pi / KEYFRAMES_A_ROUND
DRIFT = 0.0003
ELSEWHERE = rigid([5, 1, -2], [0.4, -1.0, 0.3])
"""The frame in which the second walk begins anew."""

NAMES = ["STARBUCKS", "书店", "PIZZA HUT", "LIBRARY", "华为", "ZARA", "牛肉面", "DENTIST"]
OTHERS = ["GUCCI", "面馆", "HOTEL", "TAXI", "洗手间", "MUSEUM", "药房", "FLOWERS"]


class ReadWalk(Walk):
    """A walk on which signs, one every 12 degrees, are read.

    Args:
        is_advised: whether words are asked at all.
    """

    def __init__(self, world: World, seed: int, *, is_advised: bool = True) -> None:
        self.texts = TextAdvisor(AdviceConfig())
        super().__init__(world, seed, DRIFT, *([self.texts] if is_advised else []))
        self.signs: dict[float, str] = {}
        self.classes: dict[str, int] = {}

    def hang(self, names: list[str], at: float) -> None:
        """Put up signs from an angle on, radians."""
        self.signs |= {at + number * np.radians(12): name for number, name in enumerate(names)}

    def go(self, pose: np.ndarray, anew_at: np.ndarray | None = None) -> LoopEvent | None:
        """Take a view, read what is on it, and look for loops."""
        keyframe = self.step(pose, anew_at)
        for angle, name in self.signs.items():
            spot = np.array([np.sin(angle), 0.0, np.cos(angle)]) * RADIUS
            centre = transform_points(pose, spot[None])[0]
            if centre[2] > 0.5 and abs(centre[0]) < 0.55 * centre[2]:
                normal, baseline = -pose[:3, :3] @ spot / RADIUS, pose[:3, :3] @ [np.cos(angle), 0.0, -np.sin(angle)]
                placement = Placement(tuple(centre), tuple(normal), tuple(baseline), 0.4, 0.15, 0.01)
                number = self.classes.setdefault(name, len(self.classes))
                seen = TextObservation(keyframe, float(keyframe), keyframe, name, 0.97, placement, 30.0)
                # In the keyframe, and in a frame after it.
                self.texts.note(number, seen)
                self.texts.note(number, seen)
        return self.closer.process(keyframe)


def walk_on(walk: ReadWalk, angles: np.ndarray, *, anew: bool = False) -> list[LoopEvent]:
    poses = [around(angle) for angle in angles]
    events = [walk.go(pose, pose @ ELSEWHERE if anew and row == 0 else None) for row, pose in enumerate(poses)]
    return [event for event in events if event is not None]


@pytest.mark.parametrize("is_advised", [False, True])
def test_signs_join_submaps_where_looks_say_nothing(is_advised: bool) -> None:
    walk = ReadWalk(World.of(np.random.default_rng(0)), 6, is_advised=is_advised)
    walk.places.query_keyframe = (  # type: ignore[method-assign]
        lambda keyframe, eligible=None: np.zeros(keyframe + 1, np.float32)
    )
    walk.hang(NAMES, at=0.2)
    assert walk_on(walk, np.arange(24) * STEP) == []
    # Lost and carried back to the middle, the camera begins a sub-map and reads what it read before.
    merges = walk_on(walk, np.arange(6, 20) * STEP, anew=True)
    assert len(merges) == int(is_advised)
    if is_advised:
        frame_from_true = walk.map.world_from_keyframe(0) @ walk.truth[0]
        for keyframe, true in enumerate(walk.truth):
            metres, radians = pose_error(walk.map.camera_from_world(keyframe) @ frame_from_true, true)
            assert metres < 0.03, f"keyframe {keyframe}"
            assert radians < 0.02


@pytest.mark.parametrize(("is_advised", "is_read", "merges"), [(False, True, 1), (True, False, 1), (True, True, 0)])
def test_signs_that_differ_keep_twins_apart(is_advised: bool, is_read: bool, merges: int) -> None:
    # Two stretches of the ring are alike to the last patch; nothing tells a camera that wakes up in one from the other.
    world = World.of(np.random.default_rng(0)).with_twin_sector(at=0.9, twin=-2.0, width=2.2)
    walk = ReadWalk(world, 7, is_advised=is_advised)
    walk.hang(NAMES, at=0.2)
    if is_read:
        walk.hang(OTHERS, at=0.2 - 2.9)
    walk_on(walk, np.arange(0, 12) * STEP)
    found = walk_on(walk, 0.45 - 2.9 + np.arange(0, 6) * STEP, anew=True)
    assert len(found) == merges
    assert (walk.closer.counts.rejected[SIGNS_DIFFER] > 0) == (merges == 0)


def test_signs_that_agree_are_no_hindrance() -> None:
    walk = ReadWalk(World.of(np.random.default_rng(0)), 8)
    walk.hang(NAMES, at=0.2)
    walk_on(walk, np.arange(24) * STEP)
    events = walk_on(walk, np.arange(6, 20) * STEP, anew=True)
    assert [event.kind for event in events].count(EventKind.MERGE) == 1
    assert walk.closer.counts.rejected[SIGNS_DIFFER] == 0
