"""Naming against a reader of signs that loses spaces, drops letters and confuses those that look alike."""

import random
from collections import Counter
from pathlib import Path

import pytest

from lpslam.evaluation.language import read_cases
from lpslam.language.model import Reading
from lpslam.language.naming.voting import vote
from lpslam.language.offline import embedded_model

SETS = Path(__file__).parents[3] / "benchmarks" / "language"
ALIKE = {
    "o": "0",
    "O": "0Q",
    "l": "1I",
    "I": "l1",
    "i": "l",
    "E": "F",
    "C": "G",
    "S": "5",
    "B": "8",
    "U": "V",
    "e": "c",
}


def misread(text: str, rng: random.Random, rate: float) -> str:
    letters: list[str] = []
    for ch in text:
        draw = rng.random()
        if (ch == " " and rng.random() < 0.6) or rate < draw < 1.3 * rate:
            continue
        letters.append(rng.choice(ALIKE.get(ch, "xrnI") if ch.isascii() else "口日大木人土") if draw < rate else ch)
    return "".join(letters)


def letters_of(text: str) -> str:
    return "".join(ch for ch in text.casefold() if ch.isalnum())


@pytest.fixture(scope="module")
def signs() -> list[str]:
    cases = read_cases(SETS / "third.json"), read_cases(SETS / "fourth.json")
    return sorted({name for case in cases for name in case.choosing[0].landmarks if len(name) > 2})


@pytest.mark.parametrize(("rate", "count", "floor"), [(0.05, 8, 0.97), (0.1, 8, 0.93), (0.1, 3, 0.8)])
def test_most_signs_are_named_as_painted(signs: list[str], rate: float, count: int, floor: float) -> None:
    model = embedded_model()
    rng = random.Random(7)
    right = frequent = 0
    for sign in signs:
        spellings = Counter(misread(sign, rng, rate) for _ in range(count))
        readings = [Reading(text, times, 0.9) for text, times in spellings.items()]
        right += letters_of(model.name(readings).name) == letters_of(sign)
        frequent += letters_of(spellings.most_common(1)[0][0]) == letters_of(sign)
    assert right >= floor * len(signs)
    assert right > frequent


def test_a_space_that_a_few_readings_kept_stays() -> None:
    readings = [Reading("GoldenWok", 5, 0.9), Reading("Golden Wok", 3, 0.9)]
    assert vote(readings).text == "Golden Wok"


def test_confidence_weighs_like_count() -> None:
    assert vote([Reading("cat", 1, 0.9), Reading("cot", 1, 0.3), Reading("cot", 1, 0.4)]).text == "cat"
    assert vote([Reading("cat", 1, 0.9), Reading("cot", 3, 0.4)]).text == "cot"


def test_agreement_falls_with_disagreement() -> None:
    sure = vote([Reading("HUAWEI", 4, 0.9)]).agreement
    unsure = vote([Reading("HUAWEI", 4, 0.9), Reading("HUBXEI", 2, 0.9)]).agreement
    assert 0.0 < unsure < sure <= 1.0


def test_a_logo_read_as_a_letter_and_a_brand_at_the_head_of_a_name() -> None:
    counts = {"C心胜客欢乐餐厅": 4, "必胜客欢乐餐厅": 3, "心胜客欢乐餐厅": 2, "C必胜客欢乐餐厅": 2}
    readings = [Reading(text, count, 0.85) for text, count in counts.items()]
    assert embedded_model().name(readings).name == "必胜客欢乐餐厅"
    assert embedded_model().name([Reading("C绿手指", 5, 0.9), Reading("绿手指", 4, 0.9)]).name == "绿手指"
    # Where nearly every reading has the letter, it is painted.
    assert embedded_model().name([Reading("K歌之王", 5, 0.95), Reading("歌之王", 1, 0.9)]).name == "K歌之王"
    # A slogan read cut off more often than whole.
    assert embedded_model().name([Reading("买一送", 8, 0.95), Reading("买一送一", 3, 0.97)]).name == "买一送一"


def test_rarer_words_that_signs_are_painted_with_are_known_in_any_name() -> None:
    for wrong, right in (("Orsol Tlahouse", "Orsol Teahouse"), ("ORSOL CHOESECAKE", "ORSOL CHEESECAKE")):
        named = embedded_model().name([Reading(wrong, 5, 0.93, 0.6, 2.0), Reading(right, 4, 0.93, 0.6, 2.0)])
        assert named.name == right
        assert named.confidence > 0.9
