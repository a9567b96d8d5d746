"""How wishes are put together, in seven languages: sides, nearest, left-out places, plans, numbers, comparisons."""

from functools import lru_cache

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import solve

NORTH = ["Bakery", "Pharmacy", "Toilets", "Bank", "Café Luna", "Gate 12", "Optician"]
SOUTH = ["Exit A", "Elevator", "Shoe Store", "Library", "Toilets", "Gate 27", "Exit B"]
"""Two rows of a corridor that runs east; each board faces the other row. Places are numbered along both."""
HERE = np.array([0.0, 3.0, 0.0])


@lru_cache(maxsize=1)
def model() -> OfflineModel:
    return OfflineModel()


def answer(question: str) -> list[str | None]:
    """The places of all stops, toilets by their number."""
    places, marks = [], []
    for row, y, facing in ((NORTH, 6.0, -1.0), (SOUTH, 0.0, 1.0)):
        for at, name in enumerate(row):
            id_ = len(places)
            places.append(Place(id_, name, np.array([8.0 * at, y, 0.0]), np.array([0.0, facing, 0.0])))
            marks.append(Candidate(id_, name))
    solution = solve(model().read_wish(question), places, model().scorer(marks), Here(HERE))
    found = [stop.place for stop in solution.stops]
    return [
        None if place is None else f"Toilets {place.id}" if place.name == "Toilets" else place.name for place in found
    ]


# A reader of the pharmacy's board looks north: the bakery is to the left of it, toilets 2 to the right.
FACING = [
    ("If I stand in front of the pharmacy, what is on the left?", "Bakery"),
    ("Facing the pharmacy, which place is directly to its right?", "Toilets 2"),
    ("What's to the right of the pharmacy when you look at it?", "Toilets 2"),
    ("Wenn man vor der Apotheke steht, was ist links davon?", "Bakery"),
    ("Mit Blick auf die Apotheke, was liegt rechts?", "Toilets 2"),
    ("Was ist rechts, wenn ich vor der Apotheke stehe?", "Toilets 2"),
    ("Si je suis devant la pharmacie, qu'est-ce qu'il y a à gauche ?", "Bakery"),
    ("En regardant la pharmacie, que trouve-t-on juste à droite ?", "Toilets 2"),
    ("Si me pongo frente a la farmacia, ¿qué hay a la izquierda?", "Bakery"),
    ("Mirando a la farmacia, ¿qué queda a la derecha?", "Toilets 2"),
    ("站在药店前面，左边是什么", "Bakery"),
    ("面对药店，右手边是哪一家？", "Toilets 2"),
    ("薬局の前に立って左側は何ですか", "Bakery"),
    ("薬局に向かって右には何がありますか", "Toilets 2"),
    ("약국을 바라보고 왼쪽에는 뭐가 있나요?", "Bakery"),
    ("약국 앞에 서면 오른쪽에 뭐가 있어요?", "Toilets 2"),
]

NEAREST = [
    ("the toilets that are closest to the bank", "Toilets 2"),
    ("which toilets are nearest to Exit B?", "Toilets 11"),
    ("Toiletten, die am nächsten beim Ausgang B liegen", "Toilets 11"),
    ("die Toilette, die der Bank am nächsten ist", "Toilets 2"),
    ("les toilettes qui sont les plus proches de la sortie B", "Toilets 11"),
    ("les toilettes les plus éloignées de la sortie B", "Toilets 2"),
    ("los aseos que están más cerca de la salida B", "Toilets 11"),
    ("el baño más lejano a la salida B", "Toilets 2"),
    ("离B出口最近的厕所", "Toilets 11"),
    ("哪个厕所离银行最近", "Toilets 2"),
    ("出口Bに一番近いトイレ", "Toilets 11"),
    ("銀行から最も近いトイレはどこですか", "Toilets 2"),
    ("B출구에서 가장 가까운 화장실", "Toilets 11"),
    ("은행에서 제일 가까운 화장실이 어디예요", "Toilets 2"),
]

LEFT_OUT = [
    ("the exit, but not exit A", "Exit B"),
    ("a toilet, just not the nearest one", "Toilets 11"),
    ("any gate except gate 12", "Gate 27"),
    ("einen Ausgang, aber nicht Ausgang A", "Exit B"),
    ("eine Toilette, nur nicht die nächste", "Toilets 11"),
    ("une sortie, mais pas la sortie A", "Exit B"),
    ("des toilettes, sauf les plus proches", "Toilets 11"),
    ("una salida, pero no la salida A", "Exit B"),
    ("un baño que no sea el más cercano", "Toilets 11"),
    ("出口，不要A出口", "Exit B"),
    ("厕所，不要最近的那个", "Toilets 11"),
    ("A出口以外の出口", "Exit B"),
    ("一番近いトイレ以外のトイレ", "Toilets 11"),
    ("A출구 말고 다른 출구", "Exit B"),
]

PLANS = [
    ("First the bank, then the library, and finally exit B", ["Bank", "Library", "Exit B"]),
    ("Zuerst zur Apotheke, danach in die Bibliothek und zum Schluss zum Ausgang B", ["Pharmacy", "Library", "Exit B"]),
    ("D'abord la banque, puis la bibliothèque, et pour finir la sortie B", ["Bank", "Library", "Exit B"]),
    ("Primero el banco, luego la biblioteca y por último la salida B", ["Bank", "Library", "Exit B"]),
    ("先去银行，然后去图书馆，最后去B出口", ["Bank", "Library", "Exit B"]),
    ("まず銀行に行って、それから図書館、最後に出口B", ["Bank", "Library", "Exit B"]),
    ("먼저 은행에 갔다가 도서관에 들렀다가 B출구로", ["Bank", "Library", "Exit B"]),
]

NUMBERS = [
    ("gate twenty-seven", "Gate 27"),
    ("gate twelve please", "Gate 12"),
    ("Gate siebenundzwanzig", "Gate 27"),
    ("zum Gate zwölf", "Gate 12"),
    ("la porte vingt-sept", "Gate 27"),
    ("porte douze", "Gate 12"),
    ("la puerta veintisiete", "Gate 27"),
    ("二十七号登机口", "Gate 27"),
    ("二十七番ゲート", "Gate 27"),
    ("이십칠번 게이트", "Gate 27"),
    ("gate ninety-nine", None),
    ("Exit b", "Exit B"),
    ("Ausgang A", "Exit A"),
    ("B出口在哪里", "Exit B"),
]

ON_THE_WAY = [
    ("I'm going to the bank, which toilets are on the way?", "Toilets 2"),
    ("Ich gehe zur Bank, welche Toilette liegt auf dem Weg?", "Toilets 2"),
    ("Je vais à la banque, quelles toilettes sont sur le chemin ?", "Toilets 2"),
    ("Voy al banco, ¿qué baños hay de camino?", "Toilets 2"),
    ("我要去银行，路上有厕所吗", "Toilets 2"),
    ("銀行に行くのですが、途中にトイレはありますか", "Toilets 2"),
    ("은행에 가는데 가는 길에 화장실 있어요?", "Toilets 2"),
]

AMONG = [
    ("Which is nearer to Exit B: the bank or the optician?", "Optician"),
    ("Is the bakery or the library closer to the elevator?", "Bakery"),
    ("Of the bakery, the bank and the optician, which is second nearest to Exit B?", "Bank"),
    ("The library or the pharmacy: which is farther away?", "Library"),
    ("Was liegt näher am Ausgang B: die Bank oder der Optiker?", "Optician"),
    ("Die Apotheke oder die Bank – was ist weiter weg vom Ausgang A?", "Bank"),
    ("¿Qué está más cerca de la salida B, el banco o la óptica?", "Optician"),
    ("La farmacia o el banco: ¿cuál queda más lejos de la salida A?", "Bank"),
    ("Lequel est le plus proche de la sortie B : la banque ou l'opticien ?", "Optician"),
    ("Entre la pharmacie et la banque, laquelle est la plus éloignée de la sortie A ?", "Bank"),
    ("药店和银行哪个离B出口更近？", "Bank"),
    ("离电梯最远的是药店、银行还是眼镜店？", "Optician"),
    ("薬局と銀行ではどちらが出口Bに近いですか", "Bank"),
    ("エレベーターから一番遠いのはどれ？薬局、銀行、図書館", "Bank"),
    ("약국과 은행 중 어디가 B출구에 더 가까워요?", "Bank"),
    ("엘리베이터에서 더 먼 건 약국이야 도서관이야?", "Library"),
    ("Which is nearer to Exit B: the bank or the swimming pool?", None),
]

CHAINS = [
    ("buy some bread, get some cash, borrow a book", ["Bakery", "Bank", "Library"]),
    ("Brot kaufen, Geld abheben, ein Buch ausleihen", ["Bakery", "Bank", "Library"]),
    ("comprar pan, sacar dinero y tomar un café", ["Bakery", "Bank", "Café Luna"]),
    ("acheter du pain, retirer de l'argent et boire un café", ["Bakery", "Bank", "Café Luna"]),
    ("先买面包，再取钱，最后喝咖啡", ["Bakery", "Bank", "Café Luna"]),
    ("パンを買って、お金を下ろして、コーヒーを飲みたい", ["Bakery", "Bank", "Café Luna"]),
    ("빵 사고, 돈 찾고, 커피 마시자", ["Bakery", "Bank", "Café Luna"]),
    ("먼저 빵 사고 돈 찾고 커피 마실래", ["Bakery", "Bank", "Café Luna"]),
]

COMPARED = [
    ("Which exit is farther away?", "Exit B"),
    ("Welche Toilette ist näher?", "Toilets 2"),
    ("哪个出口更远", "Exit B"),
]


@pytest.mark.parametrize(
    ("question", "expected"), [*FACING, *NEAREST, *LEFT_OUT, *NUMBERS, *AMONG, *COMPARED, *ON_THE_WAY]
)
def test_one_place_is_told_from_others(question: str, expected: str | None) -> None:
    assert answer(question) == [expected]


@pytest.mark.parametrize(
    "question",
    [
        "the nearest and farthest toilet",
        "die nächste und zugleich am weitesten entfernte Toilette",
        "les toilettes les plus proches et les plus éloignées",
        "el baño más cercano y más lejano",
        "最近又最远的厕所",
        "一番近くて一番遠いトイレ",
        "가장 가깝고 가장 먼 화장실, 제일 가까운",
    ],
)
def test_a_wish_that_contradicts_itself_is_answered_by_none_in_one_line(question: str) -> None:
    wish = model().read_wish(question)
    assert answer(question) == [None]
    assert wish.stops[0].contradiction == "farthest and nearest"


@pytest.mark.parametrize(("question", "expected"), [*PLANS, *CHAINS])
def test_stops_come_in_the_order_in_which_they_are_said(question: str, expected: list[str]) -> None:
    assert answer(question) == expected


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("I do not see well, where can I get new glasses?", "Optician"),
        ("A loaf, not too dark", "Bakery"),
        ("Je ne trouve pas la bibliothèque", "Library"),
        ("No sé dónde está el banco", "Bank"),
        ("Ich weiß nicht, wo die Apotheke ist", "Pharmacy"),
        ("找不到图书馆", "Library"),
        ("銀行がどこかわからない", "Bank"),
        ("약국을 못 찾겠어요", "Pharmacy"),
    ],
)
def test_a_negation_need_not_refuse(question: str, expected: str) -> None:
    assert answer(question) == [expected]
