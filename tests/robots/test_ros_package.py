"""The package for ROS 2, with stand-ins for rclpy and for ROS's own modules: bytes go in and out as rclpy has them."""

import importlib
import re
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml

from lpslam import __version__
from lpslam.config import Config, RobotConfig
from lpslam.robots import building, types
from lpslam.sources.open import open_source
from robots.robot_parts import COLOUR, DEPTH, INFO, calibration, pictures

ROS2 = Path(__file__).parents[2] / "ros2"
PACKAGE = ROS2 / "lpslam_ros"

pytestmark = pytest.mark.skipif(not PACKAGE.is_dir(), reason="the package for ROS is not beside the tests")


class Ros:
    """What a context of ROS is to the node under test."""

    def __init__(self) -> None:
        self.is_ok = threading.Event()
        self.is_ok.set()
        self.given: dict[str, Any] = {}
        self.published: dict[str, list[bytes]] = {}
        self.qualities: dict[str, Any] = {}
        self.subscriptions: dict[str, Callable[[bytes], None]] = {}
        self.services: dict[str, tuple[Any, Callable[[Any, Any], Any]]] = {}
        self.goals: list[Any] = []
        self.has_nav2 = self.accepts = True
        self.said: list[str] = []
        self.destroyed = False


class Node:
    ros: Ros

    def __init__(self, name: str) -> None:
        self._declared: dict[str, Any] = {}

    def declare_parameter(self, name: str, default: Any) -> None:
        assert name not in self._declared
        self._declared[name] = self.ros.given.get(name, default)

    def get_parameter(self, name: str) -> Any:
        return SimpleNamespace(value=self._declared[name])

    def create_publisher(self, kind: Any, topic: str, quality: Any) -> Any:
        self.ros.qualities[topic] = quality

        def publish(message: Any) -> None:
            assert isinstance(message, bytes)
            if not self.ros.is_ok.is_set():
                raise RuntimeError("the context is gone")
            types.decoded(message, kind.__msgtype__)
            self.ros.published.setdefault(topic, []).append(message)

        return SimpleNamespace(publish=publish)

    def create_subscription(
        self, kind: Any, topic: str, callback: Any, quality: Any, *, callback_group: Any, raw: bool
    ) -> None:
        assert raw
        assert kind.__msgtype__
        self.ros.subscriptions[topic] = callback

    def create_service(self, kind: Any, name: str, callback: Any, *, callback_group: Any) -> None:
        self.ros.services[name] = (kind, callback)

    def get_logger(self) -> Any:
        say = self.ros.said.append
        return SimpleNamespace(info=say, warning=say, error=say)

    def destroy_node(self) -> None:
        self.ros.destroyed = True


class Future:
    def __init__(self, value: Any) -> None:
        self._value = value

    def result(self) -> Any:
        return self._value

    def add_done_callback(self, callback: Any) -> None:
        callback(self)


class ActionClient:
    def __init__(self, node: Node, kind: Any, name: str) -> None:
        assert name == "navigate_to_pose"
        self._ros = node.ros

    def wait_for_server(self, timeout_sec: float) -> bool:
        return self._ros.has_nav2

    def send_goal_async(self, goal: Any) -> Future:
        self._ros.goals.append(goal)
        handle = SimpleNamespace(accepted=self._ros.accepts, get_result_async=lambda: Future(SimpleNamespace(status=4)))
        return Future(handle)


class Executor:
    def add_node(self, node: Node) -> None: ...

    def spin(self) -> None: ...

    def shutdown(self) -> None: ...


def _service(service: str) -> Any:
    known = types.store().types
    return SimpleNamespace(Request=known[types.request_of(service)], Response=known[types.response_of(service)])


@pytest.fixture
def ros(monkeypatch: pytest.MonkeyPatch) -> Ros:
    """ROS's modules, replaced; the package can be imported."""
    made = Ros()
    monkeypatch.setattr(Node, "ros", made, raising=False)

    def module(name: str, **contents: Any) -> None:
        built = ModuleType(name)
        built.__dict__.update(contents)
        monkeypatch.setitem(sys.modules, name, built)

    module("rclpy", init=lambda args=None: None, ok=made.is_ok.is_set, try_shutdown=made.is_ok.clear)
    module("rclpy.node", Node=Node)
    module("rclpy.action", ActionClient=ActionClient)
    groups = {name: type(name, (), {}) for name in ("MutuallyExclusiveCallbackGroup", "ReentrantCallbackGroup")}
    module("rclpy.callback_groups", **groups)
    stopped = type("ExternalShutdownException", (Exception,), {})
    module("rclpy.executors", MultiThreadedExecutor=Executor, ExternalShutdownException=stopped)
    policies = {
        "QoSHistoryPolicy": SimpleNamespace(KEEP_LAST=1),
        "QoSReliabilityPolicy": SimpleNamespace(RELIABLE="reliable", BEST_EFFORT="best effort"),
        "QoSDurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL="latched", VOLATILE="volatile"),
    }
    module("rclpy.qos", QoSProfile=lambda **fields: SimpleNamespace(**fields), **policies)
    module(
        "rclpy.serialization",
        serialize_message=types.encoded,
        deserialize_message=lambda data, kind: types.decoded(data, kind.__msgtype__),
    )
    action = SimpleNamespace(Goal=lambda: SimpleNamespace(pose=None))
    module("nav2_msgs", action=None)
    module("nav2_msgs.action", NavigateToPose=action)
    for package in ("sensor_msgs", "tf2_msgs", "geometry_msgs", "nav_msgs", "visualization_msgs", "vision_msgs"):
        module(package)
        known = {name.rpartition("/")[2]: kind for name, kind in types.store().types.items()
                 if name.startswith(f"{package}/msg/")}  # fmt: skip
        module(f"{package}.msg", **known)
    module("lpslam_interfaces")
    module("lpslam_interfaces.srv", Ask=_service(types.ASK), Goal=_service(types.GOAL))
    monkeypatch.syspath_prepend(str(PACKAGE))
    for name in [each for each in sys.modules if each.startswith("lpslam_ros")]:
        monkeypatch.delitem(sys.modules, name)
    return made


def imported(name: str) -> Any:
    return importlib.import_module(f"lpslam_ros.{name}")


def test_parameters_are_those_of_the_configuration(ros: Ros, tmp_path: Path) -> None:
    overrides = tmp_path / "mine.yaml"
    overrides.write_text("robots: {grid_s: 3.0, map_frame: world}\nslam: {features: {max_depth: 6.0}}\n")
    ros.given = {"config": str(overrides), "odom_frame": "odom", "grid_s": 4.0, "navigate": True}
    config, own = imported("node").configured(Node("lpslam"))
    assert (config.robots.odom_frame, config.robots.grid_s, config.robots.map_frame) == ("odom", 4.0, "world")
    assert config.slam.features.max_depth == 6.0
    assert own["navigate"]


@pytest.mark.slow
def test_the_node_maps_and_keeps_the_map(ros: Ros, walk: Path, tmp_path: Path) -> None:
    ros.given = {"text": False, "output": str(tmp_path / "robot.lpmap"), "namespace": "/words", "reliable": True}
    main = threading.Thread(target=lambda: codes.append(imported("node").main()))
    codes: list[int] = []
    main.start()
    frames = list(open_source(walk, max_frames=12))
    camera = open_source(walk).camera
    while not {INFO, COLOUR, DEPTH} <= set(ros.subscriptions):
        threading.Event().wait(0.02)
    ros.subscriptions[INFO](types.encoded(calibration(camera)[1]))
    for frame in frames:
        for topic, message in pictures(frame):
            ros.subscriptions[topic](types.encoded(message))
        threading.Event().wait(0.05)
    waited = 0
    while len(ros.published.get("/words/pose", ())) < 6 and (waited := waited + 1) < 200:
        threading.Event().wait(0.05)
    kind, ask = ros.services["/words/ask"]
    answer = ask(kind.Request("Where is a book shop?"), kind.Response)
    # The context goes before the node has said its last.
    ros.is_ok.clear()
    main.join(60)
    assert codes == [0]
    assert (tmp_path / "robot.lpmap").is_file()
    assert ros.destroyed
    assert not answer.found
    assert answer.text
    assert ros.qualities["/words/grid"].durability == "latched"
    assert ros.qualities["/words/pose"].durability == "volatile"
    assert len(ros.published["/tf"]) == len(ros.published["/words/pose"]) >= 6


def test_a_mistake_is_one_line_and_two(ros: Ros) -> None:
    ros.given = {"config": "/nowhere.yaml"}
    assert imported("node").main() == 2
    assert ros.said == ["configuration /nowhere.yaml cannot be read (No such file or directory)"]


@pytest.mark.parametrize(
    ("has_nav2", "accepts", "said"),
    [(True, True, "status 4"), (True, False, "refused"), (False, True, "does not answer")],
)
def test_goals_go_to_nav2(ros: Ros, has_nav2: bool, accepts: bool, said: str) -> None:
    ros.has_nav2, ros.accepts = has_nav2, accepts
    imported("node").Navigator(Node("lpslam")).go(building.standing(1.0, 2.0, 0.5, 7, "map"))
    assert said in ros.said[0]
    assert [goal.pose.pose.position.y for goal in ros.goals] == ([2.0] if has_nav2 else [])


def test_pictures_that_may_be_lost_are_asked_for_only_if_wanted(ros: Ros) -> None:
    bus = imported("bus")
    assert bus._quality(False, False).reliability == "best effort"
    assert bus._quality(True, True).depth == 1


def test_services_are_defined_once() -> None:
    for service in (types.ASK, types.GOAL):
        name = service.rpartition("/")[2]
        text = (ROS2 / "lpslam_interfaces" / "srv" / f"{name}.srv").read_text(encoding="utf-8")
        assert text == types.service_definition(service)


def test_the_packages_say_the_same_everywhere() -> None:
    for package in ("lpslam_ros", "lpslam_interfaces"):
        tree = ElementTree.parse(ROS2 / package / "package.xml").getroot()
        assert (tree.findtext("name"), tree.findtext("version")) == (package, __version__)
    setup = (PACKAGE / "setup.py").read_text(encoding="utf-8")
    assert f'version="{__version__}"' in setup
    for path in re.findall(r'"((?:launch|config)/[^"]+)"', setup):
        assert (PACKAGE / path).is_file(), path
    depends = {each.text for each in tree_of("lpslam_ros").iter("exec_depend")}
    used = {types.IMAGE, types.TRANSFORMS, types.POSE, types.GRID, types.MARKERS, types.DETECTIONS, types.ASK}
    assert {kind.split("/")[0] for kind in used} <= depends


def tree_of(package: str) -> Any:
    return ElementTree.parse(ROS2 / package / "package.xml").getroot()


def test_the_parameters_file_names_parameters(ros: Ros) -> None:
    tree = yaml.safe_load((PACKAGE / "config" / "lpslam.yaml").read_text(encoding="utf-8"))
    given = tree["/**"]["ros__parameters"]
    own = imported("node").OWN_PARAMETERS
    assert set(own) <= set(given) <= set(own) | set(RobotConfig.model_fields)
    defaults = {**Config().robots.model_dump(), **own}
    assert given == {name: defaults[name] for name in given}
