import json
import os
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import lpslam
from small_maps import small_map

PACKAGE = Path(lpslam.__file__).parent

COMPILE = """
import os, sys
import numpy as np
from lpslam import kernel_cache
from lpslam.slam.kernels.geometry import median
assert median(np.array([3.0, 1.0, 2.0]), 3) == 2.0
print(kernel_cache.is_kept(), os.environ["NUMBA_CACHE_DIR"])
"""


@pytest.fixture(scope="session")
def read_only(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the package in which no cache can be made, even by the one who may write everywhere."""
    folder = tmp_path_factory.mktemp("packages")
    # With what Python has compiled, but where there are kernels.
    shutil.copytree(PACKAGE, folder / "lpslam", ignore=shutil.ignore_patterns("*.nbi", "*.nbc"))
    for package in {code.parent for code in (folder / "lpslam").rglob("*.py") if "@njit" in code.read_text()}:
        shutil.rmtree(package / "__pycache__", ignore_errors=True)
        (package / "__pycache__").write_text("no folder")
    return folder


WITH_KERNELS = (
    "ground.kernels",
    "navigation.walking.searching",
    "sources.bags.rvl",
    "sources.registering.registration",
)


# Python and numba, which has compiled once, are there already: what is tested is what lpslam makes of them. Nothing of
# lpslam is loaded before the fork.
FORKED = """
import json, os, sys, tempfile
import cv2, numba, scipy.ndimage
numba.njit(lambda each: each + 1.0)(1.0)
assert not [name for name in sys.modules if name.startswith("lpslam")]
for line in sys.stdin:
    order = json.loads(line)
    child = os.fork()
    if child == 0:
        os.chdir(order["folder"])
        os.environ.clear()
        os.environ.update(order["environment"])
        tempfile.tempdir = None
        for number, name in enumerate(("/dev/null", "out", "err")):
            opened = os.open(os.path.join(order["streams"], name), os.O_RDWR | os.O_CREAT)
            os.dup2(opened, number)
            os.close(opened)
        sys.argv = ["-c", *order["words"]]
        exec(order["code"], {"__name__": "__main__"})
        sys.exit()
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""


class Started:
    """A Python with the read-only package, and without a home."""

    def __init__(self, packages: Path, temporary: Path, current: Path, forking: subprocess.Popen[str]) -> None:
        self.temporary, self.current, self._forking = temporary, current, forking
        self.environment = without_home(packages) | {"TMPDIR": str(temporary)}

    def __call__(self, code: str, *words: object, **more: str) -> subprocess.CompletedProcess[str]:
        """As `anew`, in a process that is forked where Python and its libraries are there."""
        assert self._forking.stdin is not None
        assert self._forking.stdout is not None
        streams = Path(tempfile.mkdtemp(dir=self.current.parent))
        order = {
            "code": code,
            "words": [*map(str, words)],
            "environment": self.environment | more,
            "folder": str(self.current),
            "streams": str(streams),
        }
        print(json.dumps(order), file=self._forking.stdin, flush=True)
        ended = int(self._forking.stdout.readline())
        out, err = ((streams / name).read_text() for name in ("out", "err"))
        return subprocess.CompletedProcess([code], ended, out, err)

    def anew(self, code: str, **more: str) -> subprocess.CompletedProcess[str]:
        """Run code in a new process."""
        return subprocess.run(
            [sys.executable, "-P", "-c", code],
            cwd=self.current,
            env=self.environment | more,
            capture_output=True,
            text=True,
            check=False,
        )


def without_home(packages: Path) -> dict[str, str]:
    return {
        **{name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "XDG_"))},
        "PYTHONPATH": str(packages),
        "HOME": "/dev/null/nowhere",
    }


@pytest.fixture(scope="module")
def forking(read_only: Path) -> Iterator[subprocess.Popen[str]]:
    words = [sys.executable, "-P", "-c", FORKED]
    with subprocess.Popen(
        words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=without_home(read_only), text=True
    ) as process:
        yield process
        assert process.stdin is not None
        process.stdin.close()


@pytest.fixture
def started(read_only: Path, tmp_path: Path, forking: subprocess.Popen[str]) -> Started:
    for name in ("temporary", "current"):
        (tmp_path / name).mkdir()
    return Started(read_only, tmp_path / "temporary", tmp_path / "current", forking)


def test_without_a_place_kernels_are_kept_in_a_private_folder_until_the_end(started: Started) -> None:
    look = (
        "from pathlib import Path\n"
        "folder = Path(os.environ['NUMBA_CACHE_DIR'])\n"
        "print(oct(folder.stat().st_mode), folder.stat().st_uid == os.getuid(), len(list(folder.rglob('*.nbc'))))\n"
    )
    done = started(COMPILE + look)
    assert done.returncode == 0, done.stderr
    kept, folder, mode, is_own, files = done.stdout.split()
    assert kept == "False"
    assert Path(folder).parent == started.temporary
    assert stat.S_IMODE(int(mode, 8)) == 0o700
    assert is_own == "True"
    assert int(files) >= 1
    assert len(done.stderr.splitlines()) == 1
    assert "compiled anew at each start" in done.stderr
    assert not list(started.temporary.iterdir()), "removed"
    assert not list(started.current.iterdir())


def test_the_folder_serves_processes_that_are_started_and_forked_ones_leave_it(started: Started) -> None:
    code = (
        "import subprocess\n"
        "from lpslam.isolated import python_command\n"
        f"subprocess.run(python_command({COMPILE!r}), check=True)\n"
        "if os.fork() == 0:\n"
        "    sys.exit()\n"
        "os.wait()\n"
        "print(os.path.isdir(os.environ['NUMBA_CACHE_DIR']))\n"
    )
    done = started(COMPILE + "sys.stdout.flush()\n" + code)
    assert done.returncode == 0, done.stderr
    here, beside, *_, is_there = done.stdout.splitlines()
    assert here.split()[1] == beside.split()[1]
    assert is_there == "True"
    assert len(done.stderr.splitlines()) == 1, "what this process compiled is loaded by the other"
    assert not list(started.temporary.iterdir())


def test_what_compiles_nothing_says_nothing(started: Started) -> None:
    done = started("import lpslam.slam.kernels.geometry, lpslam.simulation.render, lpslam.slam.system")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list(started.temporary.iterdir())


def test_an_end_without_farewell_removes_the_folder(started: Started) -> None:
    done = started(
        "import lpslam.slam.kernels\n"
        "from lpslam import cli_runs\n"
        "def interrupted(): raise SystemExit(cli_runs.INTERRUPTED)\n"
        "cli_runs.call_to_its_end(interrupted)\n"
    )
    assert done.returncode == 130, done.stderr
    assert not list(started.temporary.iterdir())


def test_a_folder_that_can_be_written_is_used_and_stays(started: Started, tmp_path: Path) -> None:
    for variable in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        own = tmp_path / variable
        done = started(COMPILE, **{variable: str(own)})
        assert done.stdout.split()[0] == "True"
        assert done.stderr == ""
        assert list(own.rglob("*.nbc"))


def test_a_relative_folder_counts_only_if_it_was_asked_for(started: Started) -> None:
    # An empty XDG_CACHE_HOME makes numba look in the current folder, where a recording may have brought kernels.
    done = started(COMPILE, XDG_CACHE_HOME="")
    assert done.stdout.split()[0] == "False"
    assert not list(started.current.iterdir())
    assert started(COMPILE, NUMBA_CACHE_DIR="mine").stdout.split() == ["True", "mine"]
    assert list(started.current.rglob("mine/**/*.nbc"))


def test_a_file_in_the_current_folder_names_no_place(started: Started) -> None:
    planted = started.current / "planted"
    (started.current / ".numba_config.yaml").write_text("cache_dir: planted\ncache_locator_classes: random.Random\n")
    for home in (started.current.with_name("home"), "/dev/null/nowhere"):
        done = started.anew(COMPILE, HOME=str(home))
        assert done.returncode == 0, done.stderr
        assert not planted.exists()


def test_kernels_that_are_not_compiled_need_no_place(started: Started) -> None:
    done = started(COMPILE, NUMBA_DISABLE_JIT="1")
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "True", "")


def test_where_nothing_can_be_written_one_line_says_so(started: Started) -> None:
    code = (
        "import tempfile\n"
        "def refuse(*_, **__): raise OSError(30, 'read-only')\n"
        "tempfile.mkdtemp = refuse\n"
        "from lpslam.cli_runs import call_to_its_end\n"
        "def work(): import lpslam.slam.kernels\n"
        "call_to_its_end(work)\n"
    )
    done = started(code)
    assert done.returncode == 2
    assert done.stderr == (
        "lpslam: compiled kernels can be kept nowhere: set NUMBA_CACHE_DIR to a folder that can be written\n"
    )


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="this system lends no memory as a folder")
def test_a_full_disk_is_no_place_unless_kernels_are_there_already(started: Started, tmp_path: Path) -> None:
    full = (
        "import shutil\n"
        "from types import SimpleNamespace as Usage\n"
        f"shutil.disk_usage = lambda folder: Usage(free=0 if str(folder).startswith({str(tmp_path)!r}) else 1 << 40)\n"
    )
    home = str(tmp_path / "home")
    kept, folder = started(full + COMPILE, HOME=home).stdout.split()
    assert kept == "False"
    assert folder.startswith("/dev/shm/lpslam-kernels-")
    assert not Path(folder).exists()
    assert not list(started.temporary.iterdir())
    assert started(COMPILE, HOME=home).stdout.strip() == "True"
    done = started(full + COMPILE, HOME=home)
    assert (done.stdout.strip(), done.stderr) == ("True", "")


@pytest.mark.slow
def test_commands_work_without_a_home(started: Started, tmp_path: Path) -> None:
    """On a map without ground, which needs no kernels: where these are kept is tested above."""
    path = tmp_path / "small.lpmap"
    small_map().save(path)
    command = "from lpslam.cli import main; main()"
    for words in (["info", path], ["ask", path, "Where is the washroom?"], ["draw", path, "map.png"]):
        done = started(command, *words)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout
    assert not list(started.temporary.iterdir())


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
def test_a_full_disk_is_one_line() -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-c", "from lpslam.cli import main; main()", "config"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == "lpslam: writing: No space left on device\n"


@pytest.mark.parametrize("module", [*WITH_KERNELS, "simulation.render"])
def test_whatever_comes_first_has_a_place_for_its_kernels(started: Started, module: str) -> None:
    done = started(f"import lpslam.{module}")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert not list(started.temporary.iterdir()), "removed"
