"""Names, people and numbers of worlds that are drawn."""

import importlib
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"
LEAST, MOST_WRONG = 0.97, 0.02


@pytest.fixture
def drawn_names(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("drawn_names")


def test_a_seed_draws_the_same_worlds(drawn_names: ModuleType) -> None:
    assert drawn_names.drawn(3, 2) == drawn_names.drawn(3, 2) != drawn_names.drawn(4, 2)


def test_what_is_expected_stands_on_a_board(drawn_names: ModuleType) -> None:
    for world in drawn_names.drawn(5, 40)["worlds"].values():
        names = [place["name"] for place in world["places"]]
        assert len(set(names)) == len(names)
        assert all(wish["expected"] is None or wish["expected"] in names for wish in world["wishes"])


def test_names_and_numbers_of_drawn_worlds_are_found(drawn_names: ModuleType) -> None:
    counts = drawn_names.score(drawn_names.drawn(1, 12)["worlds"])
    total = sum((count for key, count in counts.items() if not key.startswith("language")), Counter())
    assert total["right"] >= LEAST * total.total()
    assert total["wrong"] <= MOST_WRONG * total.total()
