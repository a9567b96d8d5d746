"""The node: parameters in, lpslam's robot node over rclpy, and goals to Nav2 where that is wanted."""

import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

import rclpy
from nav2_msgs.action import NavigateToPose
from rclpy.action import ActionClient
from rclpy.executors import ExternalShutdownException, MultiThreadedExecutor
from rclpy.node import Node

from lpslam.camera import PinholeCamera
from lpslam.config import Config, RobotConfig
from lpslam.errors import LpSlamError
from lpslam.language.registry import language_model
from lpslam.robots.node import RobotNode
from lpslam.session.session import Session
from lpslam_ros.bus import RclpyBus, ros_message

OWN_PARAMETERS: dict[str, Any] = {"output": "", "config": "", "llm": "", "text": True, "navigate": False}
_SERVER_S = 2.0
"""Seconds within which Nav2 must be there when a goal is sent."""


def configured(node: Node) -> tuple[Config, dict[str, Any]]:
    """The configuration and the node's own parameters.

    Raises:
        UserError: the configuration's file cannot be read.
    """
    for name, default in OWN_PARAMETERS.items():
        node.declare_parameter(name, default)
    own = {name: node.get_parameter(name).value for name in OWN_PARAMETERS}
    config = Config.from_yaml(Path(own["config"])) if own["config"] else Config()
    # What the file says is the default; what is given as a parameter counts.
    for name in RobotConfig.model_fields:
        node.declare_parameter(name, getattr(config.robots, name))
    given = {name: node.get_parameter(name).value for name in RobotConfig.model_fields}
    return config.model_copy(update={"robots": RobotConfig.model_validate(given)}), own


class Navigator:
    """Sends goals to Nav2; one that is sent later takes the place of the one before.

    Args:
        node: whose action client it is.
    """

    def __init__(self, node: Node) -> None:
        self._log = node.get_logger()
        self._client = ActionClient(node, NavigateToPose, "navigate_to_pose")

    def go(self, pose: Any) -> None:
        """Send the robot to a `PoseStamped` of lpslam."""
        if not self._client.wait_for_server(timeout_sec=_SERVER_S):
            self._log.warning("Nav2 does not answer: the goal is told, but nobody goes there")
            return
        goal = NavigateToPose.Goal()
        goal.pose = ros_message(pose)
        self._client.send_goal_async(goal).add_done_callback(self._note_answer)

    def _note_answer(self, future: Any) -> None:
        handle = future.result()
        if not handle.accepted:
            self._log.warning("Nav2 refused the goal")
            return
        handle.get_result_async().add_done_callback(
            lambda ended: self._log.info(f"Nav2 ended the goal with status {ended.result().status}")
        )


def main(args: list[str] | None = None) -> int:
    """Run the node until ROS ends it; 2 after a mistake that a user can mend."""
    rclpy.init(args=args)
    node = Node("lpslam")
    try:
        return _run(node)
    except LpSlamError as error:
        node.get_logger().error(str(error))
        return 2
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


def _run(node: Node) -> int:
    config, own = configured(node)
    log = node.get_logger()
    language = language_model(own["llm"] or None, config.language)

    def open_session(camera: PinholeCamera) -> Session:
        return Session(camera, config, language=language, live=True, text=own["text"], name="robot")

    on_goal = Navigator(node).go if own["navigate"] else lambda pose: None
    robot = RobotNode(RclpyBus(node), config, open_session, language, log.info, on_goal)
    executor = MultiThreadedExecutor()
    executor.add_node(node)
    spinning = threading.Thread(target=_spin, args=(executor,), name="executor", daemon=True)
    spinning.start()
    try:
        world = robot.run(lambda: not rclpy.ok())
    finally:
        robot.close()
        executor.shutdown()
        spinning.join(timeout=5.0)
    if world is not None and own["output"]:
        world.save(own["output"])
        log.info(f"the map is in {own['output']}")
    return 0


def _spin(executor: MultiThreadedExecutor) -> None:
    with suppress(ExternalShutdownException):
        executor.spin()


if __name__ == "__main__":
    raise SystemExit(main())
