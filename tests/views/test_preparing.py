from collections.abc import Callable

import pytest

from lpslam.slam import warm_up
from lpslam.views import run_progress


def test_kernels_that_were_only_loaded_are_not_said_to_be_compiled(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """On a busy machine, loading takes as long."""
    monkeypatch.setattr(warm_up, "warm_up", lambda announce: 7.0)
    run_progress.prepare()
    assert capsys.readouterr().err == ""


def test_kernels_that_were_compiled_are_said_to_be_kept(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def compiled(announce: Callable[[str], None]) -> float:
        announce("compiling")
        return 7.0

    monkeypatch.setattr(warm_up, "warm_up", compiled)
    run_progress.prepare()
    assert capsys.readouterr().err.splitlines() == [
        "lpslam: compiling",
        "lpslam: kernels compiled in 7 s and kept for the next start",
    ]
