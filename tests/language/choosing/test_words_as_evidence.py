"""The words of a question as evidence for places."""

from collections.abc import Iterator

import pytest

from lpslam.language.choosing import evidence
from lpslam.language.choosing.evidence import Heard, Support
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.concepts import load_associations
from lpslam.language.tables.knowledge import load_knowledge

NAMES = ("Reception", "Quality Control", "IT Support", "Canteen", "Dermatology", "Bicycle Parking", "Toilets")


def marks_of(names: tuple[str, ...]) -> list[Candidate]:
    return [Candidate(id_, name) for id_, name in enumerate(names)]


def chosen(question: str, names: tuple[str, ...] = NAMES) -> str | None:
    found = OfflineModel().choose(question, marks_of(names)).landmark
    return None if found is None else names[found]


def support_of(names: tuple[str, ...]) -> Support:
    knowledge = load_knowledge()
    index = LandmarkIndex(marks_of(names), load_sign_reader(), knowledge)
    return Support(index, lambda word: (), lambda word: (), knowledge)


def weights(heard: Heard, word: str) -> dict[str, float]:
    concepts, weights = heard.weights(word)
    return {heard.concepts[int(at)]: float(each) for at, each in zip(concepts, weights, strict=True)}


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("who inspects whether parts meet tolerances", "Quality Control"),
        ("skin specialists", "Dermatology"),
        ("自転車を停車する場", "Bicycle Parking"),
    ],
)
def test_other_words_for_what_is_known_are_understood(question: str, expected: str) -> None:
    assert chosen(question) == expected


@pytest.mark.parametrize(
    "question", ["quantum flibbertigibbets", "zzzz", "", "Is there a casino?", "a kilogram of xenon"]
)
def test_what_nothing_speaks_for_is_not_guessed(question: str) -> None:
    assert chosen(question) is None


def test_what_words_speak_for_is_less_sure_than_what_is_read_and_says_which_words() -> None:
    guess = OfflineModel().choose("who inspects whether parts meet tolerances", marks_of(NAMES))
    read = OfflineModel().choose("Where are the toilets?", marks_of(NAMES))
    assert guess.confidence < read.confidence
    assert "tolerance" in guess.evidence
    assert "Quality Control" in guess.evidence


def test_several_weak_words_outweigh_one_strong_one() -> None:
    question = "there is a bench outside, but my poodle's fur must be clipped and brushed and the claws cut"
    found = support_of(("Seats", "Pet Grooming")).of(question, "en", {})
    assert max(found.scores, key=lambda id_: found.scores[id_]) == 1


def test_what_is_read_by_the_tables_weighs_as_well() -> None:
    support = support_of(("Pharmacy", "Dermatology"))
    without = support.of("my skin itches", "en", {}).scores
    read = support.of("my skin itches", "en", {0: 1.0}).scores
    assert read[0] / read.get(1, 1e-9) > without.get(0, 1e-9) / without[1]


def test_a_word_that_few_concepts_share_says_more() -> None:
    heard = Heard("en", load_knowledge())
    common, rare = weights(heard, "place"), weights(heard, "forklift")
    assert max(rare.values()) > max(common.values(), default=0.0)


def test_other_forms_and_parts_of_compounds_are_heard() -> None:
    knowledge = load_knowledge()
    english, german = Heard("en", knowledge), Heard("de", knowledge)
    assert weights(english, "swimming").keys() & weights(english, "swim").keys()
    assert weights(german, "bibliotheksausweis").keys() & weights(german, "bibliothek").keys()


def test_pairs_of_characters_stay_within_words_that_spaces_part() -> None:
    terms = Heard("ko", load_knowledge()).terms("수영장 어디")
    assert "수 영" in terms
    assert "영 장" in terms
    assert "장 어" not in terms


def test_associated_words_are_heard(monkeypatch: pytest.MonkeyPatch) -> None:
    def said(language: str) -> Iterator[tuple[str, list[str]]]:
        yield "shop/optician", ["zorbled goggles"]

    knowledge = load_knowledge()
    assert not weights(Heard("en", knowledge), "zorbled")
    monkeypatch.setattr(evidence, "load_associations", said)
    assert weights(Heard("en", knowledge), "zorbled").keys() == {"shop/optician"}


@pytest.mark.parametrize("language", ["en", "zh", "ja", "ko", "es", "de", "fr"])
def test_associations_are_of_concepts_that_some_place_serves(language: str) -> None:
    knowledge = load_knowledge()
    named = {concept for meaning in knowledge.spoken(language).values() for concept, _ in meaning.concepts}
    known = named | knowledge.offers.keys()
    unknown = {concept for concept, _ in load_associations(language) if concept not in known}
    assert not unknown
