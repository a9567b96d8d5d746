"""A walk past a few shops, rendered once, and the map of it: what the tests of the whole path share."""

import fcntl
import gc
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import pytest
from hypothesis import settings

from command_line import Command, command_line
from in_chromium import chromium
from lpslam import pipeline
from lpslam.config import SimulationConfig
from lpslam.frames import RgbdFrame
from lpslam.language.offline import OfflineModel
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session import parts
from lpslam.simulation.source import GroundTruth, MallSource
from lpslam.simulation.writer import write_sequence
from lpslam.slam import warm_up as warming
from lpslam.slam.warm_up import warm_up
from lpslam.sources import open as opening
from lpslam.sources.open import open_source
from lpslam.text.reading import networks
from lpslam.text.reading.spotting import PaddleSpotter
from remembered_checks import RememberedChecks
from remembered_readings import RememberingSpotter

FRAMES = 120
BEGINNING = 30
"""Frames from the beginning of the walk, in which signs become landmarks."""

# The same examples every time, and as long as they take: a test run says something about the code, not about the dice
# or the machine. `--hypothesis-profile explore` throws new ones.
settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None, max_examples=1000)
settings.load_profile("repeatable")


_COMPILED_FIRST = (
    "from lpslam.slam.warm_up import warm_up; warm_up(lambda line: None)",
    "from lpslam.config import SimulationConfig; from lpslam.simulation.source import MallSource;"
    "mall = MallSource(7, 2, options=SimulationConfig(loop_length=26.0)); mall.frame(1), mall.sign_views",
)


def pytest_configure(config: pytest.Config) -> None:
    """Has the kernels compiled before there are workers: each would else compile all of them for itself."""
    cv2.setNumThreads(1)
    gc.disable()
    if getattr(config.option, "numprocesses", None) and not hasattr(config, "workerinput"):
        compiling = [subprocess.Popen([sys.executable, "-c", code]) for code in _COMPILED_FIRST]
        for each in compiling:
            each.wait()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Of two workers, which begin with a half each, one makes the walk and its map while the other does without.

    What takes long comes first in either half: at the end, when one steals from the other, what is left is short.
    """
    walking = [item for item in items if "walk" in getattr(item, "fixturenames", ())]
    others = [item for item in items if "walk" not in getattr(item, "fixturenames", ())]
    slow = [item for item in others if item.get_closest_marker("slow") is not None]
    quick = [item for item in others if item.get_closest_marker("slow") is None]
    before = max(len(items) // 2 - len(slow), 0)
    items[:] = [*slow, *quick[:before], *walking, *quick[before:]]


def pytest_collection_finish() -> None:
    """What is loaded and collected stays: the collector need not go through it again and again."""
    gc.freeze()
    gc.enable()


_BY_FRAME = ("letter_pixels", "angle", "distance", "blur_pixels", "inside", "seen_share")


class _EverySecondFrame:
    """Half of a walk's frames: drawing them is what costs the time."""

    faults = ()

    def __init__(self, walk: MallSource) -> None:
        self._walk = walk
        self.name, self.camera, self.signs = walk.name, walk.camera, walk.signs
        truth = walk.ground_truth
        self.ground_truth = GroundTruth(truth.timestamps[::2], truth.world_from_camera[::2])
        self.sign_views = [
            replace(each, **{name: getattr(each, name)[::2] for name in _BY_FRAME}) for each in walk.sign_views
        ]

    def __len__(self) -> int:
        return len(self.ground_truth.timestamps)

    def __iter__(self) -> Iterator[RgbdFrame]:
        for index in range(len(self)):
            yield replace(self._walk.frame(2 * index), index=index)


@pytest.fixture(scope="session", autouse=True)
def networks_compiled_once() -> Iterator[None]:
    """Each process compiles a network once; every spotter has requests of its own to it."""
    compiled_model = networks.compiled_model
    networks.compiled_model = cache(compiled_model)
    yield
    networks.compiled_model = compiled_model


@pytest.fixture(scope="session", autouse=True)
def words_of_signs_listed_once() -> Iterator[None]:
    """Embedded models of this process, of which each command makes one, share what names are compared with."""
    begin, namer = OfflineModel.__init__, OfflineModel().namer

    def begin_with_the_same_namer(self: OfflineModel) -> None:
        begin(self)
        self.namer = namer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(OfflineModel, "__init__", begin_with_the_same_namer)
        yield


@pytest.fixture(scope="session", autouse=True)
def read_once(shared: Path) -> Iterator[None]:
    """Sessions of this process read the same pixels once; commands in processes of their own read for themselves."""
    RememberingSpotter.folder = shared / "readings"
    RememberingSpotter.folder.mkdir(exist_ok=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts, "PaddleSpotter", RememberingSpotter)
        yield


@pytest.fixture(scope="session", autouse=True)
def checked_once(shared: Path) -> Iterator[None]:
    """The calibration of the same pictures is checked once; commands in processes of their own check for themselves."""
    folder = shared / "checks"
    folder.mkdir(exist_ok=True)
    remembered = RememberedChecks(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(opening, "pairs_of", remembered.pairs_of)
        patch.setattr(opening, "_doubts_about_registration", remembered.doubts_about_registration)
        yield


@pytest.fixture(scope="session", autouse=True)
def warmed_up_once() -> Iterator[None]:
    """Each process goes through the kernels once; commands in processes of their own do so for themselves."""
    done: list[float] = []

    def warm_up_unless_done(announce: Callable[[str], None]) -> float:
        if not done:
            done.append(warm_up(announce))
        return done[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(warming, "warm_up", warm_up_unless_done)
        yield


@pytest.fixture
def read_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """In this test every picture is read, however often it comes."""
    monkeypatch.setattr(parts, "PaddleSpotter", PaddleSpotter)


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of all workers."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


Once = Callable[[str, Callable[[Path], object]], Path]


@pytest.fixture(scope="session")
def once(shared: Path) -> Once:
    """Makes a folder of the session, by name, in whichever process asks first: the others wait for it."""

    def made(name: str, make: Callable[[Path], object]) -> Path:
        folder = shared / name
        with (shared / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not folder.exists():
                unfinished = shared / f"{name}.unfinished"
                shutil.rmtree(unfinished, ignore_errors=True)
                unfinished.mkdir()
                make(unfinished)
                unfinished.rename(folder)
        return folder

    return made


@pytest.fixture(scope="session")
def walk(once: Once) -> Path:
    """A TUM folder with ground truth and signs: eight seconds in a mock mall, 15 frames a second. Not to be changed."""
    return once("recording", _write_walk) / "walk"


def _write_walk(folder: Path) -> None:
    mall = MallSource(7, 2 * FRAMES, options=SimulationConfig(loop_length=26.0))
    write_sequence(_EverySecondFrame(mall), folder / "walk")


@pytest.fixture(scope="session")
def walked(walk: Path, once: Once) -> Path:
    """The map file of `walk`, mapped in sequential mode and not distilled. Not to be changed."""
    return once("map", lambda folder: pipeline.run(open_source(walk)).save(folder / "walk.lpmap")) / "walk.lpmap"


@pytest.fixture(scope="session")
def begun(walk: Path, once: Once) -> Path:
    """The map file of the beginning of `walk`, mapped in the same way. Not to be changed."""
    short = open_source(walk, max_frames=BEGINNING)
    return once("beginning", lambda folder: pipeline.run(short).save(folder / "begun.lpmap")) / "begun.lpmap"


@pytest.fixture
def world(walked: Path) -> LanguageMap:
    """The map of `walk`, fresh from disk."""
    return LanguageMap.load(walked)


@pytest.fixture
def clip(walk: Path, tmp_path: Path) -> Callable[[int], Path]:
    """Copies the first frames of `walk` to a folder that a test may damage."""

    def copy(frames: int) -> Path:
        folder = tmp_path / "clip"
        for name in ("rgb", "depth"):
            (folder / name).mkdir(parents=True)
            listed = [line for line in (walk / f"{name}.txt").read_text().splitlines() if not line.startswith("#")]
            (folder / f"{name}.txt").write_text("\n".join(listed[:frames]) + "\n")
            for line in listed[:frames]:
                shutil.copy(walk / line.split()[1], folder / name)
        for name in ("camera.yaml", "groundtruth.txt", "signs.json"):
            shutil.copy(walk / name, folder)
        return folder

    return copy


@pytest.fixture
def lpslam(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """The command line: `lpslam("info", map)`."""
    return command_line(monkeypatch, capsys)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """A browser for the tests of a module; they are skipped where there is none."""
    with chromium() as opened:
        yield opened
