"""Devices and pipes where files should be, and files without end: one line, at once."""

import os
from pathlib import Path

import pytest

from command_line import Command
from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.evaluation.signs import read_signs
from lpslam.mapfile.container import read_manifest, refuse_foreign_file
from lpslam.poses import StampedPoses
from lpslam.regular_files import bytes_of, text_of
from lpslam.serving.tokens import read_tokens
from lpslam.simulation.boards.labels import read_labelled

READERS = {
    "map": read_manifest,
    "map to write": refuse_foreign_file,
    "configuration": Config.from_yaml,
    "trajectory": StampedPoses.from_tum_file,
    "signs": read_signs,
    "tokens": read_tokens,
    "text": text_of,
}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS)
def test_a_pipe_or_a_device_is_refused_at_once(tmp_path: Path, read: object) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "device").symlink_to("/dev/zero")
    for name in ("pipe", "device"):
        with pytest.raises(UserError, match="no file but a device or a pipe"):
            read(tmp_path / name)  # type: ignore[operator]


def test_labels_of_boards_are_no_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "labels.json")
    with pytest.raises(UserError, match="no file but a device or a pipe"):
        read_labelled(tmp_path)


def test_what_is_longer_than_any_such_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_text("a" * 1000)
    assert text_of(path) == "a" * 1000
    os.truncate(path, 1 << 40)
    with pytest.raises(UserError, match="more than 64 MB"):
        bytes_of(path)


@pytest.mark.parametrize("command", ["info", "distill", "draw", "export", "ask", "correct"])
def test_every_command_refuses_a_map_that_is_a_pipe(lpslam: Command, tmp_path: Path, command: str) -> None:
    os.mkfifo(tmp_path / "map.lpmap")
    more = {"draw": ["map.png"], "export": ["exported"], "ask": ["pizza"], "correct": ["1", "--hide"]}
    said = lpslam(command, tmp_path / "map.lpmap", *more.get(command, [])).complaint
    assert "no file but a device or a pipe" in said


@pytest.mark.parametrize("option", ["--output", "--trajectory", "--continue", "SOURCE"])
def test_links_that_lead_around_are_one_line(lpslam: Command, walk: Path, tmp_path: Path, option: str) -> None:
    loop = tmp_path / "loop.lpmap"
    loop.symlink_to(loop)
    given = {"SOURCE": walk, "--output": tmp_path / "map.lpmap", "--trajectory": tmp_path / "poses.txt"} | {
        option: loop
    }
    words = [word for name, path in given.items() for word in (name, path) if word != "SOURCE"]
    done = lpslam("run", *words, "--max-frames", "1", "--no-text")
    assert done.code in (0, 2)
    assert done.code == 0 or done.err.splitlines()[-1].startswith("lpslam: ")


def test_poses_do_not_wait_for_who_reads_a_pipe(lpslam: Command, walk: Path, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    said = lpslam("run", walk, "-o", tmp_path / "map.lpmap", "--trajectory", tmp_path / "pipe").complaint
    assert "a device or a pipe" in said
