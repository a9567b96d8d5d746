"""Starts the node with the parameters of config/lpslam.yaml, or of another file."""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """The node and its arguments."""
    defaults = Path(get_package_share_directory("lpslam_ros")) / "config" / "lpslam.yaml"
    return LaunchDescription([
        DeclareLaunchArgument("params_file", default_value=str(defaults), description="Parameters of the node."),
        Node(
            package="lpslam_ros",
            executable="lpslam_node",
            name="lpslam",
            output="screen",
            parameters=[LaunchConfiguration("params_file")],
        ),
    ])  # fmt: skip
