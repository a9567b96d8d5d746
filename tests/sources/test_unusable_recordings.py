"""Recordings that hold nothing to map: `lpslam run` ends with one clear line and exit code 2, and leaves no map."""

from pathlib import Path

import pytest
from bag_writers import KINDS, walk, write

from command_line import Command


def refused(lpslam: Command, recording: Path) -> str:
    output = recording.parent / "refused.lpmap"
    complaint = lpslam("run", recording, "-o", output, "--no-text").complaint
    assert not list(recording.parent.glob("*refused*"))
    return complaint


def test_a_camera_that_is_not_known(lpslam: Command, tmp_path: Path) -> None:
    complaint = lpslam("run", "oak:", "-o", tmp_path / "refused.lpmap").complaint
    assert complaint == "oak: is no camera; there are realsense:"


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_without_depth(lpslam: Command, tmp_path: Path, kind: str) -> None:
    bag = write(tmp_path / f"walk.{kind}", lambda types: walk(types, depth=False))
    assert "has colour (/camera/color/image_raw) but no depth" in refused(lpslam, bag)


@pytest.mark.parametrize("kind", [*KINDS, "sens", "r3d"])
def test_an_empty_file(lpslam: Command, tmp_path: Path, kind: str) -> None:
    empty = tmp_path / f"walk.{kind}"
    empty.touch()
    refused(lpslam, empty)


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_cut_off_before_its_first_picture(lpslam: Command, tmp_path: Path, kind: str) -> None:
    bag = write(tmp_path / f"walk.{kind}", walk)
    bag.write_bytes(bag.read_bytes()[:1500])
    done = lpslam("run", bag, "-o", tmp_path / "refused.lpmap", "--no-text")
    assert (done.code, done.out) == (2, "")
    *notes, complaint = done.err.splitlines()
    assert "can be read" in complaint
    assert all("is cut off or damaged" in note for note in notes), "where it ends may be said before"
    assert len(notes) <= 1
    assert not list(tmp_path.glob("*refused*"))
