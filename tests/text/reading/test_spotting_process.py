import subprocess
from collections.abc import Iterator
from multiprocessing.connection import Connection
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.errors import UserError
from lpslam.text.reading.spotting import PaddleSpotter, ReadsElsewhere
from lpslam.text.reading.spotting_process import SpottingProcess

CONFIG = SpottingConfig()

if not SpottingProcess.is_possible():
    pytest.skip("this system hands no channel to another Python", allow_module_level=True)


@pytest.fixture
def image() -> NDArray[np.uint8]:
    painted = np.full((240, 320, 3), 200, np.uint8)
    cv2.putText(painted, "Lisboa", (40, 130), cv2.FONT_HERSHEY_DUPLEX, 1.8, (20, 20, 90), 3, cv2.LINE_AA)
    return painted


@pytest.fixture(scope="module")
def spotter() -> Iterator[SpottingProcess]:
    """Shared by those that leave it as it was."""
    with SpottingProcess(CONFIG) as process:
        yield process


def test_it_reads_what_a_reader_in_this_process_reads(spotter: SpottingProcess, image: NDArray[np.uint8]) -> None:
    here = PaddleSpotter(CONFIG)
    boxes, scores = spotter.detect(image)
    own_boxes, own_scores = here.detect(image)
    assert len(boxes) == 1
    assert np.array_equal(boxes, own_boxes)
    assert np.array_equal(scores, own_scores)
    assert spotter.recognise(image, boxes) == here.recognise(image, boxes)
    assert spotter.recognise(image[:, ::-1], boxes) == here.recognise(image[:, ::-1], boxes), "a view of an image"


def test_one_that_dies_is_started_again_until_it_is_given_up(
    image: NDArray[np.uint8], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lpslam.text.reading.spotting_process._MOST_STARTS", 2)
    with SpottingProcess(CONFIG) as process:
        expected, _ = process.detect(image)
        assert process._process is not None
        process._process.kill()
        with pytest.raises(RuntimeError, match="ended"):
            process.detect(image)
        assert np.array_equal(process.detect(image)[0], expected)
        process._process.kill()
        for _ in range(2):
            with pytest.raises(RuntimeError, match="ended"):
                process.detect(image)
        assert process._process is None, "given up after two"


def test_what_goes_wrong_on_one_image_is_said_and_the_next_is_read(
    spotter: SpottingProcess, image: NDArray[np.uint8]
) -> None:
    with pytest.raises(RuntimeError):
        spotter.detect(np.zeros((0, 0, 3), np.uint8))
    assert len(spotter.detect(image)[0]) == 1


def test_a_missing_engine_is_the_users_error() -> None:
    missing = CONFIG.model_copy(update={"engine": "no_such_engine"})
    with pytest.raises(UserError, match="not installed"), SpottingProcess(missing):
        pass


def test_it_counts_its_processor_time_and_ends_with_its_block(image: NDArray[np.uint8]) -> None:
    with SpottingProcess(CONFIG) as process:
        assert isinstance(process, ReadsElsewhere)
        process.detect(image)
        once = process.seconds_elsewhere
        assert 0.01 < once < 20.0
        process.detect(image)
        assert process.seconds_elsewhere > once
        running = process._process
        assert running is not None
    assert running.poll() is not None


def test_who_still_reads_when_the_block_is_left_starts_no_process(image: NDArray[np.uint8]) -> None:
    with SpottingProcess(CONFIG) as process:
        pass
    with pytest.raises(RuntimeError, match="ended"):
        process.detect(image)
    assert process._process is None


def test_a_start_that_is_broken_off_leaves_no_process(monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    def noted(*words: Any, **options: Any) -> "subprocess.Popen[bytes]":
        started.append(popen(*words, **options))
        return started[-1]

    def pressed(self: Connection) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr(subprocess, "Popen", noted)
    monkeypatch.setattr(Connection, "recv", pressed)
    with pytest.raises(KeyboardInterrupt), SpottingProcess(CONFIG):
        pass
    assert [each.returncode for each in started] != [None]


def test_a_process_that_has_proven_sound_may_be_started_again_as_often(
    image: NDArray[np.uint8], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As many deaths in a day of reading as else are too many are no reason to stop."""
    monkeypatch.setattr("lpslam.text.reading.spotting_process._PROVEN", 1)
    monkeypatch.setattr("lpslam.text.reading.spotting_process._MOST_STARTS", 2)
    with SpottingProcess(CONFIG) as process:
        for _ in range(2):
            assert len(process.detect(image)[0]) == 1
            assert process._process is not None
            process._process.kill()
            with pytest.raises(RuntimeError, match="ended"):
                process.detect(image)
        assert len(process.detect(image)[0]) == 1
