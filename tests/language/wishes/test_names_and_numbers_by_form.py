"""Names, numbers, persons and refusals that the form of a question tells, whatever its words."""

from collections.abc import Sequence

import pytest

from language.asking import solved
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.codes import asked_codes

MODEL = OfflineModel()


def found(question: str, boards: Sequence[Sequence[str]]) -> str | None:
    return solved(MODEL, question, boards)[-1]


@pytest.mark.parametrize(
    ("question", "names", "expected"),
    [
        ("Suite Lindensee", ("Suite Linden See", "Suite Uferweg", "Frühstück"), "Suite Linden See"),
        ("feuerlösch übungplatz", ("Feuerlöschübungsplatz", "Übungshaus", "Werkstatt"), "Feuerlöschübungsplatz"),
    ],
)
def test_a_name_is_found_spaces_and_slips_aside(question: str, names: Sequence[str], expected: str) -> None:
    assert found(question, [(name,) for name in names]) == expected


@pytest.mark.parametrize(("question", "expected"), [("silo 12", "Silos 9–20"), ("silo 31", None)])
def test_a_number_of_what_is_numbered_otherwise_is_none(question: str, expected: str | None) -> None:
    assert found(question, [("Silos 1–8",), ("Silos 9–20",), ("Büro",)]) == expected


def test_a_number_with_a_point_stands_among_hundreds() -> None:
    assert found("532.4, please", [("000–299",), ("300–599",), ("600–999",)]) == "300–599"
    assert found("room 3.5", [("Rooms 1–6",), ("Café",)]) is None


def test_a_door_may_be_a_gate() -> None:
    assert found("door 5", [("Porte 2",), ("Porte 5",), ("Café",)]) == "Porte 5"


def test_a_word_that_only_begins_like_a_row_numbers_nothing() -> None:
    assert all("aisle" not in code.of for code in asked_codes("第三排练室"))
    assert any("aisle" in code.of for code in asked_codes("第三排"))


def test_before_a_person_is_with_them() -> None:
    boards = [("Greffe",), ("Cabinet", "Mme Dunoyer"), ("Accueil",)]
    assert found("je dois comparaître devant Mme Dunoyer", boards) == "Cabinet"


def test_a_person_is_heard_in_another_script() -> None:
    assert (
        found("ブランドルフ博士に会いたい", [("Labor",), ("Direktion", "Dr. Clara Brandolf"), ("Lager",)])
        == "Direktion"
    )


@pytest.mark.parametrize(
    ("question", "names", "expected"),
    [
        ("休憩室はどこですか、男性用じゃないほうです", ("休憩室 男性", "休憩室 女性", "受付"), "休憩室 女性"),
        ("Los vestuarios, pero no los de hombres", ("Umkleide Damen", "Umkleide Herren", "Bad"), "Umkleide Damen"),
    ],
)
def test_for_whom_a_place_is_refuses_it(question: str, names: Sequence[str], expected: str) -> None:
    assert found(question, [(name,) for name in names]) == expected


def test_the_house_that_the_map_is_of_is_not_asked_for() -> None:
    boards = [(name,) for name in ("Pharmacy", "Ward 3", "Radiology", "Admissions", "Café", "Toilets")]
    assert found("is there a chemist's inside the hospital?", boards) == "Pharmacy"
