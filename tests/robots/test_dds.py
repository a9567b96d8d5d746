"""Over DDS, in two processes: a robot's driver and listener here, `lpslam robot` there."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("cyclonedds")

import lpslam
from command_line import Command
from lpslam.ground.grid import Grid
from lpslam.mapfile.language_map import LanguageMap
from lpslam.robots import building, dds, types
from lpslam.robots.dds import DdsBus
from lpslam.sources.open import open_source
from robots.robot_parts import COLOUR, DEPTH, INFO, calibration, pictures

# Domains of this file alone, one for each process that may run it at once.
DOMAIN = 100 + os.getpid() % 100
LONGEST = 90.0


class Heard(list[Any]):
    """Messages of a topic."""

    def __init__(self, bus: DdsBus, topic: str, kind: str, **options: Any) -> None:
        super().__init__()
        self._came = threading.Event()
        self._kind = kind
        bus.subscribe(topic, kind, self._take, **options)

    def _take(self, data: bytes) -> None:
        self.append(types.decoded(data, self._kind))
        self._came.set()

    def wait(self, seconds: float) -> bool:
        return self._came.wait(seconds)


def test_messages_and_services_go_through() -> None:
    bus = DdsBus(DOMAIN)
    try:
        heard = Heard(bus, "/picture", types.IMAGE, reliable=True)
        late_send = bus.publisher("/grid", types.GRID, latched=True)
        late_send(building.occupancy_grid(Grid(np.zeros((3, 4), np.int8), (0.0, 0.0), 0.05), 5, "map"))
        late = Heard(bus, "/grid", types.GRID, latched=True)
        send = bus.publisher("/picture", types.IMAGE)
        rgb = np.random.default_rng(0).integers(0, 255, (480, 640, 3), np.uint8)
        until = time.monotonic() + 10
        while not heard and time.monotonic() < until:
            send(building.picture(rgb, 7, "camera"))
            heard.wait(0.5)
        assert np.array_equal(heard[0].data.reshape(rgb.shape), rgb)
        assert late.wait(5), "who comes late gets the last grid"
        assert (late[0].info.width, late[0].info.height) == (4, 3)
        bus.serve("/broken", types.ASK, lambda request: 1 / 0)
        broken = bus.client("/broken", types.ASK)
        assert broken(types.made(types.request_of(types.ASK), "?"), 0.5) is None
        nobody = bus.client("/nobody", types.ASK)
        assert nobody(types.made(types.request_of(types.ASK), "?"), 0.2) is None
    finally:
        bus.close()


def test_bytes_that_are_no_message_end_nothing() -> None:
    bus = DdsBus(DOMAIN)
    try:
        came: list[bytes] = []
        bus.subscribe("/hostile", types.POSE, came.append, reliable=True)
        send = bus.publisher("/hostile", types.POSE)
        write = bus._writer(types.dds_topic("/hostile"), dds._raw(types.POSE), False)
        good = building.pose_stamped(np.eye(4), 9, "map")
        until = time.monotonic() + 10
        while not came and time.monotonic() < until:
            for bad in (b"", b"\x00", b"\x00\x01\x00\x00" + b"\xff" * 40, os.urandom(64)):
                write(bad)
            send(good)
            time.sleep(0.1)
        assert types.encoded(good) in [each[: len(types.encoded(good))] for each in came]
    finally:
        bus.close()


def test_nothing_comes(lpslam: Command) -> None:
    complaint = lpslam("robot", "--domain", DOMAIN, "--wait", "0.5", "--color", "/my/picture").err.splitlines()[-1]
    assert "no frame came within 0.5 s: nothing came on" in complaint
    assert "/my/picture" in complaint


@pytest.mark.parametrize("options", [("--color", "/"), ("--output", "/nowhere/at/all.lpmap"), ("--domain", "9999")])
def test_mistakes_are_one_line(lpslam: Command, options: tuple[str, ...]) -> None:
    done = lpslam("robot", *options, "--wait", "0.2")
    assert done.code == 2


@pytest.mark.slow
def test_two_processes(walk: Path, tmp_path: Path) -> None:
    output = tmp_path / "robot.lpmap"
    overrides = tmp_path / "robot.yaml"
    overrides.write_text("robots: {reliable: true, grid_s: 1.0}\n")
    command = [
        *(sys.executable, "-m", "lpslam", "robot", "--domain", str(DOMAIN), "--no-text", "--config", str(overrides)),
        *("-o", str(output), "--max-frames", "40", "--seconds", str(LONGEST), "--wait", str(LONGEST)),
    ]
    bus = DdsBus(DOMAIN)
    node = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        poses = Heard(bus, "/lpslam/pose", types.POSE, reliable=True)
        transforms = Heard(bus, "/tf", types.TRANSFORMS, reliable=True)
        markers = Heard(bus, "/lpslam/markers", types.MARKERS, latched=True)
        grids = Heard(bus, "/lpslam/grid", types.GRID, latched=True)
        ask = bus.client("/lpslam/ask", types.ASK)
        answer = _drive(bus, walk, node, poses, ask)
        out, err = node.communicate(timeout=30)
        assert node.returncode == 0, err
        assert "40" in out
        assert answer is not None
        assert not answer.found
        assert answer.text
        assert len(poses) > 30
        assert transforms[0].transforms[0].header.frame_id == "map"
        assert markers.wait(1)
        world = LanguageMap.load(output)
        grid = world.grid()
        assert bool(grids) == (grid is not None)
        last, told = world.frame_poses().positions[-1], poses[-1].pose.position
        assert np.allclose(last, [told.x, told.y, told.z], atol=0.1)
    finally:
        node.kill()
        node.wait()
        bus.close()


def _drive(bus: DdsBus, walk: Path, node: "subprocess.Popen[str]", poses: Heard, ask: Any) -> Any:
    """Publish the walk slowly, again and again with new times, until the node has enough; and ask once meanwhile."""
    kinds = {INFO: types.CAMERA_INFO, COLOUR: types.IMAGE, DEPTH: types.IMAGE}
    send = {topic: bus.publisher(topic, kind) for topic, kind in kinds.items()}
    source = open_source(walk)
    frames = list(source)[:60]
    until, answer = time.monotonic() + LONGEST, None
    order = [*frames, *frames[::-1]]  # there and back: no jump
    for number in range(10**6):
        if node.poll() is not None or time.monotonic() > until:
            break
        # The camera stands still until somebody listens.
        frame = order[len(poses) % len(order)]
        shown = lpslam.RgbdFrame(number, 1000.0 + number / 10, frame.rgb, frame.depth)
        for topic, message in (calibration(source.camera, number), *pictures(shown)):
            send[topic](message)
        time.sleep(0.08)
        if len(poses) > 15 and answer is None:
            answer = ask(types.made(types.request_of(types.ASK), "Where can I eat pizza?"), 10.0)
    return answer
