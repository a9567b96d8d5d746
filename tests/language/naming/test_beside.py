"""A slow model beside mapping: handing over and fetching never wait, and the latest evidence counts."""

import threading
import time
from collections.abc import Sequence

from lpslam.errors import UserError
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading
from lpslam.language.naming.beside import NamingBeside


class Slow:
    """Answers when it is let go, with the first reading in capitals."""

    model = "slow"

    def __init__(self, error: Exception | None = None) -> None:
        self.may_go = threading.Event()
        self.asked: list[str] = []
        self.error = error

    def name(self, readings: Sequence[Reading]) -> Naming:
        assert self.may_go.wait(10.0)
        self.asked.append(readings[0].text)
        if self.error is not None:
            raise self.error
        return Naming(readings[0].text.upper(), 0.9, "as told", self.model)

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        return []

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        return Choice(None, 0.0, "", self.model)


class Quick(Slow):
    model = "quick"

    def __init__(self) -> None:
        super().__init__()
        self.may_go.set()


def evidence(text: str, count: int = 1) -> list[Reading]:
    return [Reading(text, count, 0.9)]


def test_handing_over_and_fetching_do_not_wait() -> None:
    slow = Slow()
    beside = NamingBeside(slow, Quick())
    started = time.monotonic()
    for key in range(20):
        beside.ask(key, evidence(f"sign {key}"))
    assert beside.answers() == []
    assert time.monotonic() - started < 1.0
    slow.may_go.set()
    assert beside.finish(10.0) == 0
    assert {key: naming.name for key, naming in beside.answers()} == {key: f"SIGN {key}" for key in range(20)}
    assert beside.answers() == []


def test_of_several_questions_about_a_class_only_the_latest_is_put() -> None:
    slow = Slow()
    beside = NamingBeside(slow, Quick())
    beside.ask(0, evidence("being asked"))
    for count in range(1, 9):
        beside.ask(1, evidence(f"after {count}", count))
    slow.may_go.set()
    beside.finish(10.0)
    assert slow.asked[-1] == "after 8"
    assert len(slow.asked) <= 3
    assert dict(beside.answers())[1].name == "AFTER 8"


def test_the_same_evidence_is_not_asked_about_again() -> None:
    quick = Quick()
    beside = NamingBeside(quick, Quick())
    for _ in range(5):
        beside.ask(3, evidence("Gucci"))
        assert beside.finish(10.0) == 0
    assert quick.asked == ["Gucci"]
    beside.ask(3, evidence("Gucci", 2))
    beside.finish(10.0)
    assert quick.asked == ["Gucci", "Gucci"]


def test_an_error_gives_the_other_models_name_and_says_so() -> None:
    slow = Slow(UserError("the key was refused"))
    slow.may_go.set()
    beside = NamingBeside(slow, Quick())
    beside.ask(0, evidence("gucci"))
    beside.finish(10.0)
    ((_, naming),) = beside.answers()
    assert naming.name == "GUCCI"
    assert naming.model == "quick (instead of slow)"
    assert "the key was refused" in naming.evidence


def test_a_silent_model_does_not_hold_up_the_end() -> None:
    slow = Slow()
    beside = NamingBeside(slow, Quick())
    for key in range(3):
        beside.ask(key, evidence(f"sign {key}"))
    started = time.monotonic()
    assert beside.finish(0.1) == 3
    assert time.monotonic() - started < 2.0
    slow.may_go.set()
    beside.finish(10.0)
    assert len(slow.asked) == 1, "what was not put at the end is dropped"
