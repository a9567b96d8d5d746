"""Names of Chinese characters, asked for by their sound: in kana, in Latin letters, or in other characters."""

from collections.abc import Sequence

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.aloud import named_aloud, sounds_of

INN = ("大浴場 雪見の湯", "食事処 さざなみ亭", "会議室 白鳥", "売店", "ラウンジ 月光閣", "Fitness Room")
SCHOOL = ("报告厅 明德厅", "琵琶教室", "书画室", "医务室")


@pytest.mark.parametrize(
    ("question", "names", "expected"),
    [
        ("ゆきみのゆはどちらですか", INN, INN[0]),
        ("さざなみていで食べたい", INN, INN[1]),
        ("Where is Sazanami Tei?", INN, INN[1]),
        ("はくちょうで会議があります", INN, INN[2]),
        ("げっこうかくに行きたい", INN, INN[4]),
        ("ゆきみのゆはどちらですか", ("", *INN), INN[0]),  # a board may say nothing
        ("枇杷教室在哪里", SCHOOL, SCHOOL[1]),
        ("明得厅怎么走", SCHOOL, SCHOOL[0]),
    ],
)
def test_a_name_is_found_by_its_sound(model: OfflineModel, question: str, names: Sequence[str], expected: str) -> None:
    assert solved(model, question, [(name,) for name in names]) == [expected]


@pytest.mark.parametrize(("question", "names"), [("ゆきのまはどこ", INN), ("Sazanami is where?", INN)])
def test_what_only_begins_so_is_another_name(model: OfflineModel, question: str, names: Sequence[str]) -> None:
    assert solved(model, question, [(name,) for name in names]) == [None]


def test_of_two_that_sound_so_none_is_told() -> None:
    sounds = sounds_of([("白鳥の間",), ("伯調",), ("白鳥",)])
    assert named_aloud("はくちょうはどこ", sounds) == set()
    assert named_aloud("はくちょうのまはどこ", sounds) == {0}


def test_another_character_of_another_sound_is_another_name() -> None:
    assert named_aloud("明月厅怎么走", sounds_of([("明德厅",)])) == set()


def test_words_of_kana_alone_are_no_names() -> None:
    assert named_aloud("サウナの後に冷たい水に入りたい", sounds_of([("サウナ",), ("水風呂",)])) == set()


def test_the_ending_of_a_verb_is_no_name() -> None:
    assert named_aloud("傘を置いてきてしまった", sounds_of([("喫茶", "汽笛"), ("かさ",)])) == set()


def test_a_name_of_very_many_readings_is_left_to_its_characters() -> None:
    assert list(sounds_of([("の" + "生" * 12,)])) == [" ".join(["no", *["sheng"] * 12])]
