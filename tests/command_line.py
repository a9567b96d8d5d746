"""Calling the command line in this process, as its user meets it."""

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest

from lpslam import cli


@dataclass(frozen=True)
class Done:
    """What a command left."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        """Standard output, which must be strict JSON and nothing else."""

        def refuse(constant: str) -> None:
            raise ValueError(f"{constant} is no JSON")

        return json.loads(self.out, parse_constant=refuse)

    @property
    def complaint(self) -> str:
        """The one line on standard error of a user's mistake."""
        assert self.code == 2, (self.code, self.out, self.err)
        assert self.out == ""
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert lines[0].startswith("lpslam: ")
        return lines[0].removeprefix("lpslam: ")


Command = Callable[..., Done]


def command_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Command:
    """A function that runs a command in 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")

    def call(*words: object) -> Done:
        monkeypatch.setattr(sys, "argv", ["lpslam", *map(str, words)])
        capsys.readouterr()
        try:
            cli.main()
            code: object = 0
        except SystemExit as end:
            code = end.code or 0
        streams = capsys.readouterr()
        assert "Traceback" not in streams.err
        assert isinstance(code, int)
        return Done(code, streams.out, streams.err)

    return call
