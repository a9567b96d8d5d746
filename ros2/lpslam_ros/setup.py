"""The ament package of lpslam's node; lpslam itself is installed by pip."""

from setuptools import setup

NAME = "lpslam_ros"

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/lpslam.launch.py"]),
        (f"share/{NAME}/config", ["config/lpslam.yaml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    license="Apache-2.0",
    description="Language-perceptive RGB-D SLAM as a node of ROS 2",
    entry_points={"console_scripts": [f"lpslam_node = {NAME}.node:main"]},
)
