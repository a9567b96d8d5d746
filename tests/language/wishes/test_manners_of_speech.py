"""Refusals, plans and questions as people say them: elderly, terse, spoken, polite, angry; seven languages."""

from collections.abc import Sequence

import numpy as np
import pytest

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Place
from lpslam.navigation.solver import solve

AIRPORT = (
    *("Check-in 1–20", "Security", "Gates A1–A12", "Gates B20–B38", "Café Luna", "Burger Barn", "Trattoria Sole"),
    *("Sushi Kiku", "The Anchor Pub", "Pharmacy", "Bookshop", "Currency Exchange", "Taxi", "Airport Train"),
    *("Car Rental", "Lost Property", "Left Luggage", "Prayer Room", "Quiet Lounge", "Showers", "Baby Care Room"),
    *("Toilets", "Lift", "Escalator"),
)
CLINIC = (
    *("Reception", "Blood Tests", "X-Ray", "Eye Clinic", "Dental Clinic", "Physiotherapy", "Children's Ward"),
    *("Maternity Ward", "Pharmacy", "Cafeteria", "Kiosk", "Chapel", "Library", "Lift", "Stairs", "Toilets"),
    *("Cash Machine", "Car Park", "Hairdresser", "Room 12 Dr. Weber", "Room 14 Dr. Okafor"),
)
SPORTS = (
    *("Swimming Pool", "Sauna", "Gym", "Climbing Wall", "Dance Studio", "Tennis Courts", "Changing Rooms"),
    *("Snack Bar", "Restaurant", "Vending Machine", "Ticket Office", "First Aid", "Library", "Registry Office"),
    *("Passport Office", "Photo Booth", "Copier", "Lockers", "Playground", "Cinema"),
)
EATING = ("Café Luna", "Burger Barn", "Trattoria Sole", "Sushi Kiku", "The Anchor Pub")
INTO_TOWN = ("Taxi", "Car Rental")
MOVING = ("Gym", "Climbing Wall", "Dance Studio", "Tennis Courts")


def but(places: Sequence[str], *left_out: str) -> tuple[str, ...]:
    return tuple(place for place in places if place not in left_out)


REFUSALS: tuple[tuple[Sequence[str], str, Sequence[str]], ...] = (
    (AIRPORT, "food, no burgers", but(EATING, "Burger Barn")),
    (AIRPORT, "I should so like a bit of lunch, dear, but raw fish I cannot abide", but(EATING, "Sushi Kiku")),
    (AIRPORT, "Into town please, and for heaven's sake not by train again", INTO_TOWN),
    (AIRPORT, "We would be grateful for something to drink, though not in a pub", but(EATING, "The Anchor Pub")),
    (AIRPORT, "nach oben, aber ich kann keine Rolltreppe fahren, mir wird schwindlig", ["Lift"]),
    (AIRPORT, "Gates, nicht A", ["Gates B20–B38"]),
    (AIRPORT, "on mange où, à part le truc à burgers ?", but(EATING, "Burger Barn")),
    (AIRPORT, "Je voudrais m'asseoir au calme, mais pas pour prier", ["Quiet Lounge"]),
    (AIRPORT, "Ya estoy harto de pizza, ¿qué otra cosa se puede comer aquí?", but(EATING, "Trattoria Sole")),
    (AIRPORT, "去市区,火车不坐", INTO_TOWN),
    (AIRPORT, "寿司じゃなくて、温かいものが食べたい", but(EATING, "Sushi Kiku")),
    (AIRPORT, "버거 말고 먹을 만한 데 없어요?", but(EATING, "Burger Barn")),
    (CLINIC, "not the stairs, my knees are shot, how do I get up a floor", ["Lift"]),
    (CLINIC, "Where is the doctor, please? Not Dr. Weber, the other one", ["Room 14 Dr. Okafor"]),
    (CLINIC, "Ich brauche keinen Arzt, ich besuche bloß meine Tochter, sie hat entbunden", ["Maternity Ward"]),
    (CLINIC, "algo de comer, pero en la cafetería no, que es carísima", ["Kiosk"]),
    (CLINIC, "계단은 힘들어서요, 위층에 가려고요", ["Lift"]),
    (SPORTS, "I wanna work out but I'm no swimmer", MOVING),
    (SPORTS, "faire du sport, ni danse ni tennis", ("Gym", "Climbing Wall", "Swimming Pool")),
    (SPORTS, "想运动,不想下水", MOVING),
    (SPORTS, "何か食べたいけど、レストランは高いのでやめておきます", ("Snack Bar", "Vending Machine")),
)
PLANS: tuple[tuple[Sequence[str], str, Sequence[str]], ...] = (
    (AIRPORT, "check in, then drop the big bag off, then a coffee", ("Check-in 1–20", "Left Luggage", "Café Luna")),
    (AIRPORT, "First my pills, and then something to read on the plane, dear", ("Pharmacy", "Bookshop")),
    (AIRPORT, "gonna change some cash then grab a taxi", ("Currency Exchange", "Taxi")),
    (AIRPORT, "We should like a shower before we have sushi, please", ("Showers", "Sushi Kiku")),
    (AIRPORT, "erst wickeln, dann beten, dann zum Gate B30", ("Baby Care Room", "Prayer Room", "Gates B20–B38")),
    (AIRPORT, "Zuerst hole ich meinen verlorenen Schirm ab, danach den Leihwagen", ("Lost Property", "Car Rental")),
    (AIRPORT, "d'abord la sécurité, après un café, et enfin la porte A7", ("Security", "Café Luna", "Gates A1–A12")),
    (AIRPORT, "primero cambio euros y luego una pizza", ("Currency Exchange", "Trattoria Sole")),
    (AIRPORT, "先寄存行李,再喝杯咖啡", ("Left Luggage", "Café Luna")),
    (AIRPORT, "両替してからお寿司を食べたい", ("Currency Exchange", "Sushi Kiku")),
    (AIRPORT, "약 사고 나서 커피 한잔하고 싶어요", ("Pharmacy", "Café Luna")),
    (CLINIC, "sign in, get me bloods done, then Dr. Okafor", ("Reception", "Blood Tests", "Room 14 Dr. Okafor")),
    (CLINIC, "First I see about my eyes, then my teeth, then the chapel", ("Eye Clinic", "Dental Clinic", "Chapel")),
    (CLINIC, "Röntgen, dann zur Krankengymnastik", ("X-Ray", "Physiotherapy")),
    (CLINIC, "une prise de sang, ensuite la cafétéria", ("Blood Tests", "Cafeteria")),
    (CLINIC, "cortarme el pelo y después rezar un poco", ("Hairdresser", "Chapel")),
    (CLINIC, "피 뽑고 엑스레이 찍고 밥 먹으려고요", ("Blood Tests", "X-Ray", "Cafeteria")),
    (
        SPORTS,
        "passport photo, then the passport office, then a swim",
        ("Photo Booth", "Passport Office", "Swimming Pool"),
    ),
    (SPORTS, "着替えて、泳いで、サウナに入りたい", ("Changing Rooms", "Swimming Pool", "Sauna")),
    (SPORTS, "买票,换衣服,然后游泳", ("Ticket Office", "Changing Rooms", "Swimming Pool")),
)
QUESTIONS: tuple[tuple[Sequence[str], str, Sequence[str]], ...] = (
    (AIRPORT, "Does the pharmacy sell sun cream at this hour?", ["Pharmacy"]),
    (AIRPORT, "can you take dogs in the pub", ["The Anchor Pub"]),
    (AIRPORT, "Am I allowed to sleep in the quiet lounge, young man?", ["Quiet Lounge"]),
    (AIRPORT, "do they do breakfast at the trattoria??", ["Trattoria Sole"]),
    (AIRPORT, "Hat die Apotheke sonntags auf?", ["Pharmacy"]),
    (AIRPORT, "Darf man im Gebetsraum die Schuhe anbehalten?", ["Prayer Room"]),
    (AIRPORT, "La consigne à bagages est-elle payante ?", ["Left Luggage"]),
    (AIRPORT, "¿Se puede pagar con tarjeta en el taxi?", ["Taxi"]),
    (AIRPORT, "淋浴要钱吗?", ["Showers"]),
    (AIRPORT, "シャワー室は予約がいりますか。", ["Showers"]),
    (AIRPORT, "유아휴게실에 아빠도 들어가도 되나요?", ["Baby Care Room"]),
    (AIRPORT, "Who looks after things people have left behind?", ["Lost Property"]),
    (CLINIC, "Is one permitted to bring flowers into the children's ward?", ["Children's Ward"]),
    (CLINIC, "how late is the cafeteria open", ["Cafeteria"]),
    (CLINIC, "Kann ich im Parkhaus mit Karte zahlen?", ["Car Park"]),
    (CLINIC, "Le coiffeur prend-il sans rendez-vous ?", ["Hairdresser"]),
    (CLINIC, "¿Qué día atiende el doctor Weber?", ["Room 12 Dr. Weber"]),
    (CLINIC, "도서관은 아무나 이용할 수 있어요?", ["Library"]),
    (SPORTS, "Is my grandson too small for the climbing wall?", ["Climbing Wall"]),
    (SPORTS, "七十岁的人能进桑拿吗", ["Sauna"]),
    (SPORTS, "プールは子供も入れますか。", ["Swimming Pool"]),
    (SPORTS, "do I need a towel for the gym?", ["Gym"]),
)


def answers(model: OfflineModel, names: Sequence[str], question: str) -> list[str | None]:
    places = [Place(id_, name, np.array([4.0 * id_, 0.0, 0.0])) for id_, name in enumerate(names)]
    landmarks = [Candidate(id_, name) for id_, name in enumerate(names)]
    solution = solve(model.read_wish(question), places, model.scorer(landmarks))
    return [stop.place and stop.place.name for stop in solution.stops]


def score(model: OfflineModel, rows: tuple[tuple[Sequence[str], str, Sequence[str]], ...]) -> tuple[int, int]:
    """Right and wrong answers of one stop."""
    given = [(answers(model, places, question)[-1], expected) for places, question, expected in rows]
    right = sum(answer in expected for answer, expected in given)
    return right, sum(answer is not None and answer not in expected for answer, expected in given)


@pytest.mark.parametrize(
    ("rows", "least", "most_wrong"), [(REFUSALS, 14, 4), (QUESTIONS, 19, 0)], ids=["refusals", "questions"]
)
def test_most_are_answered_and_few_wrongly(
    model: OfflineModel, rows: tuple[tuple[Sequence[str], str, Sequence[str]], ...], least: int, most_wrong: int
) -> None:
    right, wrong = score(model, rows)
    assert right >= least
    assert wrong <= most_wrong


def test_most_plans_have_all_their_stops(model: OfflineModel) -> None:
    assert sum(answers(model, places, question) == list(stops) for places, question, stops in PLANS) >= 18
