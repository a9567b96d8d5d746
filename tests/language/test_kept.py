"""What is kept in the user's cache: made once, and anew where it is torn, closed or of something else."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lpslam.language import kept as kept_module
from lpslam.language.kept import kept
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel

NAMES = ("Starbucks", "必胜客 Pizza Hut", "Gates B20–B38", "Tolets", "Dr. Schneider – Orthopaedics", "EXIT")


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


def written(folder: Path) -> list[Path]:
    return sorted((folder / "lpslam" / "made").glob("*"))


def test_a_value_is_made_once_for_what_it_is_made_of() -> None:
    made: list[str] = []

    def make() -> tuple[str, dict[str, int]]:
        made.append("once")
        return "value", {"ü": 1}

    assert [kept("thing", b"one", make) for _ in range(3)] == [("value", {"ü": 1})] * 3
    assert kept("thing", b"other", make) == ("value", {"ü": 1})
    assert len(made) == 2


@pytest.mark.parametrize("torn", [b"", b"\x00", b"\x00\x00\x00\x00{", b"no marshal at all"])
def test_what_is_torn_is_made_anew(tmp_path: Path, torn: bytes) -> None:
    kept("thing", b"", lambda: [1, 2])
    (path,) = written(tmp_path)
    path.write_bytes(torn)
    assert kept("thing", b"", lambda: [3]) == [3]
    assert kept("thing", b"", lambda: [4]) == [3]


def test_files_are_the_users_alone(tmp_path: Path) -> None:
    kept("thing", b"", lambda: 1)
    (path,) = written(tmp_path)
    if os.name == "posix":
        assert path.stat().st_mode & 0o077 == 0
        assert path.parent.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(os.name != "posix", reason="pipes and owners are POSIX's")
def test_a_pipe_and_somebody_elses_file_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept("thing", b"", lambda: 1)
    (path,) = written(tmp_path)
    path.unlink()
    os.mkfifo(path)
    assert kept("thing", b"", lambda: 2) == 2
    assert kept("thing", b"", lambda: 3) == 2
    with monkeypatch.context() as another:
        another.setattr(os, "geteuid", lambda: 12345)
        assert kept("thing", b"", lambda: 4) == 4


def test_a_folder_that_is_none_does_no_harm(tmp_path: Path) -> None:
    (tmp_path / "lpslam").write_text("a file")
    assert kept("thing", b"", lambda: 5) == 5


def test_the_oldest_files_make_room(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept_module, "_MOST_BYTES", 3000)
    for at in range(5):
        kept("thing", bytes([at]), lambda: b"x" * 1000)
    left = written(tmp_path)
    assert 0 < len(left) < 5
    assert kept("thing", bytes([4]), lambda: b"") == b"x" * 1000


def test_boards_say_the_same_when_they_were_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    marks = [Candidate(at, name, (), ("Line 1", "coffee · 茶")) for at, name in enumerate(NAMES)]
    plain = OfflineModel().scorer(marks)
    monkeypatch.setattr(kept_module, "MANY", 1)
    first, second = OfflineModel().scorer(marks), OfflineModel().scorer(marks)
    assert {path.name.partition("-")[0] for path in written(tmp_path)} >= {"signs", "called", "words"}
    for scorer in (first, second):
        assert scorer._index.signs == plain._index.signs
        assert scorer._index.groups == plain._index.groups
        for each in ("ids_of", "ids_by_word", "phrase_of", "_initials", "_plurals"):
            assert getattr(scorer._index, each) == getattr(plain._index, each)
        for id_, lines in scorer._names._words.items():
            own = plain._names._words[id_]
            assert [(each.text, each.units, each.runs) for each in lines] == [
                (each.text, each.units, each.runs) for each in own
            ]


def test_codes_and_sounds_are_the_same_when_they_were_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("Gate B31", "Rooms 201-212", "Halle 3", "Counter A", "Al6", "Phoenix Dental", "优衣堂")
    marks = [Candidate(10 * at, name, (), ("2号站台",)) for at, name in enumerate(names)]
    plain = OfflineModel().scorer(marks)
    monkeypatch.setattr(kept_module, "MANY", 1)
    for _ in range(2):
        scorer = OfflineModel().scorer(marks)
        assert scorer._identities._painted == plain._identities._painted
        for said in (["feenix", "dentl"], ["youyitang"]):
            assert scorer._names.sounding(said, True) == plain._names.sounding(said, True) != {}
    assert {path.name.partition("-")[0] for path in written(tmp_path)} >= {"codes", "sounds"}


def test_a_process_that_finds_tables_answers_as_the_one_that_made_them(tmp_path: Path) -> None:
    code = (
        "from lpslam.language.model import Candidate; from lpslam.language.offline import OfflineModel;"
        f"marks = [Candidate(at, name) for at, name in enumerate({NAMES!r})];"
        "print([OfflineModel().choose(text, marks) for text in "
        "('Where is the toilet?', 'gate B31', '哪里可以吃披萨', 'ein Arzt', 'un café', 'コーヒー')])"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path), "PYTHONIOENCODING": "utf-8"}
    said = [
        subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True).stdout
        for _ in range(2)
    ]
    assert said[0] == said[1] != b""
    assert {path.name.partition("-")[0] for path in written(tmp_path)} >= {"tables", "spoken", "heard"}


def test_what_is_compiled_beside_the_program_makes_nothing_anew(tmp_path: Path) -> None:
    program = tmp_path / "program"
    (program / "__pycache__").mkdir(parents=True)
    (program / "rules.py").write_text("A = 1\n")
    before = kept_module._program(program)
    for name in ("rules.cpython-311.pyc", "kernels.loop-12.py311.nbi", "kernels.loop-12.py311.1.nbc"):
        (program / "__pycache__" / name).write_bytes(b"\0")
    kept_module._program.cache_clear()
    assert kept_module._program(program) == before
    (program / "rules.py").write_text("A = 12\n")
    kept_module._program.cache_clear()
    assert kept_module._program(program) != before
