import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import lpslam
from lpslam import isolated
from lpslam.config import SpottingConfig
from lpslam.slam import warm_up
from lpslam.text.reading.spotting_process import SpottingProcess

PACKAGE = Path(lpslam.__file__).parent


@pytest.fixture
def trap(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder: its modules, named as Python's own and as others', say when one of them was run."""
    folder = tmp_path / "recording"
    folder.mkdir()
    for name in ("random", "json", "signal", "numpy", "cv2", "numba", "sitecustomize", "usercustomize"):
        (folder / f"{name}.py").write_text(f"open({str(tmp_path / 'sprung')!r}, 'a').write('{name} ')\n")
    monkeypatch.chdir(folder)
    return tmp_path / "sprung"


def printed(code: str, *arguments: str) -> str:
    command = isolated.python_command(code, *arguments)
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_helpers_that_compile_run_nothing_of_the_current_folder(trap: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    done = trap.with_name("done")
    code = (
        f"import random, json, cv2; from lpslam.slam import warm_up; open({str(done)!r}, 'w').write(warm_up.__file__)"
    )
    monkeypatch.setattr(warm_up, "_HELPERS", (code,))
    warm_up.compile_beside()
    assert not trap.exists(), trap.read_text()
    assert done.read_text() == warm_up.__file__


@pytest.mark.skipif(not SpottingProcess.is_possible(), reason="this system hands no channel to another Python")
def test_the_reading_process_runs_nothing_of_the_current_folder(trap: Path) -> None:
    with SpottingProcess(SpottingConfig()) as process:
        assert len(process.detect(np.zeros((64, 64, 3), np.uint8))[0]) == 0
    assert not trap.exists(), trap.read_text()


def test_the_current_folder_is_no_place_to_look_however_it_is_named(
    trap: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = Path.cwd()
    link = here.with_name("link")
    link.symlink_to(here)
    (here / "below").mkdir()
    monkeypatch.setattr(sys, "path", ["", ".", str(here), str(link), "below", *sys.path])
    for variable in ("PYTHONPATH", "PYTHONSTARTUP", "PYTHONHOME", "PYTHONINSPECT"):
        monkeypatch.setenv(variable, str(here))
    look = "import sys, random, json, lpslam; print(json.dumps([sys.path, lpslam.__file__, sys.argv[1:]]))"
    path, home, arguments = json.loads(printed(look, "a b", "'"))
    assert path[0] == str(here / "below"), "other places stay as they are"
    assert all(Path(entry).is_absolute() for entry in path)
    assert str(here) not in map(os.path.realpath, path)
    assert home == lpslam.__file__
    assert arguments == ["a b", "'"]
    assert not trap.exists(), trap.read_text()


def test_who_stands_in_the_folder_of_the_package_finds_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(PACKAGE.parent)
    monkeypatch.setattr(sys, "path", ["", *(entry for entry in sys.path if entry != str(PACKAGE.parent))])
    assert printed("import lpslam; print(lpslam.__file__)").strip() == lpslam.__file__
    # The same by a name that says nothing any more, once another folder is the current one.
    monkeypatch.chdir("/")
    assert str(PACKAGE.parent) in isolated.search_path()
    assert "/" not in isolated.search_path()


def test_a_current_folder_that_was_removed_is_no_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setattr(sys, "path", ["", *sys.path])
    assert printed("import lpslam; print(lpslam.__file__)").strip() == lpslam.__file__


def test_a_package_in_a_zip_is_found_there(tmp_path: Path) -> None:
    archive = tmp_path / "packages.zip"
    with zipfile.ZipFile(archive, "w") as file:
        for name in ("__init__.py", "_version.py", "isolated.py"):
            file.write(PACKAGE / name, f"lpslam/{name}")
    parent = (
        f"import sys, subprocess; sys.path.insert(0, {str(archive)!r}); from lpslam import isolated\n"
        "subprocess.run(isolated.python_command('import lpslam; print(lpslam.__file__)'), check=True)"
    )
    done = subprocess.run([sys.executable, "-I", "-c", parent], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(str(archive))


def test_the_environment_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setattr(sys, "pycache_prefix", "/elsewhere")
    shown = printed("import os, sys; print(os.environ['OMP_NUM_THREADS'], sys.dont_write_bytecode, sys.pycache_prefix)")
    assert shown.split() == ["7", "True", "/elsewhere"]


def test_the_command_itself_looks_for_nothing_in_the_current_folder(trap: Path) -> None:
    command = Path(sys.executable).with_name("lpslam")
    if not command.is_file():
        pytest.skip("lpslam is not installed beside this Python")
    done = subprocess.run([command, "config"], capture_output=True, text=True, check=True)
    assert "slam:" in done.stdout
    assert not trap.exists(), trap.read_text()


def test_nothing_is_started_from_within_another_program(monkeypatch: pytest.MonkeyPatch) -> None:
    assert isolated.can_start()
    monkeypatch.setattr(sys, "frozen", True, raising=False)
    assert not isolated.can_start()
