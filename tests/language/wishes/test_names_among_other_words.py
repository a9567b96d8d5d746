"""Names that stand in a question beside other words, other scripts and slips; and people by their titles."""

import pytest
from asking import solved

from lpslam.language.offline import OfflineModel

MODEL = OfflineModel()
BOARDS = [
    ("Juwelier Caspar",),
    ("Ebert & Meyer",),
    ("Larkvale",),
    ("Price Optics",),
    ("Morris Books",),
    ("El Águila verde",),
    ("悦来面馆",),
    ("나래 약국",),
    ("青葉通り",),
    ("Dr. Douglas Boyle",),
    ("Prof. Winter",),
    ("岡本先生",),
    ("盛医生",),
    ("진 원장",),
    ("Human Resources",),
    ("Erste Hilfe",),
    ("サウナ",),
]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Ich möchte zu Juwelier Caspar, weil ich dort etwas abgeben muss", "Juwelier Caspar"),
        ("Führe mich zu Larkvale, meine Kollegin wartet dort", "Larkvale"),
        ("Ich möchte zu Ebert, weil ich dort etwas abgeben muss", "Ebert & Meyer"),
        ("I'm supposed to meet someone at Price", "Price Optics"),
        ("¿Me puede acompañar a el águila verde? Me están esperando", "El Águila verde"),
        ("Emmène-moi à 悦来", "悦来面馆"),
        ("我要去悦来", "悦来面馆"),
        ("나래 어디예요?", "나래 약국"),
        ("Sorry to bother you, I'm trying to find 青葉通り, my brother is waiting there", "青葉通り"),
        ("Ich möchte zu Erste Hilfe, weil ich dort etwas abgeben muss", "Erste Hilfe"),
    ],
)
def test_a_name_is_found_whatever_else_is_said(question: str, expected: str) -> None:
    assert solved(MODEL, question, BOARDS) == [expected]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("I'm supposed to meet someone at Dr. Dougls Boyle", "Dr. Douglas Boyle"),
        ("where is Prof. Wintrr", "Prof. Winter"),
        ("Zeig mir bitte den Weg zu 岡本教授", "岡本先生"),
        ("岡本教授 쪽으로 가려면 어떻게 하죠", "岡本先生"),
        ("我在找盛教授", "盛医生"),
        ("진 선생님로 데려다 줘", "진 원장"),
        ("Professor Boyleはどこ？", "Dr. Douglas Boyle"),
        ("时医生在哪", None),
        ("Dr. Wagner", None),
    ],
)
def test_a_person_is_found_by_any_title(question: str, expected: str | None) -> None:
    assert solved(MODEL, question, BOARDS) == [expected]


@pytest.mark.parametrize("question", ["I need a lady doctor", "我想看女医生", "サウナの後に冷たい水に飛び込みたい"])
def test_common_words_name_nobody(question: str) -> None:
    assert solved(MODEL, question, BOARDS) == [None]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Wo ist die Bäckerei Wernecke?", "Bäckerei Wernecke"),
        ("Ich suche Bäckerei Oestrovsky", None),
        ("¿Cómo llego a Panadería Cuéllar?", None),
        ("Hunter Pharmacy, please", None),
        ("where is a pharmacy", "Walters Pharmacy"),
        ("Wo ist die Bäckerei Becker?", None),
        ("Bäckerei Vernecke", "Bäckerei Wernecke"),
    ],
)
def test_one_of_a_kind_is_no_other_of_it(question: str, expected: str | None) -> None:
    boards = [("Bäckerei Wernecke",), ("Walters Pharmacy",), ("Book Corner",)]
    assert solved(MODEL, question, boards) == [expected]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("El camino a El Águila verde, si es tan amable", "El Águila verde"),
        ("¿sería tan amable de decirme dónde está Larkvale?", "Larkvale"),
        ("恐れ入りますが、青葉通りを教えていただけますか", "青葉通り"),
        ("Oye, ¿El Águila verde está lejos?", "El Águila verde"),
        ("the man said Larkvale, is that far?", "Larkvale"),
        ("ma sœur m'attend devant Larkvale", "Larkvale"),
        ("we meet next to Larkvale", "Larkvale"),
        ("Hätten Sie die Güte, mich zu Larkvale zu begleiten?", "Larkvale"),
        ("나래 약국 앞에서 보자", "나래 약국"),
        ("이 길이 나래 약국 가는 길 맞아요?", "나래 약국"),
        ("悦来面馆是走这边吗", "悦来面馆"),
        ("听说悦来面馆就在这附近", "悦来面馆"),
        ("나래 약국이 이 근처라고 들었어요", "나래 약국"),
        ("En route pour Larkvale", "Larkvale"),
        ("青葉通りってどの辺り？", "青葉通り"),
        ("나래 약국 가는 길 좀", "나래 약국"),
        ("I was told to report to Doctor Boyle at nine", "Dr. Douglas Boyle"),
        ("去悦来，快一点", "悦来面馆"),
        ("有人知道盛教授在哪儿吗", "盛医生"),
    ],
)
def test_ways_of_asking_are_no_relations_refusals_or_hours(question: str, expected: str) -> None:
    assert solved(MODEL, question, BOARDS) == [expected]


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("ボイル先生（Dr Boyle）の部屋はどちらですか", "Dr. Douglas Boyle"),
        ("三号眼镜店（Price Optics）怎么走", "Price Optics"),
        ("라크베일 2호점(Larkvale) 어디예요?", "Larkvale"),
    ],
)
def test_a_name_in_brackets_and_another_script_is_what_the_board_says(question: str, expected: str) -> None:
    assert solved(MODEL, question, BOARDS) == [expected]


@pytest.mark.parametrize("question", ["哪里可以充电（USB）", "toilets (Ladies)", "喝咖啡（Larkvale也行）"])
def test_other_brackets_stay_what_they_are(question: str) -> None:
    (stop,) = MODEL.read_wish(question).stops
    assert "(" in stop.what
