"""Two things to do, put in order by the grammar of seven languages: drawn from ways of saying so and things to do."""

from itertools import permutations

import pytest

from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Wish

THINGS = {
    "en": {"watch a film": "film", "have a coffee": "coffee", "withdraw cash": "cash"},
    "de": {"einen Film anschauen": "Film", "einen Kaffee trinken": "Kaffee", "Geld abheben": "Geld"},
    "fr": {"voir un film": "film", "boire un café": "café", "retirer de l'argent": "argent"},
    "es": {"ver una película": "película", "tomar un café": "café", "sacar dinero": "dinero"},
    "zh": {"看电影": "电影", "喝咖啡": "咖啡", "取钱": "取钱"},
    "ja": {"映画を見": "映画", "ご飯を食べ": "ご飯", "お金を預け": "お金"},
    "ko": {"영화를 보": "영화", "커피를 마시": "커피", "돈을 찾": "돈"},
}
WAYS = {
    "en": [
        "I'll {first}, and when I'm done I'll {then}",
        "{first}; once that's done, {then}",
        "{first} and from there go and {then}",
        "having had to {first}, I'd like to {then}",
        "start with: {first}. End with: {then}",
        "before I {then} I need to {first}",
    ],
    "de": [
        "erst {first}, danach {then}",
        "erst {first}, und wenn das erledigt ist, {then}",
        "{first}. Ist das erledigt, {then}",
        "{first}, und von dort aus {then}",
        "als Erstes {first}, als Nächstes {then}",
        "ich muss {first}, ehe ich {then} kann",
        "wenn ich mit {first} fertig bin, {then}",
    ],
    "fr": [
        "avant de {then}, je veux {first}",
        "je veux {first} avant de {then}",
        "{first}, et une fois que c'est fait, {then}",
        "commencer par {first} et finir par {then}",
        "{first}, et de là {then}",
        "{first}. Cela fait, {then}",
        "dans un premier temps {first}, dans un second temps {then}",
        "dès que j'ai fini de {first}, {then}",
    ],
    "es": [
        "después de {first} quiero {then}",
        "quiero {first} antes de {then}",
        "{first}, y cuando termine, {then}",
        "{first} y de ahí {then}",
        "{first}; una vez hecho eso, {then}",
        "{then}, pero no sin antes {first}",
        "al terminar de {first}, {then}",
        "en cuanto acabe de {first}, {then}",
        "hasta no {first} no puedo {then}",
    ],
    "zh": [
        "我们先{first}，弄完之后{then}",
        "{first}之后{then}",
        "{then}之前先{first}",
        "等{first}完了就{then}",
        "{first}，接下来{then}",
        "咱们{first}完了去{then}",
        "要{then}得先{first}",
    ],
    "ja": [
        "{first}てから{then}たい",
        "{first}たあとで{then}ます",
        "まず{first}て、それが済んだら{then}たい",
        "{then}るのは{first}た後で",
        "{first}て、続けて{then}ます",
        "とりあえず{first}て、あとは{then}たい",
    ],
    "ko": [
        "{first}고 나서 {then}고 싶어요",
        "{first}고 {then}러 갈게요",
        "먼저 {first}고 {then}러 가요",
        "{first}고서 {then}려고요",
        "{first}고, 끝나면 {then}러 갈래요",
        "{first}자마자 {then}러 갈게요",
        "{then}려면 먼저 {first}아야 해요",
    ],
}


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


def readings(wish: Wish) -> list[list[str]]:
    """What the stops of each reading of a wish want, the first that is tried first."""
    return [[stop.what for stop in wish.stops], *(readings(wish.instead) if wish.instead is not None else [])]


@pytest.mark.parametrize(("language", "way"), [(language, way) for language in WAYS for way in WAYS[language]])
def test_what_is_done_first_is_the_first_stop(model: OfflineModel, language: str, way: str) -> None:
    for first, then in permutations(THINGS[language], 2):
        words = [THINGS[language][first], THINGS[language][then]]
        found = readings(model.read_wish(way.format(first=first, then=then)))
        assert any(
            len(stops) == 2 and all(word in stop for word, stop in zip(words, stops, strict=True)) for stops in found
        ), (first, then, found)


@pytest.mark.parametrize(
    ("question", "stops"),
    [
        ("我们先看电影，看完再去吃披萨", ["电影", "披萨"]),
        ("先去取钱，取完坐地铁", ["取钱", "地铁"]),
        ("まずガソリン入れて、それから豆腐買って帰る", ["ガソリン", "豆腐"]),
    ],
)
def test_that_it_is_done_or_that_one_leaves_is_no_stop(model: OfflineModel, question: str, stops: list[str]) -> None:
    found = readings(model.read_wish(question))[0]
    assert len(found) == len(stops)
    assert all(word in stop for word, stop in zip(stops, found, strict=True))


@pytest.mark.parametrize(
    "question",
    [
        "is there a bank not far from there",
        "Ist das Café schon fertig?",
        "un café à deux pas de là",
        "quiero comer antes de las tres",
        "电影院后面的咖啡店",
        "帰りのバスはどこですか",
        "아이를 데리고 소아과로 갈게요",
        "지하철을 타고 은행에 갈게요",
    ],
)
def test_the_same_words_alone_make_no_plan(model: OfflineModel, question: str) -> None:
    assert all(len(stops) == 1 for stops in readings(model.read_wish(question)))
