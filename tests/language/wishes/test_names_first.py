"""What stands on a board is found when it is asked for, before any intent."""

import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.wishes.names import Names

BOARDS = (
    "GRAND STREET 1070 a cowte m 653",
    "New Arrivals",
    "Meeting Room Everest",
    "Meeting Room Alpha",
    "Schneiderei Kaya",
    "Prof. Dr. Ines Weber – Room 12",
    "王府井",
    "Dairy & Eggs",
    "Aisle 7 Pasta Rice Sauces",
    "coffee pizza wc shoes bank",
    "Starbucks",
    "Teehaus Jasmin",
    "レストラン つばめ Restaurant Swallow",
    "百草堂大药房",
    "Modigliani",
    "Shift Office",
    "Dr. Elif Yılmaz",
    "Gril lGarden",
    "Mesa de Infromación Turística",
)


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


def found(model: OfflineModel, question: str) -> set[str]:
    served = model.scorer([Candidate(at, name) for at, name in enumerate(BOARDS)]).serve(
        model.read_wish(question).stops[0]
    )
    top = max(served.scores.values(), default=0.0)
    return {BOARDS[id_] for id_, score in served.scores.items() if score == top}


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Where is Grand Street?", BOARDS[0]),
        ("New Arrivals", BOARDS[1]),
        ("Tehaus Jasmin", BOARDS[11]),
        ("つばめ", BOARDS[12]),
        ("百草唐", BOARDS[13]),
        ("モディリアーニ", BOARDS[14]),
        ("report to the shift office", BOARDS[15]),
        ("Everest", BOARDS[2]),
        ("Sala Everest", BOARDS[2]),
        ("meeting room Alpha", BOARDS[3]),
        ("Wo ist Frau Weber?", BOARDS[5]),
        ("Wangfujing", BOARDS[6]),
        ("beurre", BOARDS[7]),
        ("牛奶在哪里", BOARDS[7]),
        ("Doktor Yilmaz", BOARDS[16]),
        ("the grill garden", BOARDS[17]),
        ("la mesa de información turística", BOARDS[18]),
    ],
)
def test_a_name_is_found(model: OfflineModel, question: str, expected: str) -> None:
    assert found(model, question) == {expected}


@pytest.mark.parametrize("question", ["Dr. Schneider", "meeting room Gamma", "room 13", "gate B7"])
def test_what_stands_on_no_board_abstains(model: OfflineModel, question: str) -> None:
    assert not found(model, question)


def test_a_name_that_is_refused_is_not_found(model: OfflineModel) -> None:
    assert "Starbucks" not in found(model, "coffee, but not at Starbucks")


@pytest.mark.parametrize(
    ("question", "board"),
    [("la bibli", "Bibliothèque"), ("adoptieren", "Zimmer 9 Adoption"), ("la carni", "Carnicería Paco")],
)
def test_words_that_begin_alike_speak_for_a_board(question: str, board: str) -> None:
    names = Names(
        [Candidate(at, name) for at, name in enumerate((board, "Salle 3", "Kasse"))],
        load_knowledge(),
        load_sign_reader().repair,
    )
    words = [names.akin(word) for word in load_knowledge().folder.units(question)]
    assert set().union(*words) == {0}


def test_several_common_words_of_a_name_go_before_what_one_of_them_means(model: OfflineModel) -> None:
    boards = ("Bar The Frozen Lion", "Lion House", "Aviary")
    served = model.scorer([Candidate(at, name) for at, name in enumerate(boards)]).serve(
        model.read_wish("frozen lion").stops[0]
    )
    assert set(served.scores) == {0}
