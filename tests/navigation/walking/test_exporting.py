"""Robots' files, read by their published rules: map_server's trinary images, nav_msgs/Path, GeoJSON and SVG."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from lpslam.config import WayConfig
from lpslam.errors import UserError
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid
from lpslam.navigation.walking.exporting import export_ground
from lpslam.navigation.walking.routes import best_order, route_through
from lpslam.navigation.walking.ways import Walkable
from lpslam.text.types import Landmark

HOSTILE = "<img onerror=alert(1)> & 'x': {a}\n- b"


def mark(id_: int, name: str, x: float, y: float, normal: tuple[float, float]) -> Landmark:
    return Landmark(id_, name, {name: 1}, np.array([x, y, 2.0]), np.array([*normal, 0.0]), 0.01, 1.0, 0.3, 5, 0.9)


@pytest.fixture
def walkable() -> Walkable:
    values = np.full((100, 160), FREE, np.int8)
    values[:1], values[-1:], values[:, :1], values[:, -1:] = (OCCUPIED,) * 4
    values[40:44, 60:100] = OCCUPIED
    values[80:, 120:] = UNKNOWN
    return Walkable(Grid(values, (-2.0, -1.0), 0.05), WayConfig())


MARKS = [mark(1, "KFC", -1.95, 1.0, (1.0, 0.0)), mark(2, HOSTILE, 2.0, -0.95, (0.0, 1.0))]


def map_server(folder: Path, name: str) -> tuple[np.ndarray, dict[str, object]]:
    """What nav2_map_server makes of a file in trinary mode: occupancy (rows from the bottom), and the header."""
    header = yaml.safe_load((folder / name).read_text())
    data = (folder / str(header["image"])).read_bytes()
    found = re.match(rb"P5\s(\d+)\s(\d+)\s255\s", data)
    assert found is not None
    width, height = int(found[1]), int(found[2])
    grey = np.frombuffer(data[found.end() :], np.uint8).reshape(height, width)
    shade = grey / 255.0 if header["negate"] else (255 - grey) / 255.0
    occupancy = np.full(grey.shape, -1, int)
    occupancy[shade > header["occupied_thresh"]] = 100
    occupancy[shade < header["free_thresh"]] = 0
    return occupancy[::-1], header


def test_a_map_server_reads_the_same_grid(walkable: Walkable, tmp_path: Path) -> None:
    written = export_ground(tmp_path, walkable, MARKS)
    assert all(path.is_file() for path in written)
    occupancy, header = map_server(tmp_path, "map.yaml")
    assert np.array_equal(occupancy, walkable.grid.values)
    assert header["resolution"] == 0.05
    assert header["origin"] == [-2.0, -1.0, 0.0]
    assert header["mode"] == "trinary"


def test_robots_keep_out_before_warnings(walkable: Walkable, tmp_path: Path) -> None:
    export_ground(tmp_path, walkable, MARKS, warnings=MARKS[:1])
    occupancy, _ = map_server(tmp_path, "keepout.yaml")
    assert occupancy[walkable.grid.cell(np.array([-1.8, 1.0]))] == 100
    assert occupancy[walkable.grid.cell(np.array([3.0, 1.0]))] == 0


def test_waypoints_stand_on_free_ground_and_face_their_signs(walkable: Walkable, tmp_path: Path) -> None:
    export_ground(tmp_path, walkable, MARKS)
    waypoints = yaml.safe_load((tmp_path / "waypoints.yaml").read_text())["waypoints"]
    assert [each["id"] for each in waypoints] == [1, 2]
    for each, sign in zip(waypoints, MARKS, strict=True):
        at = np.array([each["x"], each["y"]])
        assert walkable.grid.at(at) == FREE
        towards = sign.position[:2] - at
        assert np.cos(each["yaw"] - np.arctan2(towards[1], towards[0])) > 0.99


def test_a_route_is_a_path_whose_poses_face_onward(walkable: Walkable, tmp_path: Path) -> None:
    legs = route_through(np.array([5.0, 2.0]), MARKS, walkable)
    export_ground(tmp_path, walkable, MARKS, legs=legs)
    path = yaml.safe_load((tmp_path / "route.yaml").read_text())
    assert path["header"]["frame_id"] == "map"
    places = np.array([[pose["pose"]["position"][axis] for axis in "xyz"] for pose in path["poses"]])
    assert places[0, :2] == pytest.approx([5.0, 2.0], abs=0.06)
    for pose, here, there in zip(path["poses"], places[:-1], places[1:], strict=False):
        turn = pose["pose"]["orientation"]
        assert turn["z"] ** 2 + turn["w"] ** 2 == pytest.approx(1.0, abs=1e-4)
        yaw, step = 2.0 * np.arctan2(turn["z"], turn["w"]), there - here
        if np.linalg.norm(step) > 0.01:
            assert np.cos(yaw - np.arctan2(step[1], step[0])) > 0.99


def test_names_from_signs_are_text_in_every_file(walkable: Walkable, tmp_path: Path) -> None:
    legs = route_through(np.array([5.0, 2.0]), MARKS, walkable)
    export_ground(tmp_path, walkable, MARKS, legs=legs)
    drawn = ElementTree.parse(tmp_path / "floor_plan.svg")
    assert {each.tag.rpartition("}")[2] for each in drawn.iter()} == {
        "svg",
        "rect",
        "path",
        "circle",
        "text",
        "polyline",
    }
    assert "1 m" in [each.text for each in drawn.iter()]
    places = json.loads((tmp_path / "places.geojson").read_text())
    assert places["type"] == "FeatureCollection"
    assert [each["geometry"]["type"] for each in places["features"]] == ["Point", "Point"]
    assert "<img onerror" in places["features"][1]["properties"]["name"]
    assert yaml.safe_load((tmp_path / "waypoints.yaml").read_text())["waypoints"][1]["name"].startswith("<img")


def test_the_best_order_is_the_shortest(walkable: Walkable) -> None:
    signs = [mark(at, str(at), x, -0.95, (0.0, 1.0)) for at, x in enumerate((5.0, -1.0, 2.0))]
    legs = best_order(np.array([-1.5, 1.0]), signs, walkable)
    assert [leg.landmark.id for leg in legs] == [1, 2, 0]
    asked = route_through(np.array([-1.5, 1.0]), signs, walkable)
    assert sum(leg.way.length for leg in legs) < sum(leg.way.length for leg in asked)


def test_a_folder_that_cannot_be_written_is_said(walkable: Walkable, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot be written"):
        export_ground(tmp_path / "file", walkable, MARKS)
