"""Letters and numbers as people say them, found on boards; and what is wished where no board bears them."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()
BOARDS: tuple[tuple[str, ...], ...] = (
    ("Hall D",),
    ("Hall G",),
    ("HR Office",),
    ("PPE Issue Point",),
    ("Seminar 3.14",),
    ("Surgery 2", "Dr. P. Nair"),
    ("Surgery 3", "Dr. J. Brzezinski"),
    ("Assembly Line 1",),
    ("Assembly Line 2",),
    ("Ironmonger", "Screws · Nails"),
    ("Parking Nord",),
    ("卫生间",),
    ("3-6检票口",),
    ("咖啡馆",),
)


def found(question: str, boards: tuple[tuple[str, ...], ...] = BOARDS) -> str | None:
    return solved(MODEL, question, boards)[-1]


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("hall dee", "Hall D"),
        ("take me to hall gee please", "Hall G"),
        ("a class in three one four", "Seminar 3.14"),
        ("Vorlesung in drei eins vier", "Seminar 3.14"),
        ("un cours en trois cent quatorze", "Seminar 3.14"),
        ("Zu Doktor Nayr bitte", "Surgery 2"),
        ("I have an appointment with Doctor Bresinski", "Surgery 3"),
        ("any assembly line except number one", "Assembly Line 2"),
        ("eine Montagelinie, aber nicht Nummer zwei", "Assembly Line 1"),
        ("a bag of M6 screws", "Ironmonger"),
        ("哪个卫生间离3-6检票口近", "卫生间"),
        ("卫生间和咖啡馆中间夹着的是什么", "3-6检票口"),
    ],
)
def test_letters_and_numbers_are_found_as_they_are_said(question: str, board: str) -> None:
    assert found(question) == board


@pytest.mark.parametrize("question", ["y a dónde voy", "gate Q7", "three hundred people are coming", "Dr. Neumann"])
def test_what_stands_on_no_board_is_not_found(question: str) -> None:
    assert found(question) is None


@pytest.mark.parametrize("question", ["dejo el coche tres semanas", "mein Auto steht hier zwei Wochen"])
def test_a_time_in_words_is_no_number_of_a_car(question: str) -> None:
    assert not MODEL.read_wish(question).stops[0].identity


def test_of_toilets_a_wheelchair_goes_to_the_one_that_says_so() -> None:
    boards = (("WC Damen",), ("Behindertentoilette",), ("WC Herren",))
    assert found("Wo ist eine Toilette, ich sitze im Rollstuhl", boards) == "Behindertentoilette"


def test_a_canteen_that_is_a_cafe_serves_meals() -> None:
    boards = (("Kiosk", "Bratwurst · Zeitungen"), ("Cafeteria",))
    assert found("Ich möchte etwas Warmes essen", boards) == "Cafeteria"


NUMBERED: tuple[tuple[str, ...], ...] = (
    ("Lockers 1–60",),
    ("Lockers 61–120",),
    ("Rooms 301–320",),
    ("Offices", "3rd floor: 501–512 Planning"),
    ("Salle 16",),
    ("Stop North", "Bus 104 · 217"),
    ("2号诊室 陈医生",),
    ("304号 赵主任",),
    ("田中研究室",),
    ("김민수 교수 연구실",),
    ("Puertas B9–B16",),
    ("Café",),
)


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("My locker is the 37", "Lockers 1–60"),
        ("mine is locker number 88", "Lockers 61–120"),
        ("dreihundertfünf", "Rooms 301–320"),
        ("el dieciséis", "Salle 16"),
        ("seize", "Salle 16"),
        ("sixteen", "Salle 16"),
        ("三〇五", "Rooms 301–320"),
        ("삼공오", "Rooms 301–320"),
        ("room 505", "Offices"),
        ("where does the 217 stop", "Stop North"),
        ("wo hält der 217er", "Stop North"),
        ("salgo por la be doce", "Puertas B9–B16"),
        ("I fly from bee ten", "Puertas B9–B16"),
        ("陈大夫在哪", "2号诊室 陈医生"),
        ("找赵老师", "304号 赵主任"),
        ("Professor Tanaka Ichiro", "田中研究室"),
        ("Professor Ichiro Tanaka", "田中研究室"),
        ("김 선생님 방", "김민수 교수 연구실"),
    ],
)
def test_numbers_alone_and_people_by_another_title(question: str, board: str) -> None:
    assert found(question, NUMBERED) == board


@pytest.mark.parametrize("question", ["王大夫", "six hundred and five", "二百零五"])
def test_who_and_what_is_on_no_board_is_not_found(question: str) -> None:
    assert found(question, NUMBERED) is None
