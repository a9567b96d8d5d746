"""The points of a room that grows: what is told of them, and how little."""

import numpy as np

from lpslam.camera import PinholeCamera
from lpslam.config import PageConfig
from lpslam.ground.scans import Scans
from lpslam.page.growing import GrowingPoints

CAMERA = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5)
MOVED, SEEN, GONE = range(3)


def at(x: float) -> np.ndarray:
    """(4, 4) `world_from_keyframe` of a camera that looks along the map's z axis."""
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def walls(*keyframes: int, far: float = 2.0) -> Scans:
    """Scans of a red wall so many metres ahead."""
    scans = Scans(CAMERA, 64)
    for each in keyframes:
        scans.take(each, np.full((48, 64, 3), (250, 10, 10), np.uint8), np.full((48, 64), far, np.float32))
    return scans


class Reader:
    """What a page knows that reads every answer, as `takeParts` of the page does."""

    def __init__(self) -> None:
        self.version, self.parts = 0, {}  # type: int, dict[int, tuple[np.ndarray, np.ndarray]]

    def read(self, content: bytes) -> dict[int, int]:
        """Take an answer; which keyframes it told of, and what."""
        self.version, is_whole, count = np.frombuffer(content[:12], "<u4").tolist()
        if is_whole:
            self.parts = {}
        told, start = {}, 16 + 64 * count
        for record in range(count):
            head = np.frombuffer(content, "<u4", 3, 16 + 64 * record)
            place = np.frombuffer(content, "<f4", 12, 32 + 64 * record).reshape(3, 4)
            keyframe, kind, rows = head.tolist()
            told[keyframe] = kind
            if kind == SEEN:
                self.parts[keyframe] = np.frombuffer(content, "<u2", rows * 4, start).reshape(-1, 4), place
                start += 8 * rows
            elif kind == MOVED:
                self.parts[keyframe] = self.parts[keyframe][0], place
            else:
                del self.parts[keyframe]
        assert start == len(content)
        return told

    def points(self) -> np.ndarray:
        """(n, 3) metres, map frame."""
        placed = [rows[:, :3] / 65535 @ place[:, :3].T + place[:, 3] for rows, place in self.parts.values()]
        return np.concatenate(placed)


def test_what_is_told_lies_where_it_was_seen_and_once_in_each_cube() -> None:
    room, reader, config = GrowingPoints(PageConfig()), Reader(), PageConfig()
    assert room.update(walls(0, 1), {0: at(0.0), 1: at(1.0)})
    assert reader.read(room.since(0)) == {0: SEEN, 1: SEEN}
    points = reader.points()
    np.testing.assert_allclose(points[:, 2], 2.0, atol=1e-3)
    # Two metres ahead a picture is 2.1 metres wide; the second is taken a metre to its right.
    assert abs(points[:, 0].min() + 1.05) < 0.05
    assert abs(points[:, 0].max() - 2.05) < 0.05
    cubes = np.floor(points / config.growing_cube + 1e-3).astype(int)
    assert len(np.unique(cubes, axis=0)) > 0.9 * len(points)
    (red, _), _ = np.unique(reader.parts[0][0][:, 3] >> 11, return_counts=True), None
    assert red.tolist() == [30]


def test_only_what_is_new_or_has_moved_is_told() -> None:
    room, reader = GrowingPoints(PageConfig()), Reader()
    room.update(walls(0, 1), {0: at(0.0), 1: at(1.0)})
    whole = len(room.since(0))
    reader.read(room.since(0))
    # Nothing, and what is too little to be seen.
    assert not room.update(walls(0, 1), {0: at(0.0), 1: at(1.001)})
    assert reader.read(room.since(reader.version)) == {}
    # A corrected map is a place, and no point again.
    assert room.update(walls(0, 1), {0: at(0.0), 1: at(1.5)})
    told = room.since(reader.version)
    assert len(told) < 100 < whole
    assert reader.read(told) == {1: MOVED}
    assert reader.points()[:, 0].max() > 2.4
    assert room.update(walls(0, 1, 2), {0: at(0.0), 1: at(1.5), 2: at(4.0)})
    assert reader.read(room.since(reader.version)) == {2: SEEN}
    assert room.update(walls(0, 2), {0: at(0.0), 2: at(4.0)})
    assert reader.read(room.since(reader.version)) == {1: GONE}
    # Who missed all of that has the same in the end, and who asks for what never was is told all.
    late = Reader()
    late.read(room.since(0))
    assert late.parts.keys() == reader.parts.keys() == {0, 2}
    assert Reader().read(room.since(99)) == {0: SEEN, 2: SEEN}


def test_what_is_freed_by_a_keyframe_that_is_gone_can_be_seen_by_another() -> None:
    room = GrowingPoints(PageConfig())
    room.update(walls(0), {0: at(0.0)})
    first = len(room)
    room.update(walls(0, 1), {0: at(0.0), 1: at(0.0)})
    assert len(room) == first, "the same wall has its points already"
    room.update(walls(2), {2: at(0.0)})
    assert len(room) == first


def test_too_many_are_taken_in_larger_cubes() -> None:
    few = PageConfig(growing_points=1500)
    room, reader = GrowingPoints(few), Reader()
    room.update(walls(0), {0: at(0.0)})
    reader.read(room.since(0))
    room.update(walls(0, 1, 2, 3), {each: at(float(2 * each)) for each in range(4)})
    reader.read(room.since(reader.version))
    assert 300 < len(room) <= few.growing_points
    assert len(reader.points()) == len(room)
    counts, _ = np.histogram(reader.points()[:, 0], bins=4, range=(-1, 7))
    assert counts.min() > 0.5 * counts.max()
