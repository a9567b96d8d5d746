"""Files written whole or not at all, and places that are refused before the work."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import Command
from lpslam.errors import UserError
from lpslam.poses import StampedPoses
from lpslam.whole_files import refuse_unwritable, refuse_unwritable_folder, written_whole


def in_it(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def broken_off(path: Path, failure: BaseException, **how: Any) -> None:
    with written_whole(path, **how) as part:
        part.write_text("half")
        raise failure


@pytest.mark.parametrize("failure", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_what_fails_leaves_what_was_there(tmp_path: Path, failure: BaseException) -> None:
    (tmp_path / "map").write_text("old")
    with pytest.raises((UserError, KeyboardInterrupt)):
        broken_off(tmp_path / "map", failure)
    assert (tmp_path / "map").read_text() == "old"
    assert in_it(tmp_path) == ["map"]


def test_two_writers_of_one_name_do_not_mix(tmp_path: Path) -> None:
    with written_whole(tmp_path / "map") as first, written_whole(tmp_path / "map") as second:
        first.write_text("first")
        second.write_text("second")
    assert (tmp_path / "map").read_text() == "first", "the last to end"
    assert in_it(tmp_path) == ["map"]


def test_what_a_killed_writer_left_is_removed_at_the_next_start(tmp_path: Path) -> None:
    script = (
        "import os, signal, sys, pathlib; from lpslam.whole_files import written_whole\n"
        "folder = pathlib.Path(sys.argv[1])\n"
        "with written_whole(folder / 'map') as part, written_whole(folder / 'bag', kept=folder / 'rest') as kept:\n"
        "    part.mkdir()\n"
        "    (part / 'half').write_text('half')\n"
        "    kept.write_text('cannot be had again')\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    subprocess.run([sys.executable, "-c", script, str(tmp_path)], check=False)
    left, foreign, linked = in_it(tmp_path), ".lpslam-1-0123456789abcdef.part", ".lpslam-1-01234567.part"
    assert sorted(Path(name).suffix for name in left) == [".kept", ".part"]
    (tmp_path / foreign).write_text("of another machine")
    (tmp_path / linked).symlink_to(foreign)
    with written_whole(tmp_path / "map") as part:
        part.write_text("being written")
        refuse_unwritable(tmp_path / "map")
        assert part.exists(), "its writer is alive"
    gone = next(name for name in left if name.endswith(".part"))
    assert in_it(tmp_path) == sorted({*left, foreign, linked, "map"} - {gone})
    os.utime(tmp_path / foreign, (0, 0))
    refuse_unwritable_folder(tmp_path / "new")
    assert foreign not in in_it(tmp_path), "nobody has written it for a day"


def test_of_a_link_what_it_leads_to_is_replaced(tmp_path: Path) -> None:
    (tmp_path / "disk").mkdir()
    (tmp_path / "disk" / "real").write_text("old")
    (tmp_path / "link").symlink_to("disk/real")
    with written_whole(tmp_path / "link") as part:
        part.write_text("new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "disk" / "real").read_text() == "new"


def test_a_part_that_cannot_be_had_again_is_kept(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="it is beside"):
        broken_off(tmp_path / "a", OSError(28, "full"), remedy="it is beside", kept=tmp_path / "b")
    assert in_it(tmp_path) == ["b"]


def test_places_where_nothing_can_be_written(tmp_path: Path) -> None:
    refuse_unwritable(tmp_path / "new")
    refuse_unwritable_folder(tmp_path / "a" / "b")
    assert in_it(tmp_path) == [], "trying leaves nothing"
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to("loop")
    os.mkfifo(tmp_path / "pipe")
    for name, said in {
        ".": "it is a folder",
        "none/map": "does not exist; make it first",
        "file/map": "does not exist; make it first",
        "pipe": "no file but a device or a pipe",
        "loop": "Too many levels",
        "x" * 300: "too long",
    }.items():
        with pytest.raises(UserError, match=said):
            refuse_unwritable(tmp_path / name, "map")
    with pytest.raises(UserError, match="is no folder"):
        refuse_unwritable_folder(tmp_path / "file" / "below")


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no folder that takes no files, whoever asks")
def test_a_system_of_files_that_takes_none_is_found_by_trying(tmp_path: Path) -> None:
    """Permissions let the administrator write there."""
    with pytest.raises(UserError, match="cannot be written"):
        refuse_unwritable(Path("/proc/map.lpmap"))
    with pytest.raises(UserError, match="cannot be written"):
        refuse_unwritable_folder(Path("/proc/a/b"))


def test_poses_of_a_full_disk_do_not_cut_the_old_ones_short(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk."""
    poses = StampedPoses(np.arange(100.0), np.tile(np.eye(4), (100, 1, 1)))
    poses.to_tum_file(tmp_path / "poses.txt")
    whole = (tmp_path / "poses.txt").read_text()
    script = (
        "import resource, signal, sys, pathlib; from lpslam.poses import StampedPoses;"
        "path = pathlib.Path(sys.argv[1]);"
        "poses = StampedPoses.from_tum_file(path); signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)); poses.to_tum_file(path)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(tmp_path / "poses.txt")], capture_output=True, text=True, check=False
    )
    assert "UserError" in done.stderr
    assert (tmp_path / "poses.txt").read_text() == whole
    assert in_it(tmp_path) == ["poses.txt"]


def test_converting_refuses_before_the_work(lpslam: Command, clip: Callable[[int], Path], tmp_path: Path) -> None:
    recording = clip(2)
    (tmp_path / "file").write_text("")
    assert "is no folder" in lpslam("convert", recording, tmp_path / "file" / "copy.mcap").complaint
    for name in ("copy.bag", "copy.db3", "copy.lpmap"):
        assert "is not written; end the name in .mcap" in lpslam("convert", recording, tmp_path / name).complaint
        assert not (tmp_path / name).exists()
