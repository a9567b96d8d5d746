"""Relations, plans and refusals of worlds that are drawn."""

import importlib
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"
LEAST, MOST_WRONG = {"ways": 0.95, "other ways": 0.95, "third ways": 0.8}, 0.15


@pytest.fixture
def drawn_relations(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("drawn_relations")


def test_a_seed_draws_the_same_worlds(drawn_relations: ModuleType) -> None:
    assert drawn_relations.drawn(3, 2) == drawn_relations.drawn(3, 2) != drawn_relations.drawn(4, 2)


def test_what_is_expected_is_one_board(drawn_relations: ModuleType) -> None:
    for world in drawn_relations.drawn(5, 40)["worlds"].values():
        names = [place["name"] for place in world["places"]]
        for wish in world["wishes"]:
            expected = [wish["expected"]] if isinstance(wish["expected"], str) else wish["expected"] or []
            assert all(each.split("@")[0] in names for each in expected)
            assert "{" not in wish["question"]


@pytest.mark.parametrize("ways", list(LEAST))
def test_what_stands_in_a_relation_is_found(drawn_relations: ModuleType, ways: str) -> None:
    score = importlib.import_module("drawn_names").score
    counts = score(drawn_relations.drawn(1, 12, ways)["worlds"])
    total = sum((count for key, count in counts.items() if not key.startswith("language")), Counter())
    assert total["right"] >= LEAST[ways] * total.total()
    assert total["wrong"] <= MOST_WRONG * total.total()
