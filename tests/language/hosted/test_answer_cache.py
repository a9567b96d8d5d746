"""Answers on disk: the same question is paid for once, and a broken or closed cache does no harm."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from chat_server import ChatServer, Json, answers, picks

from lpslam.language.hosted import chat as chat_module
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.hosted.usage import AnswerCache
from lpslam.language.kept import user_cache_folder
from lpslam.language.model import Candidate
from lpslam.language.registry import language_model

MARKS = [Candidate(3, "KFC"), Candidate(8, "GUCCI")]

Serve = Callable[..., ChatServer]
Chat = Callable[..., ChatModel]


def kept(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.json"))


def test_the_same_question_is_asked_once_also_by_another_process(serve: Serve, chat: Chat, tmp_path: Path) -> None:
    server = serve(picks("KFC"))
    first = chat(server, cache=True)
    assert first.choose("chicken?", MARKS).landmark == 3
    again = chat(server, cache=True)
    assert again.choose("chicken?", MARKS) == first.choose("chicken?", MARKS)
    assert len(server.requests) == 1
    assert str(again.usage) == "0 calls, 0 tokens, 1 answer kept from earlier"
    again.choose("chicken wings?", MARKS)
    again.choose("chicken?", [*MARKS, Candidate(9, "Zara")])
    assert len(server.requests) == 3, "another question or another map is another answer"
    (folder,) = list((tmp_path / "cache").iterdir())
    assert folder.name == "lpslam"


def test_neither_keys_nor_questions_stand_in_it(
    serve: Serve, chat: Chat, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LPSLAM_LLM_API_KEY", "secret-key")
    chat(serve(picks("KFC")), cache=True).choose("chicken for my secret guest?", MARKS)
    files = kept(tmp_path)
    assert files
    assert not [path for path in files if "secret" in path.read_text(encoding="utf-8") + path.name]


def test_another_wording_of_the_task_is_another_answer(
    serve: Serve, chat: Chat, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = serve(picks("KFC"))
    model = chat(server, cache=True)
    model.choose("chicken?", MARKS)
    monkeypatch.setattr(chat_module, "task", lambda use: f"Do it better: {use}")
    model.choose("chicken?", MARKS)
    assert len(server.requests) == 2


def test_an_answer_on_disk_is_held_to_the_same_rules(serve: Serve, chat: Chat, tmp_path: Path) -> None:
    server = serve(picks("KFC"))
    chat(server, cache=True).choose("chicken?", MARKS)
    (file,) = kept(tmp_path)
    for number, broken in enumerate(
        ["", "{", "null", "[]", '{"landmark": "L9999"}', '{"landmark": 8}', "[" * 100_000, "\x00\xff"]
    ):
        file.write_text(broken, encoding="utf-8")
        assert chat(server, cache=True).choose("chicken?", MARKS).landmark == 3
        assert len(server.requests) == 2 + number, "it is asked for anew"
    file.write_bytes(b"\xff\xfe\xff")
    assert chat(server, cache=True).choose("chicken?", MARKS).landmark == 3


def test_a_refused_answer_is_not_kept(serve: Serve, chat: Chat, tmp_path: Path) -> None:
    chat(serve(answers(lambda _: {"landmark": "L9999"})), cache=True).choose("chicken?", MARKS)
    assert kept(tmp_path) == []


def test_it_can_be_turned_off(serve: Serve, chat: Chat, tmp_path: Path) -> None:
    server = serve(picks("KFC"))
    for _ in range(2):
        chat(server, cache=False).choose("chicken?", MARKS)
    assert len(server.requests) == 2
    assert kept(tmp_path) == []


def test_a_folder_that_cannot_be_written_does_no_harm(serve: Serve, chat: Chat, tmp_path: Path) -> None:
    # A file where the folder should be stops everybody, also the superuser, who may write anywhere.
    (tmp_path / "cache").write_text("in the way")
    server = serve(picks("KFC"))
    for _ in range(2):
        assert chat(server, cache=True).choose("chicken?", MARKS).landmark == 3
    assert len(server.requests) == 2


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_a_read_only_folder_does_no_harm(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    cache = AnswerCache(tmp_path)
    cache.keep("ab12", {"a": 1})
    assert cache.get("ab12") is None


def test_it_lives_in_the_users_cache_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert user_cache_folder() == tmp_path / "lpslam"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    folder = user_cache_folder()
    assert folder is None or folder.is_absolute()
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert "lpslam" in str(user_cache_folder())


def test_without_a_home_there_is_no_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)
    assert user_cache_folder() is None
    assert language_model("http://127.0.0.1:9/v1#m").model == "http://127.0.0.1:9/v1#m"


def test_what_is_kept_comes_back(tmp_path: Path) -> None:
    cache = AnswerCache(tmp_path / "answers")
    answer: Json = {"name": "必胜客", "confidence": 0.5}
    key = cache.key("model", "prompt", {"a": "b"}, {})
    assert cache.get(key) is None
    cache.keep(key, answer)
    assert cache.get(key) == answer
    assert (
        len({cache.key(*each, {}) for each in [("m", "p", {"a": 1}), ("n", "p", {"a": 1}), ("m", "q", {"a": 1})]}) == 3
    )
    assert list(tmp_path.rglob("tmp*")) == []
