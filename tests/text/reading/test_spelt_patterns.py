"""Spellings of patterns and of texts."""

import random

import pytest

from lpslam.simulation import lexicon
from lpslam.text.reading.spelt_patterns import CLEAR, SUSPECT, pattern_odds


@pytest.mark.parametrize("read", ["XOXOXO", "OXOXOXO", "XO□XO□XO", "QGGGGGG", "XXXX", "IHIHIHIH", "mnmnmnm"])
def test_rows_of_motifs_are_patterns_by_their_spelling(read: str) -> None:
    assert pattern_odds(read) >= CLEAR


@pytest.mark.parametrize("read", ["GGGL", "GGCG", "TITIT"])
def test_pieces_of_patterns_are_suspect(read: str) -> None:
    assert SUSPECT <= pattern_odds(read) < CLEAR


@pytest.mark.parametrize(
    "painted",
    [
        "LILLI",
        "BANANA",
        "MISSISSIPPI",
        "0000",
        "888",
        "WWW",
        "XOXO",
        "COCO",
        "1000",
        "100%",
        "三三",
        "24015172",
        "7-11",
    ],
)
def test_words_and_numbers_of_equal_letters_are_not(painted: str) -> None:
    assert pattern_odds(painted) < CLEAR


@pytest.mark.parametrize("painted", ["佳佳超市", "丽丽美发", "笑笑", "咚咚"])
def test_a_character_that_is_doubled_once_is_no_motif(painted: str) -> None:
    assert pattern_odds(painted) < SUSPECT


@pytest.mark.parametrize("read", ["日日", "口口", "凹凸", "回回回", "佳佳佳"])
def test_frames_and_what_comes_three_times_are(read: str) -> None:
    assert pattern_odds(read) >= SUSPECT


def test_names_of_signs_are_never_patterns() -> None:
    names = {line for each in lexicon.EVERYTHING for line in (each.english, each.chinese) if line}
    assert [name for name in names if pattern_odds(name) >= SUSPECT and len(name) > 4] == []


def test_numbers_by_chance_are_no_patterns() -> None:
    rng = random.Random(3)
    numbers = [str(rng.randrange(10_000_000, 99_999_999)) for _ in range(2000)]
    assert sum(pattern_odds(number) >= CLEAR for number in numbers) <= 1
    assert sum(pattern_odds(number) >= SUSPECT for number in numbers) < 20
