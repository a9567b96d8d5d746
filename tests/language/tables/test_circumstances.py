"""What people tell of themselves, and how boards of usual rooms are painted, in one language each."""

import pytest
from asking import chosen

from lpslam.language.choosing.serving import match
from lpslam.language.offline import OfflineModel
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import Knowledge

ROOMS = ("Toilettes", "Reception", "Ascensor", "食堂", "Notaufnahme")


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("My sister had her baby, she has just lost her waters... sorry, her waters broke an hour ago", "Maternité"),
        ("Je dois venir à jeun, on va me prendre du sang", "채혈실"),
        ("Ich muss umbuchen, ich habe den Anschluss verpasst", "きっぷうりば"),
        ("me he mudado la semana pasada y quiero empadronarme", "Bürgerbüro"),
        ("家里菜刀切不动了", "Rémouleur"),
        ("フォークリフトの電池がないので充電したい", "Ladestation Stapler"),
        ("영수증 정산 때문에 왔어요, 출장비요", "Buchhaltung"),
        ("mon fils bégaie depuis l'école", "Logopädie"),
    ],
)
def test_who_tells_what_happened_is_led_to_who_helps(model: OfflineModel, question: str, board: str) -> None:
    assert chosen(model, question, *ROOMS, board) == board


@pytest.mark.parametrize(
    ("board", "kind"),
    [
        ("Patient Check-in", "facility/registration"),
        ("讨论室", "facility/study_room"),
        ("자동차 전시장", "shop/car"),
        ("Gepäckreklamation", "facility/lost_baggage"),
        ("Oficina del consumidor", "civic/consumer_advice"),
        ("Salle des familles", "care/family_room"),
        ("ディスカッションルーム", "facility/study_room"),
    ],
)
def test_a_board_says_its_room(board: str, kind: str, knowledge: Knowledge) -> None:
    assert match(kind, load_sign_reader().read(board).kinds, knowledge) >= 0.9
