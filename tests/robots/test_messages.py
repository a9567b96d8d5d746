"""Messages of ROS 2: through CDR and back, with the hashes and names that ROS has for their types."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid
from lpslam.mapfile.board_poses import board_pose
from lpslam.robots import building, types
from lpslam.sources.bags.lenses import camera_of
from lpslam.sources.bags.pictures import colour_of, depth_of, in_metres
from lpslam.sources.bags.transforms import rigid
from lpslam.text.types import Landmark

STAMP = 1_700_000_000_123_456_789
CAMERA = PinholeCamera(320, 240, 300.0, 301.0, 159.5, 119.5, (0.1, -0.05, 0.001, 0.002, 0.01))
# Published: `ros2 topic info --verbose` and the key expressions of rmw_zenoh show them.
PUBLISHED = {
    "std_msgs/msg/String": "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    types.IMAGE: "RIHS01_d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
}
STANDARD = (
    *(types.IMAGE, types.COMPRESSED, types.CAMERA_INFO, types.TRANSFORMS, types.POSE, types.GRID, types.PATH),
    types.MARKERS,
)
HOSTILE = "<img src=x onerror=alert(1)> \u202e{0.__class__} ../../etc\x00\x1b[31m\n%s $(reboot) \ud800"


def sign(identifier: int = 3000, name: str = "KFC", **changes: Any) -> Landmark:
    given_ = {
        "variants": {name: 3}, "position": np.array([2.0, -1.0, 1.5]), "normal": np.array([-1.0, 0.0, 0.0]),
        "spread": 0.03, "width": 1.2, "height": 0.3, "observations": 5, "confidence": 0.9,
    }  # fmt: skip
    return Landmark(identifier, name, **{**given_, **changes})


def back(message: Any) -> Any:
    return types.decoded(types.encoded(message), message.__msgtype__)


@pytest.mark.parametrize("kind", PUBLISHED)
def test_hashes_are_those_that_ros_publishes(kind: str) -> None:
    assert types.type_hash(kind) == PUBLISHED[kind]


@pytest.mark.parametrize("kind", STANDARD)
@pytest.mark.parametrize("distribution", [Stores.ROS2_IRON, Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_types_are_the_same_in_later_distributions(kind: str, distribution: Stores) -> None:
    assert get_typestore(distribution).hash_rihs01(kind) == types.type_hash(kind)


def test_names_in_dds_are_those_of_ros() -> None:
    assert types.dds_type(types.IMAGE) == "sensor_msgs::msg::dds_::Image_"
    assert types.dds_type(types.request_of(types.ASK)) == "lpslam_interfaces::srv::dds_::Ask_Request_"
    assert types.dds_topic("/lpslam/pose") == "rt/lpslam/pose"
    assert types.dds_topic("lpslam/askRequest", "rq") == "rq/lpslam/askRequest"


def test_pictures_come_back_as_they_are_read_from_bags() -> None:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (24, 32, 3), np.uint8)
    metres = rng.uniform(0.3, 5, (24, 32)).astype(np.float32)
    millimetres = rng.integers(0, 5000, (24, 32)).astype(np.uint16)
    assert np.array_equal(colour_of(back(building.picture(rgb, STAMP, "camera"))), rgb)
    assert np.array_equal(depth_of(back(building.picture(metres, STAMP, "camera"))), metres)
    raw = depth_of(back(building.picture(millimetres, STAMP, "camera")))
    assert np.allclose(in_metres(raw, 1000.0), millimetres / 1000.0)


def test_a_camera_comes_back() -> None:
    info = back(building.camera_info(CAMERA, STAMP, "camera"))
    assert camera_of(info, "/info", is_rectified=False) == CAMERA
    assert (info.header.stamp.sec, info.header.stamp.nanosec) == (1_700_000_000, 123_456_789)


@given(st.lists(st.floats(-1, 1), min_size=7, max_size=7))
def test_poses_come_back(values: list[float]) -> None:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(3 * np.array(values[:3])).as_matrix()
    pose[:3, 3] = values[3:6]
    tree = back(building.transforms([("map", "odom", pose)], STAMP))
    (entry,) = tree.transforms
    assert (entry.header.frame_id, entry.child_frame_id) == ("map", "odom")
    found = rigid(entry.transform)
    assert found is not None
    assert np.allclose(found, pose, atol=1e-9)
    stamped = back(building.pose_stamped(pose, STAMP, "map")).pose
    assert np.allclose([stamped.position.x, stamped.position.y, stamped.position.z], values[3:6])


def test_a_grid_keeps_its_cells_and_where_it_lies() -> None:
    values = np.array([[FREE, OCCUPIED, UNKNOWN], [UNKNOWN, FREE, FREE]], np.int8)
    grid = back(building.occupancy_grid(Grid(values, (-1.5, 2.0), 0.05), STAMP, "map"))
    assert (grid.info.width, grid.info.height) == (3, 2)
    assert grid.info.resolution == np.float32(0.05)
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == (-1.5, 2.0)
    # Row by row from the lowest y, as nav_msgs/OccupancyGrid says.
    assert grid.data.tolist() == [0, 100, -1, -1, 0, 0]


def test_a_path_faces_where_it_goes() -> None:
    path = back(building.path(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), STAMP, "map"))
    yaws = [2 * np.arctan2(each.pose.orientation.z, each.pose.orientation.w) for each in path.poses]
    assert np.allclose(yaws, [0.0, np.pi / 2, np.pi / 2])
    assert len(back(building.path(np.array([[1.0, 2.0]]), STAMP, "map", 0.5)).poses) == 1
    assert back(building.path(np.zeros((0, 2)), STAMP, "map")).poses == []


def test_signs_are_markers_with_their_text() -> None:
    array = back(building.markers([sign(), sign(4000, "新华书店")], STAMP, "map"))
    assert array.markers[0].action == 3, "what was drawn before goes first"
    texts = {marker.id: marker.text for marker in array.markers if marker.type == 9}
    assert texts == {3000: "KFC", 4000: "新华书店"}
    assert all(marker.header.frame_id == "map" for marker in array.markers)


def test_a_board_faces_its_readers() -> None:
    pose = board_pose(sign(normal=np.array([0.0, -1.0, 0.0])))
    assert np.allclose(pose[:3, :3] @ [1, 0, 0], [0, -1, 0])
    assert np.allclose(pose[:3, :3] @ [0, 0, 1], [0, 0, 1])
    flat = board_pose(sign(normal=np.array([0.0, 0.0, 1.0])))
    assert np.isclose(np.linalg.det(flat[:3, :3]), 1.0)


def test_landmarks_are_detections() -> None:
    (found,) = back(building.detections([sign()], STAMP, "map")).detections
    assert (found.id, found.results[0].hypothesis.class_id) == ("3000", "KFC")
    assert found.results[0].hypothesis.score == pytest.approx(0.9)
    assert (found.bbox.center.position.x, found.bbox.size.y, found.bbox.size.z) == (2.0, 1.2, 0.3)


def test_what_has_no_place_is_left_out() -> None:
    lost = sign(position=np.array([np.nan, 0.0, 0.0]))
    assert back(building.detections([lost, sign()], STAMP, "map")).detections[0].id == "3000"
    assert len(back(building.markers([lost], STAMP, "map")).markers) == 1


def test_hostile_signs_stay_text() -> None:
    marks = [sign(1000, HOSTILE), sign(2**40, "x" * 10_000)]
    array = back(building.markers(marks, STAMP, "map"))
    texts = [marker.text for marker in array.markers if marker.type == 9]
    assert texts[0].startswith("<img src=x onerror=alert(1)> {0.__class__} ../../etc")
    assert all(ch.isprintable() for ch in texts[0])
    assert len(texts[1]) == 200
    assert {marker.ns for marker in array.markers} == {"", "boards", "signs"}
    assert all(not marker.mesh_resource and not marker.texture_resource for marker in array.markers)
    found = back(building.detections(marks, STAMP, "map")).detections
    assert found[0].results[0].hypothesis.class_id == texts[0]


@given(st.text(max_size=60))
def test_any_text_can_be_told(name: str) -> None:
    assert len(back(building.markers([sign(name=name)], STAMP, "map")).markers) == 3


@pytest.mark.parametrize("cut", [0, 1, 4, 7, 30])
def test_damaged_bytes_are_refused(cut: int) -> None:
    data = types.encoded(building.pose_stamped(np.eye(4), STAMP, "map"))
    with pytest.raises(types.BadBytesError, match="PoseStamped"):
        types.decoded(data[:cut], types.POSE)
