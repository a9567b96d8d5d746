from collections.abc import Callable
from pathlib import Path

import pytest

import lpslam


@pytest.mark.slow
def test_the_five_lines_of_the_package(clip: Callable[[int], Path], capsys: pytest.CaptureFixture[str]) -> None:
    """The lines of the docstring as they stand, but for the recording's name."""
    assert lpslam.__doc__ is not None
    lines = [line for line in lpslam.__doc__.splitlines()[1:] if line.strip()]
    assert len(lines) == 4, "with the opening of the recording on the line of the run"
    code = "\n".join(lines).replace('"recording/"', repr(str(clip(24))))
    assert code != "\n".join(lines)
    names: dict[str, object] = {}
    exec(compile(code, "five lines", "exec"), names)
    world = names["world"]
    assert isinstance(world, lpslam.LanguageMap)
    assert world.trajectory.tracked_count == len(world.trajectory) == 24
    assert world.text.question == "Is this a shop?"
    assert world.landmarks()
    assert all(mark.is_landmark is not None for mark in world.landmarks())
    assert capsys.readouterr().out.strip()
