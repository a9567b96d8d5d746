"""Ways in a building of several storeys: each on its own, and over stairs that were walked."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml

from lpslam.cli_ground import Guide
from lpslam.config import Config
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import ask
from lpslam.navigation.walking.exporting import export_storeys
from lpslam.navigation.walking.routes import building_of, route_through
from lpslam.navigation.walking.storeys import Building
from lpslam.navigation.walking.telling import Sign, told
from lpslam.navigation.walking.ways import NoWayError
from lpslam.poses import StampedPoses
from lpslam.text.types import Landmark
from small_maps import small_map, with_floor

CONFIG = Config()
CELL, EYES = 0.05, 1.4


def storey(number: int, floors: tuple[float, ...] = (0.0, 3.0), wall: float | None = None) -> Grid:
    """Eight metres square from (0, 0); a wall along y may divide it."""
    values = np.full((160, 160), FREE, np.int8)
    values[:1], values[-1:], values[:, :1], values[:, -1:] = (OCCUPIED,) * 4
    if wall is not None:
        values[:, round(wall / CELL) : round(wall / CELL) + 2] = OCCUPIED
    return Grid(values, (0.0, 0.0), CELL, storeys=floors, storey=number)


def carried(*corners: tuple[float, float, float]) -> np.ndarray:
    """Where the camera was (n, 3), every 10 cm of the way over places at which the floor has a height."""
    ways = [
        np.linspace(begin, end, round(10 * np.linalg.norm(np.subtract(end, begin))), endpoint=False)
        for begin, end in pairwise(corners)
    ]
    walked = np.concatenate([*ways, [corners[-1]]]) + np.array([0.0, 0.0, EYES])
    walked[:, 2] += 0.05 * np.sin(np.arange(len(walked)))
    return walked


STAIRS = carried((1.0, 1.0, 0.0), (2.0, 4.0, 0.0), (6.0, 4.0, 3.0), (7.0, 4.0, 3.0), (7.0, 7.0, 3.0))


def sign(id_: int, name: str, at: tuple[float, float, float], normal: tuple[float, float]) -> Landmark:
    return Landmark(id_, name, {name: 1}, np.array(at), np.array([*normal, 0.0]), 0.01, 1.0, 0.3, 5, 0.9)


KFC, BANK = sign(1, "KFC", (0.05, 6.0, 2.0), (1.0, 0.0)), sign(2, "Bank", (7.95, 2.0, 5.0), (-1.0, 0.0))


def test_a_way_leads_up_the_stairs_that_were_walked_and_down_again() -> None:
    building = Building([storey(0), storey(1)], STAIRS, CONFIG)
    up, down = route_through(np.array([1.0, 1.0, EYES]), [BANK, KFC], building)
    assert up.goal.is_before
    assert np.linalg.norm(up.way.points[0] - [1.0, 1.0]) < 0.06
    assert np.linalg.norm(up.way.points[-1] - up.goal.position) < 0.06
    (climb,) = up.way.climbs
    assert climb.storeys == 1
    stairs = up.way.points[climb.first : climb.last + 1]
    assert np.abs(stairs[:, 1] - 4.0).max() < 0.3
    assert stairs[0, 0] < 2.5
    assert stairs[-1, 0] > 5.5
    assert np.linalg.norm(np.diff(stairs, axis=0), axis=1).max() < 0.5
    assert np.linalg.norm(np.diff(up.way.points, axis=0), axis=1)[[climb.first - 1, climb.last]].max() < 5.0
    (climb,) = down.way.climbs
    assert climb.storeys == -1
    assert down.way.points[climb.first, 0] > 5.5
    assert down.goal.is_before


def test_it_is_told_where_to_go_up() -> None:
    building = Building([storey(0), storey(1)], STAIRS, CONFIG)
    (leg,) = route_through(np.array([1.0, 1.0, EYES]), [BANK], building)
    steps = told(leg.way, [], Sign("Bank", BANK.position), "en", heading=0.0)
    at = steps.index("go up to the next storey")
    assert any(step.startswith("go ") and step.endswith(" m") for step in steps[:at])
    assert any(step.startswith("go ") and step.endswith(" m") for step in steps[at + 1 :])
    # The stairs lead along x, and the bank hangs to their right.
    assert steps[at + 1] == "turn right"
    assert steps[-1] == "Bank is on your left"
    (back,) = route_through(np.array([7.0, 7.0, 3.0 + EYES]), [KFC], building)
    assert "eine Etage hinuntergehen" in told(back.way, [], Sign("KFC", KFC.position), "de")


def test_a_way_on_one_storey_goes_round_the_walls_of_that_storey_alone() -> None:
    parted = storey(1, wall=4.0)
    parted.values[140:158, 80:82] = FREE
    building = Building([storey(0), parted], STAIRS, CONFIG)
    bank = replace(BANK, position=np.array([7.95, 1.0, 5.0]))
    (above,) = route_through(np.array([1.0, 1.0, 3.0 + EYES]), [bank], building)
    (below,) = route_through(np.array([1.0, 1.0, EYES]), [replace(bank, position=np.array([7.95, 1.0, 2.0]))], building)
    assert above.way.climbs == below.way.climbs == ()
    assert below.way.length < 6.2
    assert above.way.length > 12.0


def test_of_two_stairs_the_nearer_one_is_taken() -> None:
    there_and_back = carried(
        (1.0, 1.0, 0.0), (1.0, 2.0, 0.0), (1.0, 7.0, 3.0), (7.0, 7.0, 3.0), (7.0, 1.5, 0.0), (6.5, 1.0, 0.0)
    )
    building = Building([storey(0), storey(1)], there_and_back, CONFIG)
    for x, middle in ((1.5, 1.0), (6.5, 7.0)):
        (leg,) = route_through(np.array([x, 1.0, EYES]), [sign(3, "Zoo", (4.0, 0.05, 5.0), (0.0, 1.0))], building)
        (climb,) = leg.way.climbs
        assert np.abs(leg.way.points[climb.first : climb.last + 1, 0] - middle).max() < 0.4


def test_a_storey_between_is_crossed() -> None:
    floors = (0.0, 3.0, 6.0)
    way = carried((1.0, 1.0, 0.0), (6.0, 1.0, 3.0), (7.0, 1.0, 3.0), (7.0, 7.0, 3.0), (2.0, 7.0, 6.0), (1.0, 7.0, 6.0))
    building = Building([storey(at, floors) for at in range(3)], way, CONFIG)
    (leg,) = route_through(np.array([1.0, 1.0, EYES]), [sign(3, "Zoo", (0.05, 4.0, 8.0), (1.0, 0.0))], building)
    assert [climb.storeys for climb in leg.way.climbs] == [1, 1]
    assert leg.way.climbs[0].last < leg.way.climbs[1].first
    with pytest.raises(NoWayError, match="2 storeys higher"):
        route_through(np.array([1.0, 1.0, EYES]), [sign(3, "Zoo", (0.05, 4.0, 8.0), (1.0, 0.0))], building.grounds[0])


def test_without_stairs_it_is_said_how_far_up_the_sign_hangs() -> None:
    lift = np.concatenate([carried((1.0, 1.0, 0.0), (3.0, 1.0, 0.0)), np.full((1, 3), np.nan)])
    building = Building([storey(0), storey(1)], lift, CONFIG)
    assert building.passages == []
    with pytest.raises(NoWayError, match="1 storey higher, and no way there is known"):
        route_through(np.array([1.0, 1.0, EYES]), [BANK], building)


def test_stairs_to_which_no_way_was_seen_are_told() -> None:
    building = Building([storey(0, wall=1.5), storey(1)], STAIRS[20:], CONFIG)
    with pytest.raises(NoWayError, match="map the way between"):
        route_through(np.array([0.6, 1.0, EYES]), [BANK], building)


def test_a_camera_that_is_raised_and_lowered_climbs_no_stairs() -> None:
    held = carried((1.0, 1.0, 0.0), (7.0, 1.0, 0.0))
    held[20:40, 2] += 0.8
    assert Building([storey(0), storey(1)], held, CONFIG).passages == []


def test_each_storey_has_files_of_its_own(tmp_path: Path) -> None:
    above = storey(1)
    above.values[:80] = UNKNOWN
    building = Building([storey(0), above], STAIRS, CONFIG)
    legs = route_through(np.array([1.0, 1.0, EYES]), [KFC], building)
    written = export_storeys(tmp_path, building, [KFC, BANK], warnings=[BANK], legs=legs)
    assert all(path.is_file() for path in written)
    names = {path.name for path in written}
    assert {"map.yaml", "map.pgm", "waypoints.yaml", "floor_plan.svg", "route.yaml"} <= names
    assert sorted(path.parent.name for path in written if path.name == "map.yaml") == ["storey_0", "storey_1"]
    assert [path.parent.name for path in written if path.name == "route.yaml"] == ["storey_0"]
    below, over = ((tmp_path / f"storey_{number}" / "map.pgm").read_bytes() for number in (0, 1))
    assert below != over
    for number, own, other in ((0, "KFC", "Bank"), (1, "Bank", "KFC")):
        plan = (tmp_path / f"storey_{number}" / "floor_plan.svg").read_text()
        assert own in plan
        assert other not in plan
    assert [
        each["name"] for each in yaml.safe_load((tmp_path / "storey_0" / "waypoints.yaml").read_text())["waypoints"]
    ] == ["KFC"]
    # A warning above keeps no robot out below.
    keepout = {number: (tmp_path / f"storey_{number}" / "keepout.pgm").read_bytes() for number in (0, 1)}
    assert b"\x00" not in keepout[0].partition(b"255\n")[2]
    assert b"\x00" in keepout[1].partition(b"255\n")[2]


def test_of_a_map_of_two_storeys_people_are_led_up_and_robots_are_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    world = with_floor(small_map(["Library"], source="two storeys"))
    monkeypatch.setattr(LanguageMap, "grids", lambda self, config: [storey(0), storey(1)])
    poses = np.tile(np.eye(4), (len(STAIRS), 1, 1))
    poses[:, :3, 3] = STAIRS
    monkeypatch.setattr(LanguageMap, "frame_poses", lambda self: StampedPoses(np.arange(len(poses)) / 10.0, poses))
    monkeypatch.setattr(LanguageMap, "landmarks", lambda self: [replace(BANK, name="Library")])
    answer = ask(world, "Where is the library?", position=np.array([1.0, 1.0]))
    assert answer.here[2] > 3.0, "the map ends above"
    answer = ask(world, "Where is the library?", position=np.array([1.0, 1.0, EYES]))
    guide = Guide(world, CONFIG)
    (leg,) = guide.record(answer)["route"]
    ((_, _, storeys),) = leg["climbs"]
    assert storeys == 1
    assert "go up to the next storey" in guide.said(answer)
    written = guide.ready_to_export()(tmp_path)
    assert {path.parent.name for path in written} == {"storey_0", "storey_1"}
    with pytest.raises(NoWayError, match="1 storey higher"):
        route_through(answer.here, [BANK], building_of(world, CONFIG).ground_at(answer.here))


def test_a_map_of_one_storey_has_its_files_beside_each_other(tmp_path: Path) -> None:
    building = Building([replace(storey(0), storeys=())], STAIRS, CONFIG)
    assert {path.parent for path in export_storeys(tmp_path, building, [KFC])} == {tmp_path}
