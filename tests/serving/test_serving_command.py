"""What `serve` and `mcp` refuse, before anything slow is loaded."""

from pathlib import Path

import pytest

from command_line import Command
from lpslam import cli_serving
from lpslam.language import registry


@pytest.mark.parametrize("command", ["serve", "mcp"])
def test_what_is_no_map_is_told_before_anything_slow_is_loaded(
    lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    def loaded(*given: object) -> None:
        pytest.fail("a model or a library of pictures is loaded")

    monkeypatch.setattr(registry, "language_model", loaded)
    monkeypatch.setattr(cli_serving, "load_matplotlib", loaded)
    assert "cannot be read" in lpslam(command, tmp_path / "nowhere.lpmap").complaint
    (tmp_path / "text.lpmap").write_text("no map")
    assert "is not an lpslam map" in lpslam(command, tmp_path / "text.lpmap").complaint
