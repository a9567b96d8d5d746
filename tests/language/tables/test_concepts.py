"""Concepts of buildings: one entry serves signs and questions in every language."""

import numpy as np
import pytest

from lpslam.language.languages import LANGUAGES
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.concepts import APART, load_buildings
from lpslam.language.tables.knowledge import Knowledge
from lpslam.navigation.places import Here, Place, Point
from lpslam.navigation.solver import solve


def test_every_new_concept_is_asked_for_in_every_language() -> None:
    entries: dict[str, set[str]] = {}
    for entry in load_buildings().concepts:
        said = {each for each in LANGUAGES if entry.signs.get(each) or entry.asked.get(each) or entry.apart.get(each)}
        if entry.signs:
            entries.setdefault(entry.name, set()).update(said)
    # English, Chinese, Japanese and Korean have these words in another table.
    entries.pop("shop/newsagent")
    lacking = {name: set(LANGUAGES) - said for name, said in entries.items() if len(said) < len(LANGUAGES)}
    assert not lacking


def test_words_that_stand_apart_are_parts() -> None:
    for entry in load_buildings().concepts:
        assert all(len(parts) > 1 and all(parts) for rows in entry.apart.values() for parts in rows), entry.name
        assert not any(APART in joined for joined in entry.asked.values()), entry.name


def test_shares_are_shares(knowledge: Knowledge) -> None:
    for entry in load_buildings().concepts:
        assert all(0.0 < share <= 1.0 for share in entry.sellers.values()), entry.name
        assert all(knowledge.share(entry.name, kind) > 0.0 for kind in entry.sellers), entry.name


@pytest.mark.parametrize(
    ("sign", "question"),
    [
        ("Elefantenhaus", "코끼리를 보고 싶어요"),
        ("Skiverleih", "I want to rent skis"),
        ("沙发", "Ich suche ein Sofa"),
        ("Vestuario femenino", "女更衣室在哪里"),
        ("Rüstkammer", "騎士の鎧を見たい"),
    ],
)
def test_a_sign_in_one_language_is_asked_for_in_another(sign: str, question: str) -> None:
    model = OfflineModel()
    marks = [Candidate(0, "Toilets"), Candidate(1, sign), Candidate(2, "Café")]
    assert model.choose(question, marks).landmark == 1


BOATS = [("Pier 1", "Helsinki"), ("Pier 2", "Stockholm"), ("Pier 3", "Oslo · Göteborg")]


def point(at: int) -> Point:
    return np.array([8.0 * at, 0.0, 0.0])


def sailed(question: str) -> str | None:
    """Where someone goes on board."""
    marks = [Candidate(at, name, (), (line,)) for at, (name, line) in enumerate(BOATS)]
    places = [Place(at, name, point(at)) for at, (name, _) in enumerate(BOATS)]
    model = OfflineModel()
    solution = solve(model.read_wish(question), places, model.scorer(marks), Here(point(0)))
    place = solution.stops[-1].place
    return None if place is None else place.name


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("The boat to Gothenburg", "Pier 3"),
        ("去斯德哥尔摩的船", "Pier 2"),
        ("ヘルシンキ行きの船に乗りたい", "Pier 1"),
        ("Le ferry pour Marseille", None),
    ],
)
def test_a_numbered_board_says_in_its_other_lines_where_it_leads(question: str, expected: str | None) -> None:
    assert sailed(question) == expected


def test_a_sign_for_a_want_is_no_sign_for_all_that_will_do() -> None:
    assert "facility/business_center" not in dict(load_sign_reader().read("Photocopies").kinds)
