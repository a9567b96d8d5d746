"""Refusals that no single word says: plenty at home, weariness, a doctor's orders, idioms, lists, and spills."""

import pytest
from asking import chosen

from lpslam.language.offline import OfflineModel
from lpslam.language.questions.question import read_question
from lpslam.language.tables.inflection import known_form
from lpslam.language.tables.knowledge import Knowledge


@pytest.mark.parametrize(
    ("question", "refused"),
    [
        ("Books, he already has plenty of. What else for his birthday?", "books"),
        ("玩具他已经够多了，生日送什么好？", "toys"),
        ("카메라는 이미 많아서 됐고, 아빠 생신 선물 뭐가 좋을까", "camera"),
        ("天天吃火锅，今晚想吃点别的", "cuisine/hotpot"),
        ("Das Essen hier ist immer nur Pizza, wo gibt es was anderes?", "cuisine/pizza"),
        ("El médico me ha prohibido la carne, ¿dónde almorzamos?", "meat"),
        ("お酒は医者に止められてるので、お茶が飲みたい", "alcohol"),
        ("Toys, jewellery or flowers? No: not toys, jewellery or flowers.", "jewelry"),
        ("Salchichas no: unas patatas fritas.", "meat"),
    ],
)
def test_it_is_refused_and_not_wanted(question: str, refused: str, knowledge: Knowledge) -> None:
    wish = read_question(question, knowledge)
    assert refused in wish.refused
    assert refused not in dict(wish.wanted)


@pytest.mark.parametrize(
    ("question", "wanted"),
    [
        ("I wouldn't say no to a pizza", "cuisine/pizza"),
        ("Gegen eine Pizza hätte ich nichts einzuwenden", "cuisine/pizza"),
        ("Je ne dirais pas non à une pizza", "cuisine/pizza"),
        ("No le haría ascos a una pizza", "cuisine/pizza"),
        ("No hay ni pan ni leche en casa", "groceries"),
    ],
)
def test_two_negations_and_what_is_missing_are_wants(question: str, wanted: str, knowledge: Knowledge) -> None:
    wish = read_question(question, knowledge)
    assert wanted in dict(wish.wanted) or wanted in wish.contested
    assert wanted not in wish.refused or wanted in wish.contested


def test_a_present_without_toys_is_not_bought_in_a_toy_shop(model: OfflineModel) -> None:
    question = "A present for my niece, but please no toys"
    assert chosen(model, question, "Toys R Us", "Barnes & Noble") == "Barnes & Noble"
    assert chosen(model, "A present for my niece", "Toys R Us", "KFC") == "Toys R Us"


def test_a_part_of_a_name_on_the_map_goes_before_a_brand_elsewhere(model: OfflineModel) -> None:
    question = "The Adler pharmacy had none left. Another pharmacy?"
    assert chosen(model, question, "Adler-Apotheke", "Apotheke am Markt") == "Apotheke am Markt"


def test_besides_a_named_cafe_another_is_wanted(model: OfflineModel) -> None:
    question = "Gibt es außer Starbucks noch ein anderes Café?"
    assert chosen(model, question, "Starbucks", "Café Sonnenschein") == "Café Sonnenschein"


def test_a_verb_of_the_language_is_not_borrowed_from_english(knowledge: Knowledge) -> None:
    # Spanish “suspender” is to fail an exam; English braces are “suspenders”.
    assert "accessory" not in dict(read_question("Mi hijo ha vuelto a suspender", knowledge).wanted)
    assert "accessory" in dict(read_question("I need suspenders", knowledge).wanted)


def test_an_inflected_word_is_the_word(knowledge: Knowledge) -> None:
    assert known_form("geldautomaten", "de", knowledge) == "geldautomat"
    assert known_form("farmacias", "es", knowledge) == "farmacia"


def test_a_word_is_no_brand_that_ends_in_s(model: OfflineModel) -> None:
    # “Point S” sells tyres.
    assert chosen(model, "Hey, Point me at a meal, please", "KFC", "Zara") == "KFC"


@pytest.mark.parametrize(
    "question",
    ["I want gluten and something gluten free", "something mild, I love spicy food", "no chains, I want a chain"],
)
def test_who_wants_what_he_refuses_gets_an_answer_all_the_same(question: str, knowledge: Knowledge) -> None:
    assert {"gluten", "spicy", "chain"} & set(read_question(question, knowledge).refused)


@pytest.mark.parametrize(
    "question",
    [
        "I spilled coffee all over my shirt, I need a clean one",
        "Se me ha caído el café en la camisa y necesito otra",
        "咖啡洒到衬衫上了，要买一件新的",
        "シャツにコーヒーをこぼしたので服を買いたい",
    ],
)
def test_what_was_spilled_is_not_what_is_wanted(question: str, model: OfflineModel) -> None:
    assert chosen(model, question, "Starbucks", "UNIQLO") == "UNIQLO"
