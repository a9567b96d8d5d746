"""Relations by how soon one is there, by the way between two places, and of whatever stands there."""

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import solve


@pytest.mark.parametrize(
    ("question", "relation", "what", "anchor", "start"),
    [
        ("which gallery faces the Museum Shop?", "opposite", "", "the Museum Shop", ""),
        ("カラオケのすぐ向かいは何", "opposite", "", "カラオケ", ""),
        ("Which café is quickest to reach from the entrance?", "near", "Which café", "the entrance", ""),
        ("the lift that I can reach fastest from the reception", "near", "the lift", "the reception", ""),
        ("Welche Toiletten liegen näher am Ausgang?", "near", "Welche Toiletten", "Ausgang", ""),
        ("Welches Café ist vom Eingang aus am schnellsten zu erreichen?", "near", "Welches Café", "Eingang", ""),
        ("¿A qué cafetería se llega antes desde la entrada?", "near", "A qué cafetería", "la entrada", ""),
        (
            "un cajero que me pille de camino desde la entrada hasta el cine",
            "on the way to",
            "un cajero",
            "el cine",
            "la entrada",
        ),
        ("Quel café est le plus rapide à atteindre depuis l'entrée ?", "near", "Quel café", "l'entrée", ""),
        (
            "un distributeur sur le chemin entre l'entrée et le cinéma",
            "on the way to",
            "un distributeur",
            "le cinéma",
            "l'entrée",
        ),
        ("从入口去哪个厕所最快？", "near", "哪个厕所", "入口", ""),
        ("どのエレベーターが入口に近いですか", "near", "どのエレベーター", "入口", ""),
        ("入口から一番早く行けるトイレはどれ", "near", "トイレ", "入口", ""),
        ("어느 엘리베이터가 입구에서 더 가까워요?", "near", "어느 엘리베이터", "입구", ""),
        ("입구에서 제일 빨리 갈 수 있는 화장실", "near", "화장실", "입구", ""),
        ("From the lifts, which toilets are closest?", "near", "which toilets", "the lifts", ""),
        ("Depuis la poste, quel café est le plus proche ?", "near", "quel café", "poste", ""),
        ("Desde la fuente, ¿qué cajero queda más cerca?", "near", "qué cajero", "fuente", ""),
        ("Von der Kasse aus, welches WC ist am nächsten?", "near", "welches WC", "Kasse", ""),
        ("从电梯出来，最近的厕所是哪个", "near", "厕所", "电梯", ""),
        ("das WC, das näher am Eingang liegt", "near", "das WC, das", "Eingang", ""),
        ("I'm off to the cinema now. Which cash machine do I pass on the way?", "on the way to", "", "the cinema", ""),
        ("I'm heading for the pool. What cafés are there on the way?", "on the way to", "", "the pool", ""),
        ("Wenn ich vor der Bank stehe: welcher Laden ist links?", "left of", "", "der Bank", ""),
    ],
)
def test_a_relation_is_read(question: str, relation: str, what: str, anchor: str, start: str) -> None:
    (stop,) = OfflineModel().read_wish(question).stops
    assert stop.relation is not None
    assert (stop.relation.value, [each.what for each in stop.anchor]) == (relation, [anchor])
    assert what in ("", stop.what)
    assert (stop.start.what if stop.start else "") == start


@pytest.mark.parametrize(
    "question",
    [
        "What's straight across from the cinema?",
        "which firm is opposite the cinema?",
        "Was ist denn da direkt gegenüber vom Kino?",
        "What does the cinema have opposite?",
        "¿Qué tiene enfrente el cine?",
        "Qu'est-ce qu'il y a en face du cinéma, peu importe lequel",
        "Was hat das Kino gegenüber?",
        "cinema对面是啥",
        "cinema对面那家是什么",
        "cinemaの向かいの店",
    ],
)
def test_whatever_stands_there_is_asked_for(question: str) -> None:
    names = ("Cinema", "Blue Harbour", "Toilets")
    at, facing = ((0.0, 0.0), (0.0, 5.0), (30.0, 5.0)), (1.0, -1.0, -1.0)
    places = [
        Place(id_, name, np.array([*xy, 0.0]), np.array([0.0, y, 0.0]))
        for id_, (name, xy, y) in enumerate(zip(names, at, facing, strict=True))
    ]
    model = OfflineModel()
    scorer = model.scorer([Candidate(id_, name) for id_, name in enumerate(names)])
    (stop,) = solve(model.read_wish(question), places, scorer, Here()).stops
    assert stop.place is not None
    assert stop.place.name == "Blue Harbour"


ROW = ("Bakery", "Post Office", "Pharmacy", "Salle 12", "Florist")
"""Boards of one wall, told from the left by who reads them."""


@pytest.mark.parametrize(
    ("question", "found"),
    [
        # What is asked for is no kind of place, or one that only says that it is some place.
        ("my mate said it's the stall between the bakery and the pharmacy", "Post Office"),
        ("the rack between the bakery and the pharmacy", "Post Office"),
        ("comment s'appelle ce qui est entre la pharmacie et le fleuriste ?", "Salle 12"),
        ("薬局と花屋のあいだって何でしたっけ", "Salle 12"),
        ("빵집과 약국 사이에 있는 게 뭐죠?", "Post Office"),
        ("빵집과 약국 사이에 있는 창구", "Post Office"),
        ("夹在面包店和药房之间的窗口", "Post Office"),
        # The clause before says where “it” is.
        ("I am standing here and look at the pharmacy. Which shop is just left of it?", "Post Office"),
        ("Look at the pharmacy: what is directly right of it?", "Salle 12"),
        # A kind that is read, and does not stand there, is none.
        ("the cinema between the bakery and the pharmacy", None),
    ],
)
def test_whatever_stands_there_is_the_answer(question: str, found: str | None) -> None:
    south = np.array([0.0, -1.0, 0.0])
    places = [Place(at, name, np.array([4.0 * at, 0.0, 0.0]), south) for at, name in enumerate(ROW)]
    model = OfflineModel()
    scorer = model.scorer([Candidate(place.id, place.name) for place in places])
    solution = solve(model.read_wish(question), places, scorer, Here(None))
    assert [stop.place and stop.place.name for stop in solution.stops] == [found]


@pytest.mark.parametrize(
    ("question", "relation", "anchors"),
    [
        ("En sortant de la pharmacie, qu'est-ce qui est juste en face ?", "opposite", ["pharmacie"]),
        ("Was liegt dem Friseur direkt gegenüber?", "opposite", ["dem Friseur"]),
        ("al salir de la farmacia, ¿qué tengo enfrente?", "opposite", ["farmacia"]),
        ("약국과 마주 보고 있는 가게", "opposite", ["약국"]),
        ("薬局と向かい合っている店", "opposite", ["薬局"]),
        ("quel est le voisin direct de la pharmacie ?", "next to", ["pharmacie"]),
        ("quiero ir al local que linda con la farmacia", "next to", ["la farmacia"]),
        ("药房的邻居是谁", "next to", ["药房"]),
        ("I want the one that has the bank on one side and the gym on the other", "between", ["the bank", "the gym"]),
        ("両隣が薬局と花屋の店", "between", ["薬局", "花屋"]),
        ("when I stand in front of the bank and look at it, what is on the left?", "left of", ["the bank"]),
        ("estoy delante de la farmacia. ¿Qué local queda a la derecha?", "right of", ["farmacia"]),
        ("Si me pongo delante de la farmacia, ¿qué queda a mi derecha?", "right of", ["farmacia"]),
        ("今薬局を見ています。その左隣の店は？", "left of", ["薬局"]),
        ("I'll be at the archive, where's the nearest café from there?", "near", ["I'll be at the archive"]),
    ],
)
def test_a_relation_in_a_clause_of_its_own_is_read(question: str, relation: str, anchors: list[str]) -> None:
    (stop,) = OfflineModel().read_wish(question).stops
    assert stop.relation is not None
    assert (stop.relation.value, [each.what for each in stop.anchor]) == (relation, anchors)


@pytest.mark.parametrize(
    ("question", "stops"),
    [
        ("als Erstes zur Bank, als Zweites zum Friseur, als Drittes zum Kino", 3),
        ("en premier la banque, en deuxième le coiffeur, en dernier le cinéma", 3),
        ("第一站银行，第二站药房，第三站电影院", 3),
        ("약국 갔다 와서 은행 가자", 2),
        ("薬局に寄ったあと銀行まで", 2),
        ("the bank, but the pharmacy first", 2),
    ],
)
def test_a_plan_is_read(question: str, stops: int) -> None:
    assert len(OfflineModel().read_wish(question).stops) == stops


@pytest.mark.parametrize(
    ("question", "anchor"),
    [("肉铺还是蔬菜摊离鱼摊近？", "鱼摊"), ("郵便局から近いのは薬局ですか、花屋ですか", "郵便局")],
)
def test_one_of_two_is_read(question: str, anchor: str) -> None:
    (stop,) = OfflineModel().read_wish(question).stops
    assert len(stop.among) == 2
    assert [each.what for each in stop.anchor] == [anchor]


@pytest.mark.parametrize(
    ("question", "relation", "anchors"),
    [
        # No row reads these: a relation's word alone tells of it, and all else is where.
        ("which room shares a wall with the bank?", "next to", 1),
        ("Wer sitzt Wand an Wand mit der Bank?", "next to", 1),
        ("Menez-moi à la porte contiguë à la banque", "next to", 1),
        ("薬局の真横の部屋", "next to", 1),
        ("药房门对门是什么", "opposite", 1),
        ("en medio de la farmacia y el banco, ¿qué hay?", "between", 2),
        ("약국과 은행 중간에 뭐가 있나요?", "between", 2),
    ],
)
def test_a_word_of_a_relation_is_enough(question: str, relation: str, anchors: int) -> None:
    (stop,) = OfflineModel().read_wish(question).stops
    assert stop.relation is not None
    assert (stop.what, stop.relation.value, len(stop.anchor)) == ("", relation, anchors)


@pytest.mark.parametrize(
    "question", ["auf dem linken Ohr höre ich nichts mehr", "je veux quelqu'un en face de moi", "les vaches du voisin"]
)
def test_who_only_tells_of_something_asks_for_no_neighbour(question: str) -> None:
    assert OfflineModel().read_wish(question).stops[0].what
