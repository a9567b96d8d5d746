"""Names that are spelt by ear: of few consonants where all that is asked for is heard, and never of another."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

BOARDS = (
    *("Phoenix Dental", "Café Quito", "Yoga Loft", "Geneva Lounge", "Ticket Hall", "수족관 안내소", "优衣堂"),
    *("Grundsicherungsamt", "Bauamt", "Quilt & Craft"),
)
MODEL = OfflineModel()


def found(question: str, boards: tuple[str, ...] = BOARDS) -> str | None:
    return solved(MODEL, question, [(name,) for name in boards])[-1]


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("where's feenix dentl", "Phoenix Dental"),
        ("kafay keeto", "Café Quito"),
        ("the joga loft", "Yoga Loft"),
        ("jeneva lounge please", "Geneva Lounge"),
        ("kwilt and kraft", "Quilt & Craft"),
        ("수종관 안내소", "수족관 안내소"),
        ("优依堂在哪里", "优衣堂"),
    ],
)
def test_a_name_is_found_as_it_is_heard(question: str, board: str) -> None:
    assert found(question) == board


def test_a_name_is_heard_beside_a_call() -> None:
    assert found("ねえ鶴の間ってどこ", ("宴会場 鶴の間", "宴会場 亀の間", "フロント")) == "宴会場 鶴の間"


@pytest.mark.parametrize("question", ["シルバースワンズはどこですか", "실버 스완즈라는 데가 어디예요"])
def test_a_name_in_the_plural_is_heard_in_another_script(question: str) -> None:
    assert found(question, ("Silver Swans Dance School", "Nursery", "Toilets")) == "Silver Swans Dance School"


def test_a_sentence_is_not_heard_as_a_shorter_name() -> None:
    assert found("촬영한 영상을 잘라 붙여야 해요", ("촬영장비 대여", "식당", "주차장")) is None


def test_a_long_name_with_a_slip_goes_before_what_its_words_mean() -> None:
    assert found("Grundsicherungsamt", ("Grundsicherugsamt", "Sozialamt", "Bauamt")) == "Grundsicherugsamt"


@pytest.mark.parametrize(
    "question",
    [
        "somebody has fenced the kwarrel",
        "the phonograph mender",
        "where do I find Quentin",
        "a tackle shop for anglers",
    ],
)
def test_a_few_sounds_in_a_longer_question_are_no_name(question: str) -> None:
    assert found(question) is None


def test_of_two_names_that_sound_the_same_none_is_guessed() -> None:
    assert found("feeniks", ("Feenyx", "Fenyx", "Bauamt")) is None


def test_a_name_of_another_script_stands_by_itself_among_other_words() -> None:
    boards = ("The Heron Bar", "Puppy Room", "湯上がり処 つばき", "Dramaturgie", "Cae Onnen / Ash Field", "Reception")
    for question, board in (
        ("헤론 바", "The Heron Bar"),
        ("퍼피룸 어디예요?", "Puppy Room"),
        ("츠바키라는 쉬는 곳이요", "湯上がり処 つばき"),
        ("드라마투르기 사무실이 어디예요", "Dramaturgie"),
        ("アッシュフィールドってどこですか", "Cae Onnen / Ash Field"),
        ("텔레비전 어디예요", None),
    ):
        assert found(question, boards) == board
