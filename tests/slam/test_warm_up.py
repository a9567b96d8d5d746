import subprocess
import sys
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


def test_compiling_is_announced_once_and_leaves_no_process_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(warm_up, "_HELPER", "import time; time.sleep(600)")
    started: list[subprocess.Popen[bytes]] = []
    popen = subprocess.Popen

    def start(*arguments: Any, **options: Any) -> "subprocess.Popen[bytes]":
        started.append(popen(*arguments, **options))
        return started[-1]

    monkeypatch.setattr(subprocess, "Popen", start)
    said: list[str] = []
    compiling = warm_up.FirstCompiled(said.append)
    compiling.on_start(None)
    compiling.on_start(None)
    assert len(said) == len(started) == 1
    assert started[0].poll() is None
    compiling.end()
    assert started[0].poll() is not None


def test_a_helper_that_cannot_start_or_fails_is_done_without(monkeypatch: pytest.MonkeyPatch) -> None:
    for executable in ("/nonexistent/python", "", sys.executable):
        monkeypatch.setattr(sys, "executable", executable)
        monkeypatch.setattr(warm_up, "_HELPER", "raise SystemExit(1)")
        compiling = warm_up.FirstCompiled(lambda line: None)
        compiling.on_start(None)
        compiling.wait()
        compiling.end()
