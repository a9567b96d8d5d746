"""Headers that count time in another unit than seconds, and where cameras stand by tf_static."""

from pathlib import Path

import numpy as np
import pytest
from bag_writers import COLOUR, DEPTH, DEPTH_INFO, FIRST, KINDS, STEP, Entry, K, Types, walk, write
from recordings import HEIGHT, WIDTH, picture, raw_depth
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.open import open_source
from lpslam.sources.registering.registration import DepthRegistration, DepthRig


@pytest.mark.parametrize("power", [-6, -3, 3, 6])
@pytest.mark.parametrize("kind", KINDS)
def test_headers_in_another_unit_are_converted(
    tmp_path: Path, kind: str, power: int, caplog: pytest.LogCaptureFixture
) -> None:
    """Since the camera was started: a header of ROS holds no more than 2^32 seconds."""

    def counted(types: Types) -> list[Entry]:
        entries = []
        for name, logged, message in walk(types, 20):
            number = (logged - FIRST) // STEP
            stamp = round(number * STEP * 10.0**power) + (1 if power < 0 else 10**9)
            if name == COLOUR:
                message = types.image(stamp, picture(number), "rgb8")
            elif name == DEPTH:
                message = types.image(stamp, raw_depth(number), "16UC1")
            entries.append((name, logged, message))
        return entries

    source = open_source(write(tmp_path / f"walk.{kind}", counted))
    assert f"in another unit; they are taken times 1e{-power}" in caplog.text
    frames = list(source)
    assert len(frames) == 20
    # A millionth of a frame's time is 33 ns, and a header has no less than one.
    np.testing.assert_allclose(np.diff([frame.timestamp for frame in frames]), STEP / 1e9, atol=2e-3)
    assert source.camera.fps == pytest.approx(30, abs=1)


@pytest.mark.parametrize("seconds", [1 / 90, 1 / 5, 1.5])
def test_the_times_of_slow_and_fast_cameras_stay(
    tmp_path: Path, seconds: float, caplog: pytest.LogCaptureFixture
) -> None:
    """Recorded faster than they were taken, as by a replay."""

    def slow(types: Types) -> list[Entry]:
        entries = []
        for name, logged, message in walk(types, 10):
            if hasattr(message, "encoding"):
                number = (logged - FIRST) // STEP
                stamp = FIRST + round(number * seconds * 1e9)
                message.header.stamp.sec, message.header.stamp.nanosec = stamp // 10**9, stamp % 10**9
            entries.append((name, logged, message))
        return entries

    frames = list(open_source(write(tmp_path / "walk.mcap", slow)))
    assert "another unit" not in caplog.text
    np.testing.assert_allclose(np.diff([frame.timestamp for frame in frames]), seconds, atol=1e-6)


DEPTH_K = (40.0, 0.0, 30.0, 0.0, 41.0, 22.0, 0.0, 0.0, 1.0)


def apart(types: Types, links: list[tuple[str, str, np.ndarray, np.ndarray]]) -> list[Entry]:
    """Depth of a camera of its own, and where it stands."""
    entries: list[Entry] = []
    transforms = []
    for parent, child, turn, shift in links:
        quaternion = types.make("geometry_msgs/msg/Quaternion", *map(float, Rotation.from_rotvec(turn).as_quat()))
        pose = types.make("geometry_msgs/msg/Transform", types.make("geometry_msgs/msg/Vector3", *shift), quaternion)
        transforms.append(
            types.make("geometry_msgs/msg/TransformStamped", types.header(FIRST, frame=parent), child, pose)
        )
    entries.append(("/tf_static", FIRST, types.make("tf2_msgs/msg/TFMessage", transforms)))
    for name, logged, message in walk(types):
        if name == DEPTH:
            message.header.frame_id = "depth_optical"
        if name == DEPTH_INFO:
            message = types.info(logged, k=DEPTH_K)
        entries.append((name.replace("aligned_depth_to_color", "depth"), logged, message))
    return entries


@pytest.mark.parametrize("kind", KINDS)
def test_depth_is_registered_by_the_frames_of_the_robot(tmp_path: Path, kind: str) -> None:
    base_turn, base_shift = np.array([0.1, 0.0, 0.2]), np.array([0.1, 0.3, 0.2])
    depth_turn, depth_shift = np.array([0.0, 0.02, 0.01]), np.array([0.05, 0.0, 0.01])
    links = [
        ("base", "camera_color_optical_frame", base_turn, base_shift),
        ("camera_color_optical_frame", "depth_mount", depth_turn, depth_shift),
        ("/depth_mount", "depth_optical", np.zeros(3), np.array([0.0, 0.01, 0.0])),
    ]
    source = open_source(write(tmp_path / f"walk.{kind}", lambda types: apart(types, links)))
    colour_from_depth = np.eye(4)
    colour_from_depth[:3, :3] = Rotation.from_rotvec(depth_turn).as_matrix()
    colour_from_depth[:3, 3] = depth_shift + colour_from_depth[:3, :3] @ [0.0, 0.01, 0.0]
    colour = PinholeCamera(WIDTH, HEIGHT, K[0], K[4], K[2], K[5])
    depth = PinholeCamera(WIDTH, HEIGHT, DEPTH_K[0], DEPTH_K[4], DEPTH_K[2], DEPTH_K[5])
    register = DepthRegistration(DepthRig(depth, colour, colour_from_depth))
    frames = list(source)
    assert len(frames) == 6
    for number, frame in enumerate(frames):
        expected = register(raw_depth(number).astype(np.float32) * np.float32(0.001))
        np.testing.assert_allclose(frame.depth, expected, rtol=1e-6)


def test_frames_that_nothing_links_are_refused(tmp_path: Path) -> None:
    links = [("base", "camera_color_optical_frame", np.zeros(3), np.zeros(3))]
    with pytest.raises(UserError, match="is not registered to colour, and nothing says how the two cameras stand"):
        open_source(write(tmp_path / "walk.mcap", lambda types: apart(types, links)))
