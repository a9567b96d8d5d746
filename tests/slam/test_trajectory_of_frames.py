"""The trajectory: what it keeps of each frame, and how little."""

import tracemalloc

import numpy as np
import pytest

from lpslam.slam.state import TrackedFrame, TrackingState
from lpslam.slam.trajectory import Trajectory


def frame(index: int, pose: np.ndarray | None) -> TrackedFrame:
    state = TrackingState.LOST if pose is None else TrackingState.TRACKING
    return TrackedFrame(index, index / 30.0, state, 7, pose, pose, 100, False, "")


def shifted(x: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def test_frames_come_back_as_they_were_appended() -> None:
    trajectory = Trajectory()
    for index in range(5):
        trajectory.append(frame(index, None if index == 2 else shifted(index)))
    arrays = trajectory.to_arrays()
    assert arrays["index"].tolist() == [0, 1, 2, 3, 4]
    assert arrays["keyframe"].tolist() == [7, 7, -1, 7, 7]
    assert arrays["keyframe_from_camera"][:, 0, 3].tolist() == [0, 1, 0, 3, 4]
    again = Trajectory.from_arrays(arrays)
    again.append(frame(5, shifted(5)))
    assert again.to_arrays()["keyframe_from_camera"][-1].tolist() == shifted(5).tolist()
    assert (len(again), again.tracked_count) == (6, 5)


def test_disowned_frames_lose_their_poses() -> None:
    trajectory = Trajectory()
    for index in range(6):
        trajectory.append(frame(index, shifted(index)))
    trajectory.disown(since=3.5 / 30)
    arrays = trajectory.to_arrays()
    assert arrays["keyframe"].tolist() == [7, 7, 7, 7, -1, -1]
    assert arrays["keyframe_from_camera"][:, 0, 3].tolist() == [0, 1, 2, 3, 0, 0]


def test_frames_without_a_pose_are_placed_late_and_no_others() -> None:
    trajectory = Trajectory()
    trajectory.append(frame(0, None))
    assert trajectory.begin_session() == 1
    for index in range(1, 7):
        trajectory.append(frame(index, None if index in (2, 3, 5) else shifted(index)))
    # One of an earlier session, one with a pose, two without, and one that has not come.
    trajectory.place({index: (4, shifted(10 + index)) for index in (0, 1, 3, 5, 9)})
    arrays = trajectory.to_arrays()
    assert arrays["keyframe"].tolist() == [-1, 7, -1, 4, 7, 4, 7]
    assert arrays["keyframe_from_camera"][:, 0, 3].tolist() == [0, 1, 0, 13, 4, 15, 6]
    weak, lost, tracked = (list(TrackingState).index(TrackingState(state)) for state in ("weak", "lost", "tracking"))
    assert arrays["state"].tolist() == [lost, tracked, lost, weak, tracked, weak, tracked]
    assert trajectory.tracked_count == 5
    trajectory.place({})
    np.testing.assert_array_equal(trajectory.to_arrays()["keyframe"], arrays["keyframe"])


def test_a_day_of_walking_fits_in_memory() -> None:
    trajectory, pose, count = Trajectory(), shifted(1.0), 20_000
    tracemalloc.start()
    for index in range(count):
        trajectory.append(frame(index, pose))
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # 153 bytes, and what arrays keep in reserve.
    assert kept / count < 200


@pytest.mark.parametrize("name", ["index", "keyframe_from_camera"])
def test_a_column_that_is_no_number_is_refused(name: str) -> None:
    trajectory = Trajectory()
    trajectory.append(frame(0, shifted(0)))
    arrays = trajectory.to_arrays()
    arrays[name] = np.full(arrays[name].shape, "x")
    with pytest.raises(ValueError, match=f"trajectory column {name}"):
        Trajectory.from_arrays(arrays)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_pose_that_is_not_finite_is_refused(value: float) -> None:
    trajectory = Trajectory()
    trajectory.append(frame(0, shifted(0)))
    arrays = trajectory.to_arrays()
    arrays["keyframe_from_camera"][0, 1, 3] = value
    with pytest.raises(ValueError, match="not finite"):
        Trajectory.from_arrays(arrays)
