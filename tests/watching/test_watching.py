"""A run written down while it goes: what the files hold, and what happens when they cannot be written."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader

import lpslam
from command_line import Command
from lpslam import pipeline
from lpslam.ground.grid import FREE, OCCUPIED, UNKNOWN, Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session.pace import Pace
from lpslam.slam.state import EventKind, SlamEvent
from lpslam.sources.open import open_source
from lpslam.sources.writing.messages import json_schema
from lpslam.text.types import BoxFate, Landmark
from lpslam.watching import foxglove
from lpslam.watching.mcap_file import McapWatcher
from lpslam.watching.telling import TOPICS
from lpslam.watching.watchers import Watchers
from small_maps import CAMERA, small_map, with_floor

FRAMES = 24
HOSTILE = '</script><img src=x onerror=alert(1)> \u202e"}]} {0.__class__} ../../x\x00\n'


class Noting:
    """A watcher that keeps what it saw."""

    name = "noting"

    def __init__(self) -> None:
        self.steps: list[lpslam.Step] = []
        self.world: LanguageMap | None = None
        self.closed = 0

    def take(self, frame: Any, step: Any, session: Any) -> None:
        self.steps.append(step)

    def finish(self, world: LanguageMap) -> None:
        self.world = world

    def close(self) -> None:
        self.closed += 1


@pytest.fixture(scope="module")
def watched(walk: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Noting, LanguageMap]:
    """A folder with run.mcap (and run.rrd, where Rerun is installed), the steps, and the map."""
    folder = tmp_path_factory.mktemp("watched")
    source = open_source(walk, max_frames=FRAMES)
    noting = Noting()
    watchers: list[Any] = [McapWatcher(folder / "run.mcap", source.camera), noting]
    try:
        from lpslam.watching.rerun_file import RerunWatcher
    except ImportError:
        pass
    else:
        watchers.append(RerunWatcher(folder / "run.rrd", source.camera, HOSTILE))
    said: list[str] = []
    with Watchers(watchers, said.append) as all_of_them:
        world = pipeline.run(source, on_step=all_of_them.take)
        all_of_them.finish(world)
    assert said == []
    return folder, noting, world


def messages(path: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            found.setdefault(channel.topic, []).append(json.loads(message.data))
    return found


@pytest.mark.slow
def test_steps_bring_readings(watched: tuple[Path, Noting, LanguageMap]) -> None:
    _, noting, world = watched
    readings = [reading for step in noting.steps for reading in step.readings]
    assert len(readings) == world.statistics["reading"]["frames_read"] > 5
    boxes = sum(len(reading.boxes) for reading in readings)
    assert boxes == world.statistics["reading"]["boxes_detected"]
    # In step with tracking a frame's boxes come with it.
    assert all(reading.frame == step.index for step in noting.steps for reading in step.readings)
    assert noting.closed == 1
    assert noting.world is world


@pytest.mark.slow
def test_the_file_holds_the_run(watched: tuple[Path, Noting, LanguageMap]) -> None:
    folder, noting, world = watched
    found = messages(folder / "run.mcap")
    assert len(found["/camera/color/image/compressed"]) == FRAMES
    assert len(found["/pose"]) == len(found["/tf"]) == sum(step.pose is not None for step in noting.steps)
    assert found["/pose"][0]["frame_id"] == "map"
    last, told = noting.steps[-1].pose, found["/pose"][-1]["pose"]["position"]
    assert last is not None
    assert np.allclose(last[:3, 3], [told["x"], told["y"], told["z"]])
    names = [entity["texts"][0]["text"] for entity in found["/landmarks"][-1]["entities"]]
    assert sorted(names) == sorted(mark.name for mark in world.landmarks()) != []
    fates = Counter(fate for step in noting.steps for reading in step.readings for fate in reading.fates)
    assert sum(len(each["points"]) for each in found["/camera/color/boxes"]) == fates.total()
    kept = sum(len(reading.texts) for step in noting.steps for reading in step.readings)
    assert sum(len(each["texts"]) for each in found["/camera/color/boxes"]) == kept > 0
    assert found["/points"][-1]["point_stride"] == 12
    assert len(found["/way"][-1]["entities"][0]["lines"][0]["points"]) == len(world.frame_poses())
    assert any("initialised" in each["message"] for each in found["/events"])


def sign(name: str) -> Landmark:
    return Landmark(
        7000, name, {name: 1}, np.array([1.0, 2.0, 3.0]), np.array([0.0, -1.0, 0.0]), 0.02, 0.8, 0.2, 3, 0.7,
    )  # fmt: skip


def misfits(value: Any, schema: dict[str, Any], where: str = "") -> list[str]:
    """Fields that are not in a schema, missing from it, or of another type."""
    kind = schema["type"]
    if kind == "object":
        fields = schema["properties"]
        wrong = [f"{where}.{key} is unknown" for key in value if key not in fields]
        return wrong + [each for key in value if key in fields for each in misfits(value[key], fields[key], key)]
    if kind == "array":
        return [each for item in value for each in misfits(item, schema["items"], where)]
    types: dict[str, Any] = {"string": str, "integer": int, "number": (int, float), "boolean": bool}
    return [] if isinstance(value, types[kind]) else [f"{where} is {type(value).__name__}, no {kind}"]


def test_messages_follow_their_schemas() -> None:
    world = with_floor(small_map())
    grid = world.grid()
    assert grid is not None
    event = SlamEvent(EventKind.LOST, 3, 0.1, "too dark")
    shown = {
        "foxglove.CompressedImage": foxglove.image(np.zeros((4, 4, 3), np.uint8), 5),
        "foxglove.CameraCalibration": foxglove.calibration(CAMERA, 5),
        "foxglove.PoseInFrame": foxglove.pose(np.eye(4), 5),
        "foxglove.FrameTransform": foxglove.transform(np.eye(4), 5),
        "foxglove.SceneUpdate": foxglove.landmarks(world.landmarks(), 5),
        "foxglove.PointCloud": foxglove.points(world.cloud(), 5),
        "foxglove.Grid": foxglove.ground(grid, 5),
        "foxglove.Log": foxglove.event(event, 5),
    }
    assert set(shown) | {"foxglove.ImageAnnotations"} == set(TOPICS.values())
    for name, message in shown.items():
        assert misfits(message, json_schema(name, foxglove.SCHEMAS[name])) == [], name
    way = foxglove.way(np.array([[0.0, 0, 0], [np.nan, 0, 0], [1.0, 0, 0]]), 5)
    assert misfits(way, json_schema("", foxglove.SCHEMAS["foxglove.SceneUpdate"])) == []
    assert len(way["entities"][0]["lines"][0]["points"]) == 2


def test_ground_is_told_apart() -> None:
    grid = Grid(np.array([[FREE, OCCUPIED, UNKNOWN]], np.int8), (1.0, 2.0), 0.05)
    told = foxglove.ground(grid, 0)
    assert told["data"] == "AQIA"
    assert told["pose"]["position"] == {"x": 1.0, "y": 2.0, "z": 0.0}


def test_hostile_signs_stay_text() -> None:
    update = json.loads(json.dumps(foxglove.landmarks([sign(HOSTILE)], 1), ensure_ascii=False).encode())
    (entity,) = update["entities"]
    assert entity["id"] == "7000"
    text = entity["texts"][0]["text"]
    assert text.isprintable()
    assert text.startswith("</script><img src=x onerror=alert(1)>")
    assert json.dumps(foxglove.landmarks([sign("\ud800 x")], 1), ensure_ascii=False).encode()


def test_every_fate_has_a_colour() -> None:
    assert set(foxglove.FATE_COLOURS) == set(BoxFate)


def test_a_pace_goes_by_the_runs_clock() -> None:
    pace = Pace(2.0)
    assert [pace.is_due(at) for at in (0.0, 1.0, 1.9, 2.0, 3.0, 9.0)] == [True, False, False, True, False, True]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_ends_the_file_and_not_the_run(walk: Path) -> None:
    source, said, noting = open_source(walk, max_frames=12), list[str](), Noting()
    with Watchers([McapWatcher(Path("/dev/full"), source.camera), noting], said.append) as watchers:
        world = pipeline.run(source, text=False, on_step=watchers.take)
        watchers.finish(world)
    assert len(noting.steps) == 12 == world.trajectory.tracked_count
    assert said[0] == "/dev/full ends here, mapping goes on: No space left on device"


@pytest.mark.slow
def test_a_run_that_is_killed_leaves_a_readable_file(walk: Path, tmp_path: Path) -> None:
    path = tmp_path / "killed.mcap"
    command = [sys.executable, "-m", "lpslam", "run", str(walk), "-o", str(tmp_path / "m.lpmap"), "--no-text"]
    run = subprocess.Popen([*command, "--mcap", str(path)], stderr=subprocess.DEVNULL)
    until = time.monotonic() + 60
    while (not path.exists() or path.stat().st_size < 1 << 20) and time.monotonic() < until and run.poll() is None:
        time.sleep(0.01)
    os.kill(run.pid, signal.SIGKILL)
    run.wait()
    frames = 0
    with path.open("rb") as file:
        try:
            for _, channel, _ in NonSeekingReader(file).iter_messages(log_time_order=False):
                frames += channel.topic == "/camera/color/image/compressed"
        except (McapError, EOFError):
            pass  # the last piece is not whole
    assert frames >= 5


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--mcap", "{missing}/run.mcap"), "does not exist; make it first"),
        (("--mcap", "{there}"), "is there already"),
        (("--mcap", "{out}"), "is another file of this run"),
        (("--mcap", "{new}", "--rerun", "{new}"), "is another file of this run"),
    ],
)
def test_mistakes_are_one_line(
    lpslam: Command, walk: Path, tmp_path: Path, options: tuple[str, ...], expected: str
) -> None:
    (tmp_path / "there.mcap").write_text("kept")
    names = {"missing": tmp_path / "no", "there": tmp_path / "there.mcap", "out": tmp_path / "m.lpmap"}
    given = [each.format(new=tmp_path / "new", **names) for each in options]
    assert expected in lpslam("run", walk, "-o", tmp_path / "m.lpmap", *given).complaint
    assert (tmp_path / "there.mcap").read_text() == "kept"


def test_without_rerun_the_extra_is_named(
    lpslam: Command, walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import importlib.util

    find: Callable[..., Any] = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == "rerun" else find(name, *rest))
    done = lpslam("run", walk, "-o", tmp_path / "m.lpmap", "--rerun", tmp_path / "run.rrd")
    assert done.complaint == "--rerun needs an optional part: pip install 'lp-slam[rerun]'"


@pytest.mark.slow
def test_rerun_can_read_its_file(watched: tuple[Path, Noting, LanguageMap], tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    program = Path(sys.executable).with_name("rerun")
    if not program.exists():
        pytest.skip("the program rerun is not beside Python")
    folder = watched[0]
    # Its program would send how it is used.
    environment = {**os.environ, "HOME": str(tmp_path), "XDG_CONFIG_HOME": str(tmp_path)}

    def call(*words: object) -> str:
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, env=environment, timeout=120)
        assert done.returncode == 0, done.stderr
        return done.stdout + done.stderr

    call("analytics", "disable")
    assert "1 file verified without error" in call("rrd", "verify", folder / "run.rrd")
    stats = call("rrd", "stats", folder / "run.rrd")
    for entity in ("/map/camera/image", "/map/camera/image/boxes", "/map/landmarks", "/map/points", "/tracking/events"):
        assert f"{entity}:" in stats
