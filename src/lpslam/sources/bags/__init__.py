"""Recordings of robots and cameras in one file: ROS 1 bags, ROS 2 databases, MCAP."""
