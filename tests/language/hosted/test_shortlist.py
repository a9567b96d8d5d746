"""A question costs no more in a large map than in a small one, and still finds what there is."""

import json
import random
import time
from collections.abc import Callable, Sequence

from chat_server import ChatServer, Json, answers, label_of

from lpslam.config import LanguageConfig
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.hosted.endpoint import Endpoint
from lpslam.language.hosted.shortlist import shortlist
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading

KINDS = ["Zara", "KFC", "Pharmacy", "Toilet", "Bank", "Bookshop", "Hairdresser", "LEGO", "Apple Store", "Optician"]
NOTHING = Choice(None, 0.0, "not understood", "embedded")

Serve = Callable[..., ChatServer]


class Embedded:
    """Stands in for the embedded model: chooses as it is told, in no time."""

    model = "embedded"

    def __init__(self, choice: Choice = NOTHING) -> None:
        self.choice = choice

    def name(self, readings: Sequence[Reading]) -> Naming:
        raise AssertionError("nobody asks for a name")

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        raise AssertionError("nobody asks for a judgement")

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        return self.choice


def model_at(server: ChatServer, choice: Choice = NOTHING) -> ChatModel:
    endpoint = Endpoint("openai", server.url, "test", "test")
    return ChatModel(endpoint, Embedded(choice), LanguageConfig(cache=False))


def city(count: int) -> list[Candidate]:
    """Shops with long names and many readings, of ten kinds and of none."""
    chance = random.Random(5)
    marks = []
    for number in range(count):
        name = f"{KINDS[number % 10]} {number}" if number % 3 else "".join(chance.choices("бвгдеё漢字語店あい", k=60))
        marks.append(Candidate(number * 1000, name, tuple(f"{name[:50]} {other}" for other in range(9))))
    return marks


CITY = city(10_000)


def test_a_small_map_is_sent_whole_and_in_order() -> None:
    marks = CITY[:60]
    assert shortlist("Where can I eat?", marks, 60, NOTHING) == marks


def test_a_question_costs_a_bounded_number_of_tokens_at_ten_thousand_landmarks(serve: Serve) -> None:
    server = serve(
        answers(lambda _: {"landmark": "none", "alternatives": [], "confidence": 1, "evidence": "", "serves": ["Zara"]})
    )
    sizes = {}
    for count in (60, 1000, 10_000):
        before = len(server.requests)
        model_at(server).choose("Wo gibt es " + "漢" * 5000, CITY[:count])
        asked = server.requests[before:]
        assert len(asked) == (2 if count > 1000 else 1), "of more than can be sent, what would serve is asked first"
        # UTF-8 bytes are more than tokens in every tokeniser that works on them.
        sizes[count] = len(json.dumps(asked, ensure_ascii=False).encode())
    assert sizes[10_000] <= sizes[1000], "more landmarks cost no more"


def test_what_is_named_is_among_them() -> None:
    needle = [*CITY, Candidate(77, "Zum wilden Quux"), Candidate(78, "龙门客栈 九号")]
    for question, wanted in {"Where is the wilde Quux?": 77, "龙门客栈在哪里": 78}.items():
        assert wanted in {mark.id for mark in shortlist(question, needle, 60, NOTHING)}


def test_what_the_embedded_model_chose_is_among_them_with_others_of_its_kind() -> None:
    own = Choice(2000, 0.9, "medicine", "embedded", (15_000,))
    found = shortlist("my head aches", CITY, 60, own)
    assert len(found) == 60
    assert {2000, 15_000} <= {mark.id for mark in found}
    assert sum(mark.name.startswith("Pharmacy") for mark in found) >= 10


def test_for_a_wish_that_is_not_understood_there_is_one_of_every_kind() -> None:
    found = shortlist("somewhere to frobnicate", CITY, 60, NOTHING)
    assert len(found) == 60
    assert {kind for kind in KINDS if any(mark.name.startswith(kind) for mark in found)} == set(KINDS)
    assert found == sorted(found, key=lambda mark: mark.id)


def test_the_right_one_of_ten_thousand_is_chosen(serve: Serve) -> None:
    def knows(tree: Json) -> Json:
        sure = {"confidence": 0.9, "evidence": "a nut shop"}
        if "place" in tree:
            return {"serves": tree["place"]["name"] == "Hazel & Walnut", **sure}
        if "landmarks" not in tree:
            return {"serves": ["Nut shop", "Hazel & Walnut"]}
        return {"landmark": label_of(tree, "Hazel & Walnut"), "alternatives": [], **sure}

    marks = [*CITY[:5000], Candidate(5, "Hazel & Walnut"), *CITY[5000:]]
    model = model_at(serve(answers(knows)))
    assert model.choose("a bag of walnut kernels", marks).landmark == 5
    started = time.process_time()
    assert model.choose("hazel sticks", marks).landmark == 5
    assert time.process_time() - started < 3.0
