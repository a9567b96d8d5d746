import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from lpslam.slam import warm_up


def test_what_was_compiled_once_is_only_loaded() -> None:
    said: list[str] = []
    warm_up.warm_up(said.append)
    said.clear()
    warm_up.run_mapping()
    assert warm_up.warm_up(said.append) < 30.0
    assert not said


def test_compiling_is_announced_once() -> None:
    said: list[str] = []
    first_compiled = warm_up.FirstCompiled(said.append)
    first_compiled.on_start(None)
    first_compiled.on_start(None)
    assert len(said) == 1
    assert first_compiled.is_compiling


def test_what_is_missing_is_compiled_beside_and_kept(tmp_path: Path) -> None:
    script = (
        "from lpslam.slam import warm_up\n"
        # One small kernel stands for all, which take twenty seconds.
        "small = 'import numpy; from lpslam.slam.kernels.geometry import logarithm; logarithm(numpy.eye(4))'\n"
        "warm_up._HELPERS = (small,)\n"
        "for run in ('run_adjustment', 'run_tracking', 'run_mapping', 'run_seldom', 'run_everything'):\n"
        "    setattr(warm_up, run, lambda: None)\n"
        "print(warm_up.warm_up(print))\n"
    )
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}

    def start() -> str:
        run = subprocess.run(
            [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
        )
        return run.stdout

    assert start().startswith("Compiling")
    kept = {path.name: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")}
    assert any(name.startswith("geometry.logarithm-") for name in kept)
    assert not start().startswith("Compiling")
    assert {path.name: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")} == kept


def test_no_process_is_left_behind_when_waiting_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "_HELPERS", ("import time; time.sleep(600)",) * 2)
    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    class Interrupted(popen):  # type: ignore[misc, type-arg, valid-type]
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)
            self.waits = 0

        def wait(self, timeout: float | None = None) -> int:
            if self is started[0] and not self.waits:
                self.waits = 1
                raise KeyboardInterrupt
            return int(super().wait(timeout))

    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        warm_up.compile_beside()
    assert len(started) == 2
    assert all(each.poll() is not None for each in started)


def test_processes_that_cannot_start_or_fail_are_done_without(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "_HELPERS", ("raise SystemExit(1)",))
    for executable in ("/nonexistent/python", "", sys.executable):
        monkeypatch.setattr(sys, "executable", executable)
        warm_up.compile_beside()


def test_no_kernel_is_left_for_a_frame_to_wait_for() -> None:
    script = (
        "import inspect, sys\n"
        "from numba.core.dispatcher import Dispatcher\n"
        "from lpslam.slam.warm_up import warm_up\n"
        "warm_up(print)\n"
        "inside = 'lpslam.slam.kernels.'\n"
        "used = set()\n"
        "for name, module in list(sys.modules.items()):\n"
        "    if not name.startswith('lpslam.slam.') or name.startswith(inside):\n"
        "        continue\n"
        "    text = inspect.getsource(module)\n"
        "    for key, value in vars(module).items():\n"
        "        if isinstance(value, Dispatcher):\n"
        "            used.add(value)\n"
        "        elif getattr(value, '__name__', '').startswith(inside):\n"
        "            named = {n: k for n, k in vars(value).items() if isinstance(k, Dispatcher)}\n"
        "            used |= {k for n, k in named.items() if f'{key}.{n}(' in text}\n"
        "print(len(used) > 40, [each.__name__ for each in used if not each.signatures])\n"
    )
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.splitlines()[-1] == "True []"
