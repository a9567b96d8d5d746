"""What is said after another stop, but comes before it: “before that”, “on the way there”, in seven languages."""

import pytest

from lpslam.language.offline import OfflineModel


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


@pytest.mark.parametrize(
    ("question", "parts"),
    [
        ("I want to end with a movie; before that a haircut", ["haircut", "movie"]),
        ("The museum, and on the way there a sandwich", ["sandwich", "museum"]),
        ("Take the lift, and on the way out buy flowers", ["lift", "flowers"]),
        ("After the dentist I'd like a coffee", ["dentist", "coffee"]),
        ("Ich will ins Kino, vorher aber noch Geld abheben", ["Geld", "Kino"]),
        ("Nach dem Friseur gleich ins Café", ["Friseur", "Café"]),
        ("en dernier le cinéma ; avant cela je dois retirer de l'argent", ["argent", "cinéma"]),
        ("Acabo en el cine; antes paso por la farmacia y antes aún por el banco", ["banco", "farmacia", "cine"]),
        ("最后去电影院，在那之前先取钱", ["取钱", "电影院"]),
        ("映画館に行きます。その前に本を買います", ["本", "映画館"]),
        ("영화관에 가요, 그 전에 현금을 뽑을게요", ["현금", "영화관"]),
        ("荷物をロッカーに預けたら、自転車を借りたい", ["荷物", "自転車"]),
        ("マッサージをお願いしたいです。ただ先に温泉に入ってから", ["温泉", "マッサージ"]),
        ("等给宝宝喂完奶，再带他去打预防针", ["喂完奶", "预防针"]),
        ("등본 다 되면 은행에 갈게요", ["등본", "은행"]),
        ("짐부터 보관함에 넣고 전망대 구경하러 갈래요", ["짐", "전망대"]),
        ("after I've paid my fees I have to see the dentist", ["fees", "dentist"]),
        ("Erst zum Friseur, dann ins Schwimmbad und danach auf mein Zimmer, 212", ["Friseur", "Schwimmbad", "Zimmer"]),
    ],
)
def test_it_comes_first(model: OfflineModel, question: str, parts: list[str]) -> None:
    stops = model.read_wish(question).stops
    assert len(stops) == len(parts)
    assert all(part in stop.what for part, stop in zip(parts, stops, strict=True))


@pytest.mark.parametrize(
    "question",
    [
        "nicht die Rutsche, davor hat er Angst",
        "我去3号站台，路上顺便上个厕所，哪个卫生间顺路",
        "on the way to the exit, is there a café?",
        "雨が降ったら、どこで待てばいいですか",
    ],
)
def test_other_words_of_before_make_no_plan(model: OfflineModel, question: str) -> None:
    assert len(model.read_wish(question).stops) == 1
