"""`lpslam ask` as its user meets it: at a prompt, from a pipe, from another place, and with what cannot be asked."""

import io
import json
import sys
from pathlib import Path

import pytest

from command_line import Command
from lpslam.views import dialogue

DOWN = "http://127.0.0.1:9/v1#m"


def pipe(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO(text))


def test_questions_from_a_pipe_are_answered_line_by_line(
    lpslam: Command, walked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe(monkeypatch, "Where is the washroom?\n\n  \n厕所在哪里？\nand another one?\n")
    done = lpslam("ask", walked)
    assert done.code == 0, done.err
    assert "洗手间" in done.out.splitlines()[0]
    assert "原因：" in done.out
    assert "Nothing further" in done.out
    pipe(monkeypatch, "Where is the washroom?\nWo kann ich Haggis essen?\n")
    records = [json.loads(line) for line in lpslam("ask", walked, "--json").out.splitlines()]
    assert "洗手间" in records[0]["landmark"]["name"]
    assert records[1]["landmark"] is None


def test_the_prompt_keeps_a_history_of_the_users_own(
    lpslam: Command, walked: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    readline = pytest.importorskip("readline")
    typed = iter(["Where is the washroom?", "another?"])

    def answer(prompt: str) -> str:
        line = next(typed, None)
        if line is None:
            raise EOFError
        readline.add_history(line)
        return line

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("builtins.input", answer)
    monkeypatch.setattr(sys, "stdin", Terminal())
    done = lpslam("ask", walked)
    assert done.code == 0, done.err
    assert "洗手间" in done.out
    kept = dialogue.history_file()
    assert kept.is_relative_to(tmp_path)
    assert "Where is the washroom?" in kept.read_text()
    assert kept.stat().st_mode & 0o077 == 0, "nobody else reads what was asked"


def test_from_another_place_the_way_is_another(lpslam: Command, walked: Path) -> None:
    asked = ("ask", walked, "Where is the washroom?", "--json")
    x, y, _ = lpslam(*asked).json["landmark"]["position"]
    ahead = lpslam(*asked, "--from", f"{x - 3},{y},0").json
    assert ahead["distance"] == pytest.approx(3.0, abs=0.4)
    assert min(ahead["direction"], 360 - ahead["direction"]) < 1.0
    assert lpslam(*asked, "--from", f"{x},{y + 3},0").json["direction"] == pytest.approx(270.0, abs=1.0)
    assert "to the right" in lpslam("ask", walked, "Where is the washroom?", "--from", f"{x},{y + 3},0").out
    assert "X,Y,HEADING" in lpslam(*asked, "--from", "here").complaint


def test_of_a_long_question_it_is_said_how_much_is_read(lpslam: Command, walked: Path) -> None:
    done = lpslam("ask", walked, "Where is the washroom? " * 500)
    assert done.code == 0
    assert "洗手间" in done.out
    assert done.err.splitlines() == ["lpslam: the question has 11,500 letters; its first 400 are read"]


def test_an_empty_question_ends_a_command_but_not_a_prompt(
    lpslam: Command, walked: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "the question is empty" in lpslam("ask", walked, "").complaint
    pipe(monkeypatch, "\u200b\nWhere is the washroom?\n")
    done = lpslam("ask", walked)
    assert done.code == 0
    assert "洗手间" in done.out


def test_an_answer_in_place_of_a_silent_servers_is_marked(lpslam: Command, walked: Path, tmp_path: Path) -> None:
    config = tmp_path / "quick.yaml"
    config.write_text("language: {attempts: 1, timeout_s: 2, backoff_s: 0}\n")
    done = lpslam("ask", walked, "厕所在哪里？", "--llm", DOWN, "--config", config)
    assert done.code == 0
    assert "洗手间" in done.out
    assert f"{DOWN} 没有应答，由内置模型回答" in done.out
    assert "because" not in done.out


def test_a_map_without_text_is_one_clear_answer(lpslam: Command, walk: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare.lpmap"
    assert lpslam("run", walk, "-o", bare, "--no-text", "--max-frames", 3).code == 0
    assert "the map has no text" in lpslam("ask", bare, "Where can I eat pizza?").out
    assert lpslam("ask", bare, "Where can I eat pizza?", "--json").json["landmark"] is None


def test_what_is_there_is_a_list_the_nearest_first(lpslam: Command, walked: Path) -> None:
    done = lpslam("ask", walked, "What is here?", "--from", "0,0,0")
    lines = done.out.splitlines()
    assert len(lines) >= 3
    assert all(line.startswith("- ") for line in lines)
    metres = [float(line.rsplit("(", 1)[1].split(" m")[0]) for line in lines]
    assert metres == sorted(metres)
