"""A model that answers rightly stays right through everything that stands between it and the map, on every set."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from chat_server import ChatServer, Json, answers, refusing

from lpslam.evaluation.language import LanguageCases, read_cases, score_language
from lpslam.language.hosted.chat import ChatModel

SETS = Path(__file__).parents[3] / "benchmarks" / "language"

Serve = Callable[..., ChatServer]
Chat = Callable[..., ChatModel]


def oracle(cases: LanguageCases) -> Callable[[Json], Json]:
    """Knows the answers of a set."""
    names = {json.dumps([each.text for each in case.readings]): case.expected[0] for case in cases.naming}
    judged = {(case.question, name): answer for case in cases.judging for name, answer in case.expected.items()}
    chosen = {case.question: case.expected for case in cases.choosing}

    def reason(tree: Json) -> Json:
        answer: dict[str, Any] = {"confidence": 0.9, "evidence": "it is known"}
        if "readings" in tree:
            answer["name"] = names[json.dumps([each["text"] for each in tree["readings"]])]
        elif "signs" in tree:
            texts = [(each["sign"], judged[tree["question"], each["text"]]) for each in tree["signs"]]
            answer["judgements"] = [{"sign": sign, "answer": told, "confidence": 0.9} for sign, told in texts]
        elif "sign" in tree:
            answer["answer"] = judged[tree["question"], tree["sign"]]
        elif "place" in tree:
            answer["serves"] = tree["place"]["name"] in chosen[tree["question"]]
        else:
            fitting = [mark["id"] for mark in tree["landmarks"] if mark["name"] in chosen[tree["question"]]]
            answer |= {"landmark": fitting[0] if fitting else "none", "alternatives": fitting[1:]}
        return answer

    return reason


@pytest.mark.parametrize("name", ["paper", "development", "second", "third", "fourth"])
def test_right_answers_stay_right(serve: Serve, chat: Chat, name: str) -> None:
    cases = read_cases(SETS / f"{name}.json")
    model = chat(serve(answers(oracle(cases))), max_calls=10_000, max_tokens=10**9)
    score = score_language(model, cases)
    assert score.misses == ()
    assert model.usage.calls > 0


def test_right_answers_stay_right_where_only_plain_words_are_taken(serve: Serve, chat: Chat) -> None:
    cases = read_cases(SETS / "paper.json")
    server = serve(refusing("response_format", "tools", then=answers(oracle(cases))))
    assert score_language(chat(server), cases).misses == ()
