"""The node without a network: pictures in as bytes, poses, signs, ground and answers out."""

import importlib.util
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lpslam
from command_line import Command, command_line
from lpslam.config import Config, LiveConfig, PairingConfig, RobotConfig
from lpslam.errors import UserError
from lpslam.frames import RgbdFrame
from lpslam.ground.grid import Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.robots import building, types
from lpslam.robots.incoming import Incoming, Skipped
from lpslam.robots.node import RobotNode
from lpslam.robots.services import Moment, Services
from lpslam.robots.transforms import Transforms
from lpslam.sources.bags.transforms import rigid
from lpslam.sources.open import open_source
from robots.robot_parts import COLOUR, DEPTH, FRAME, INFO, WireBus, calibration, nanoseconds, pictures
from small_maps import WORLD_FROM_CAMERA, small_map, with_floor

FRAMES = 12


@pytest.fixture
def lpslam_command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    return command_line(monkeypatch, capsys)


@pytest.fixture(scope="module")
def frames(walk: Path) -> list[RgbdFrame]:
    return list(open_source(walk, max_frames=FRAMES))


class Robot:
    """A node that runs in a thread of its own, on a wire."""

    def __init__(self, walk: Path, **robots: Any) -> None:
        self.camera = open_source(walk).camera
        self.bus, self.said = WireBus(), list[str]()
        # All pictures may wait: on a busy machine some would be dropped.
        live = LiveConfig(backlog=2 * FRAMES)
        self.config = Config(robots=RobotConfig(**{"grid_s": 0.5, "silence_s": 0.3, **robots}), live=live)
        self.node = RobotNode(
            self.bus,
            self.config,
            lambda camera: lpslam.Session(camera, self.config, text=False, live=True),
            say=self.said.append,
        )
        self.world: LanguageMap | None = None
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        self.world = self.node.run(self._over.is_set)

    def give(self, frame: RgbdFrame, **changes: Any) -> None:
        """Publish a frame."""
        for topic, message in pictures(frame, **changes):
            self.bus.give(topic, message)
        time.sleep(0.05)

    def wait_for(self, count: int) -> None:
        until = time.monotonic() + 120  # kernels may have to be compiled first, beside other work
        while self.node.frames < count and time.monotonic() < until:
            time.sleep(0.02)
        assert self.node.frames >= count, (self.node.frames, self.node.skipped)

    def end(self) -> LanguageMap | None:
        self._over.set()
        self._thread.join(30)
        self.node.close()
        return self.world


@pytest.fixture
def robots(walk: Path) -> Iterator[Any]:
    made: list[Robot] = []

    def make(**options: Any) -> Robot:
        made.append(Robot(walk, **options))
        return made[-1]

    yield make
    for robot in made:
        robot.end()


@pytest.mark.slow
def test_pictures_become_poses_and_ground(robots: Any, frames: list[RgbdFrame]) -> None:
    robot = robots()
    robot.bus.give(*calibration(robot.camera))
    for frame in frames:
        robot.give(frame)
    robot.wait_for(FRAMES - 4)
    world = robot.end()
    sent = robot.bus.sent
    assert world is not None
    # Those at the end still waited for what might have been nearer in time.
    assert FRAMES - 4 <= len(sent["/lpslam/pose"]) == robot.node.frames <= FRAMES
    stamps = {nanoseconds(frame) for frame in frames}
    for pose, tree in zip(sent["/lpslam/pose"], sent["/tf"], strict=True):
        stamp = pose.header.stamp.sec * 10**9 + pose.header.stamp.nanosec
        assert stamp in stamps, "to the nanosecond that of the colour picture"
        (link,) = tree.transforms
        assert (link.header.frame_id, link.child_frame_id) == ("map", FRAME)
    last = world.frame_poses().world_from_camera[-1]
    told = rigid(sent["/tf"][-1].transforms[0].transform)
    assert told is not None
    assert np.allclose(told[:3, 3], last[:3, 3], atol=0.05)
    assert {"/lpslam/grid", "/lpslam/markers", "/lpslam/landmarks"} <= robot.bus.latched
    assert sent["/lpslam/landmarks"][-1].detections == []


@pytest.mark.slow
def test_with_odometry_the_map_is_told_from_odom(robots: Any, frames: list[RgbdFrame]) -> None:
    robot = robots(odom_frame="odom", base_frame="base_link")
    base_from_camera = np.eye(4)
    base_from_camera[:3, :3], base_from_camera[:3, 3] = WORLD_FROM_CAMERA[:3, :3], [0.2, 0.0, 1.1]
    odom_from_base = np.eye(4)
    odom_from_base[:3, 3] = [5.0, -2.0, 0.0]
    robot.bus.give("/tf_static", building.transforms([("base_link", FRAME, base_from_camera)], 0))
    robot.bus.give(*calibration(robot.camera))
    for frame in frames:
        robot.bus.give("/tf", building.transforms([("odom", "base_link", odom_from_base)], nanoseconds(frame)))
        robot.give(frame)
    robot.wait_for(8)
    robot.end()
    link = robot.bus.sent["/tf"][0].transforms[0]
    assert (link.header.frame_id, link.child_frame_id) == ("map", "odom")
    map_from_odom = rigid(link.transform)
    assert map_from_odom is not None
    # Down the chain the camera stands where the map begins.
    assert np.allclose(map_from_odom @ odom_from_base @ base_from_camera, WORLD_FROM_CAMERA, atol=0.05)
    base = robot.bus.sent["/lpslam/pose"][0].pose.position
    assert np.allclose([base.x, base.y, base.z], [-0.2, 0.0, -1.1], atol=0.05)


@pytest.mark.slow
def test_bad_frames_are_skipped_counted_and_said(robots: Any, frames: list[RgbdFrame]) -> None:
    robot = robots()
    robot.bus.give(INFO, b"\x00\x01\x00\x00nonsense")
    robot.bus.give(*calibration(robot.camera))
    good = iter(frames)
    for _ in range(6):
        robot.give(next(good))
    robot.wait_for(1)
    robot.bus.give(COLOUR, b"")
    robot.bus.give(DEPTH, types.encoded(building.pose_stamped(np.eye(4), 1, "map")))
    small = next(good)
    robot.give(RgbdFrame(0, small.timestamp, small.rgb[::2, ::2], small.depth[::2, ::2]))
    robot.give(replace(frames[0], timestamp=frames[0].timestamp - 60))
    for frame in good:
        robot.give(frame)
    robot.wait_for(7)
    time.sleep(0.5)
    robot.end()
    skipped = robot.node._incoming.skipped._counts
    assert any("are no sensor_msgs/msg/CameraInfo" in reason for reason in skipped)
    assert any("0 bytes are no sensor_msgs/msg/Image" in reason for reason in skipped)
    assert any("its colour is 320×240; the camera is 640×480" in reason for reason in skipped)
    assert skipped["its time lies far before that of a picture before it: the clock went backwards"] == 2
    assert any("could not be used" in line for line in robot.said)
    assert robot.node.frames >= 7, "the rest was mapped"


def test_the_ground_is_told(walk: Path) -> None:
    bus, world = WireBus(), with_floor(small_map())
    node = RobotNode(bus, Config(), lambda camera: pytest.fail("no camera"))
    node._tell_last(world)
    node.close()
    grid = world.grid()
    assert grid is not None
    assert np.array_equal(bus.sent["/lpslam/grid"][-1].data.reshape(grid.shape), grid.values)
    assert len(bus.sent["/lpslam/landmarks"][-1].detections) == len(world.landmarks())


def test_topics_that_stay_silent_are_named(walk: Path) -> None:
    bus, said = WireBus(), list[str]()
    config = Config(robots=RobotConfig(silence_s=0.1))
    node = RobotNode(bus, config, lambda camera: pytest.fail("no camera"), say=said.append)
    bus.give(*pictures(next(iter(open_source(walk))))[0])
    with pytest.raises(UserError, match=f"no frame came within 0.4 s: nothing came on {INFO}, {DEPTH};"):
        node.run(lambda: False, patience=0.4)
    node.close()
    assert said[0].startswith("waiting: nothing came on ")


def test_a_camera_that_is_not_calibrated_is_complained_of(walk: Path) -> None:
    bus, said = WireBus(), list[str]()
    node = RobotNode(bus, Config(), lambda camera: pytest.fail("no camera"), say=said.append)
    _, info = calibration(open_source(walk).camera)
    info.k = np.zeros(9)
    bus.give(INFO, info)
    bus.give(INFO, info)
    node.close()
    assert len(said) == 1
    assert "is not calibrated" in said[0]


def test_pictures_wait_within_bounds(frames: list[RgbdFrame]) -> None:
    incoming = Incoming(PairingConfig(), 2)
    for frame in frames:
        for topic, message in pictures(frame):
            incoming.put(types.encoded(message), types.IMAGE, is_depth=topic == DEPTH)
    until = time.monotonic() + 5
    while incoming.dropped < FRAMES - 6 and time.monotonic() < until:
        time.sleep(0.02)
    assert incoming.dropped >= FRAMES - 6, "the newest two wait, the rest is dropped and counted"
    incoming.close()


def test_a_clock_that_stays_back_is_believed(frames: list[RgbdFrame]) -> None:
    incoming = Incoming(PairingConfig(), 2)
    (_, colour), _ = pictures(frames[0])
    colour.header.stamp.sec += 10**6
    incoming.put(types.encoded(colour), types.IMAGE, is_depth=False)
    (_, colour), _ = pictures(frames[1])
    for _ in range(80):
        incoming.put(types.encoded(colour), types.IMAGE, is_depth=False)
    incoming.close()
    backwards = "its time lies far before that of a picture before it: the clock went backwards"
    assert incoming.skipped._counts[backwards] == 64, "one wrong time does not stop the robot for ever"


def test_reasons_are_bounded() -> None:
    skipped = Skipped()
    for number in range(1000):
        skipped.note(f"reason {number}")
    assert skipped.total == 1000
    assert len(skipped._counts) <= 51


def test_a_transform_of_another_time_does_not_count() -> None:
    transforms = Transforms(0.2)
    transforms.add(building.transforms([("odom", "base", np.eye(4))], 10**9), is_static=False)
    assert transforms.between("odom", "base", 10**9 + 10**8) is not None
    assert transforms.between("odom", "base", 2 * 10**9) is None


def test_the_map_hangs_above_whatever_the_camera_hangs_on() -> None:
    transforms = Transforms(0.2)
    assert transforms.top("camera", "map") == "camera"
    transforms.add(building.transforms([("base", "camera", np.eye(4))], 0), is_static=True)
    transforms.add(building.transforms([("odom", "base", np.eye(4)), ("map", "odom", np.eye(4))], 0), is_static=False)
    assert transforms.top("camera", "map") == "odom"
    transforms.add(building.transforms([("camera", "odom", np.eye(4))], 0), is_static=True)
    assert transforms.top("camera", "map") in ("base", "odom", "camera"), "a ring has no top, and ends all the same"


def test_without_dds_the_extra_is_named(lpslam_command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    find: Any = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == "cyclonedds" else find(name, *a))
    assert lpslam_command("robot").complaint == "lpslam robot needs an optional part: pip install 'lp-slam[dds]'"


class Mapped:
    """What services need of a session, of a map that is there already."""

    def __init__(self, world: LanguageMap) -> None:
        self._world, self.pose = world, WORLD_FROM_CAMERA.copy()
        self.pose[0, 3] = 3.5  # on the floor that was seen

    def ask(self, question: str, language: Any = None) -> Any:
        return lpslam.ask(self._world, question, language=language)

    def landmarks(self) -> Any:
        return self._world.landmarks()


def services(grid: Grid | None, world: LanguageMap, goals: list[Any] | None = None) -> WireBus:
    bus = WireBus()
    found = goals if goals is not None else []
    made = Services(
        lambda: Mapped(world), lambda: grid, Config(), None, lambda: Moment(7, "map"),
        lambda pose, path: found.append((pose, path)),
    )  # fmt: skip
    bus.serve("ask", types.ASK, made.ask)
    bus.serve("goal", types.GOAL, made.goal)
    return bus


def request(service: str, *fields: Any) -> Any:
    return types.made(types.request_of(service), *fields)


def test_a_question_is_answered() -> None:
    bus = services(None, small_map())
    answer = bus.services["ask"](request(types.ASK, "Where can I drink a coffee?"))
    assert (answer.found, answer.name, answer.landmark_id) == (True, "Starbucks", 0)
    assert answer.position.z == pytest.approx(1.0)
    assert "Starbucks" in answer.text


@pytest.mark.parametrize("question", ["", "x" * 5000, "Where can I buy a submarine?"])
def test_what_cannot_be_answered_says_why(question: str) -> None:
    bus = services(None, small_map())
    answer = bus.services["ask"](request(types.ASK, question))
    assert not answer.found
    assert answer.text
    assert answer.landmark_id == -1


def test_a_goal_is_a_pose_before_the_sign_and_a_path() -> None:
    world = with_floor(small_map(["Starbucks", "Exit"], spacing=6.0))
    goals: list[Any] = []
    bus = services(world.grid(), world, goals)
    (mark,) = [each for each in world.landmarks() if each.name == "Exit"]
    found = bus.services["goal"](request(types.GOAL, "", mark.id))
    assert found.found, found.text
    assert found.text == "Exit"
    assert found.is_before
    at = found.pose.pose.position
    assert np.hypot(at.x - mark.position[0], at.y - mark.position[1]) < 3.0
    assert found.missing == pytest.approx(np.hypot(at.x - mark.position[0], at.y - mark.position[1]))
    last = found.path.poses[-1].pose
    assert (last.position.x, last.position.y) == pytest.approx((at.x, at.y), abs=0.1)
    assert len(goals) == 1


@pytest.mark.parametrize("has_floor", [False, True])
def test_no_goal_says_why(has_floor: bool) -> None:
    world = with_floor(small_map()) if has_floor else small_map()
    goals: list[Any] = []
    bus = services(world.grid(), world, goals)
    found = bus.services["goal"](request(types.GOAL, "", 999_999 if has_floor else 0))
    assert not found.found
    assert ("no landmark 999999" if has_floor else "no floor was seen") in found.text
    assert goals == []
