"""`--llm` as its user meets it: mistakes in one line, the embedded model's answer where there is one, what it cost."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from chat_server import ChatServer, Json, answers, fails, given, says, slowly

from command_line import Command
from lpslam.mapfile.language_map import LanguageMap

Serve = Callable[..., ChatServer]

WASHROOM = "Where is the washroom?"


@pytest.fixture
def quick(tmp_path: Path) -> Path:
    config = tmp_path / "quick.yaml"
    config.write_text("language: {attempts: 2, backoff_s: 0, timeout_s: 5, rest_s: 0}\n")
    return config


@pytest.fixture
def own_map(walked: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(walked, tmp_path / "own.lpmap"))


def knows(tree: Json) -> Json:
    sure = {"confidence": 0.9, "evidence": "it says so"}
    if "signs" in tree and "question" in tree:
        found = [{"sign": each["sign"], "answer": "洗手间" not in each["text"], **sure} for each in tree["signs"]]
        return {"judgements": found}
    if "signs" in tree:
        return {
            "names": [{"sign": each["sign"], "name": each["readings"][0]["text"], **sure} for each in tree["signs"]]
        }
    if "readings" in tree:
        return {"name": tree["readings"][0]["text"], **sure}
    if "sign" in tree:
        return {"answer": "洗手间" not in tree["sign"], **sure}
    if "place" in tree:
        return {"serves": "洗手间" in tree["place"]["name"], **sure}
    label = next((mark["id"] for mark in tree["landmarks"] if "洗手间" in mark["name"]), "none")
    return {"landmark": label, "alternatives": [], **sure}


def test_an_answer_comes_with_what_it_cost(lpslam: Command, walked: Path, serve: Serve) -> None:
    server = serve(answers(knows))
    done = lpslam("ask", walked, WASHROOM, "--llm", f"{server.url}#m", "--json")
    assert "洗手间" in done.json["landmark"]["name"]
    assert done.json["choice"]["model"] == f"{server.url}#m"
    assert f"{server.url}#m: 1 call, 120 tokens" in done.err
    again = lpslam("ask", walked, WASHROOM, "--llm", f"{server.url}#m")
    assert "0 calls, 0 tokens, 1 answer kept from earlier" in again.err
    assert "洗手间" in again.out
    assert len(server.requests) == 1
    assert "call" not in lpslam("ask", walked, WASHROOM).err, "the embedded model costs nothing"


@pytest.mark.parametrize(
    ("status", "told"), [(401, "key was refused"), (403, "may not use"), (404, "no such model or address")]
)
def test_what_the_user_can_mend_is_one_line(
    lpslam: Command, walked: Path, own_map: Path, serve: Serve, quick: Path, status: int, told: str
) -> None:
    server = serve(fails(status))
    model = ("--llm", f"{server.url}#m", "--config", quick)
    assert told in lpslam("ask", walked, WASHROOM, *model).complaint
    before = own_map.read_bytes()
    assert told in lpslam("distill", own_map, *model).complaint
    assert own_map.read_bytes() == before, "a map is not half judged"


def test_a_missing_key_and_an_unknown_kind_of_model_are_one_line_each(lpslam: Command, walked: Path) -> None:
    assert "OPENAI_API_KEY" in lpslam("ask", walked, WASHROOM, "--llm", "openai:gpt-4.1-mini").complaint
    assert "is not known: use offline" in lpslam("ask", walked, WASHROOM, "--llm", "clippy").complaint
    assert "is no address" in lpslam("ask", walked, WASHROOM, "--llm", "http://#m").complaint


@pytest.mark.parametrize("question", ["", "  \n", "\u200b"])
def test_an_empty_question_is_one_line(lpslam: Command, walked: Path, serve: Serve, question: str) -> None:
    server = serve(answers(knows))
    done = lpslam("ask", walked, question, "--llm", f"{server.url}#m")
    assert server.requests == []
    assert done.code == 2 or "question is empty" in done.out


@pytest.mark.parametrize("fault", ["prose", "down", "busy", "page"])
def test_the_embedded_models_answer_takes_the_place_of_none(
    lpslam: Command, walked: Path, serve: Serve, quick: Path, fault: str
) -> None:
    server = serve(
        {"prose": says("Upstairs!"), "busy": fails(503), "page": fails(200, "<html>")}.get(fault, fails(500))
    )
    url = f"{server.url}#m"
    if fault == "down":
        url = "http://127.0.0.1:9/v1#m"
    done = lpslam("ask", walked, WASHROOM, "--llm", url, "--config", quick, "--json")
    assert done.code == 0
    assert "洗手间" in done.json["landmark"]["name"]
    assert done.json["choice"]["model"] == f"offline (instead of {url})"
    assert f"{url} did not answer: " in done.json["choice"]["evidence"]


def test_a_question_of_ten_thousand_letters_is_cut_and_answered(lpslam: Command, walked: Path, serve: Serve) -> None:
    server = serve(answers(knows))
    assert lpslam("ask", walked, "washroom " * 1250, "--llm", f"{server.url}#m").code == 0
    assert all(len(given(body)["question"]) <= 400 for body in server.requests)


def test_distilling_asks_the_model_and_says_what_it_cost(lpslam: Command, own_map: Path, serve: Serve) -> None:
    server = serve(answers(knows))
    done = lpslam("distill", own_map, "--llm", f"{server.url}#m", "--json")
    judged = {mark["name"]: mark["is_landmark"] for mark in done.json["landmarks"]}
    assert judged
    assert all(answer == ("洗手间" not in name) for name, answer in judged.items())
    assert "not by" not in done.err
    assert re.search(r"#m: \d+ calls, [\d,]+ tokens", done.err)


@pytest.mark.slow
def test_mapping_does_not_wait_for_names_and_takes_them_when_they_come(
    lpslam: Command, clip: Callable[[int], Path], tmp_path: Path, serve: Serve
) -> None:
    server = serve(slowly(answers(knows), 0.5))
    url = f"{server.url}#m"
    done = lpslam("run", clip(24), "--output", tmp_path / "a.lpmap", "--sequential", "--llm", url)
    assert done.code == 0, done.err
    named = [each.naming for each in LanguageMap.load(tmp_path / "a.lpmap").text.long_term]
    assert named
    assert {naming.model for naming in named if naming is not None} == {url}
    assert "not by" not in done.err
