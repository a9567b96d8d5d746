"""What a question wants, refuses and only tells, clause by clause."""

import pytest
from asking import chosen

from lpslam.language.offline import OfflineModel
from lpslam.language.questions.question import read_question
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import Knowledge


@pytest.mark.parametrize(
    ("question", "refused", "wanted"),
    [
        ("Pizza again? No thanks. What else is there for dinner?", "cuisine/pizza", "food"),
        ("Tout sauf un burger ou des sushis, on a faim", "cuisine/burger", "food"),
        ("Mein Sohn hat eine Fischallergie, wo können wir essen?", "cuisine/seafood", "food"),
        ("我想吃饭，别给我推荐火锅", "cuisine/hotpot", "food"),
        ("日料、火锅统统不要，想吃饭", "cuisine/japanese", "food"),
        ("해산물은 못 먹어요. 저녁은 어디서 먹을까요", "cuisine/seafood", "food"),
    ],
)
def test_a_refusal_reaches_what_it_speaks_of(question: str, refused: str, wanted: str, knowledge: Knowledge) -> None:
    wish = read_question(question, knowledge)
    assert refused in wish.refused
    assert refused not in dict(wish.wanted)
    assert wanted in dict(wish.wanted)


def test_both_sides_of_an_or_are_refused(knowledge: Knowledge) -> None:
    wish = read_question("Tout sauf un burger ou des sushis", knowledge)
    assert {"cuisine/burger", "cuisine/sushi"} <= set(wish.refused)


def test_a_complaint_about_one_place_leaves_the_want(model: OfflineModel) -> None:
    question = "I want a coffee and the queue at Costa Coffee is too long"
    assert chosen(model, question, "Costa Coffee", "Starbucks", "KFC") == "Starbucks"


@pytest.mark.parametrize(
    ("question", "refused", "left"),
    [
        ("I'd like dinner, but nothing spicy", "Sichuan Garden", "Trattoria Roma"),
        ("I want to eat but I have coeliac disease", "Panificio Bäckerei", "Sushi Yama"),
        ("아시아 음식 말고 저녁 먹고 싶어요", "スシロー", "Burger King"),
        ("Je suis intolérant au lactose, où manger ?", "Gelateria Dolce", "Sushi Yama"),
    ],
)
def test_a_diet_refuses_kitchens_that_hold_what_it_forbids(
    question: str, refused: str, left: str, model: OfflineModel
) -> None:
    assert chosen(model, question, refused, left) == left
    assert chosen(model, question, refused) is None


def test_no_chain_means_no_brand(model: OfflineModel) -> None:
    assert chosen(model, "A coffee, but not from a chain", "Starbucks", "Café Luna") == "Café Luna"
    assert chosen(model, "A coffee, please", "Starbucks", "KFC") == "Starbucks"


def test_a_named_shop_after_a_but_is_not_where_to_go(model: OfflineModel) -> None:
    question = "I need shoes, but Foot Locker is for teenagers"
    assert chosen(model, question, "Foot Locker", "Zapatería Los Tres Gatos") == "Zapatería Los Tres Gatos"
    assert chosen(model, "I need shoes, where is Foot Locker?", "Zapatería Gato", "Foot Locker") == "Foot Locker"


def test_a_plural_name_is_not_said_by_its_singular(model: OfflineModel) -> None:
    assert chosen(model, "the sole of my boot came off", "Boots", "Schuhmacher Meier") != "Boots"
    assert chosen(model, "where is Boots?", "Boots", "Schuhmacher Meier") == "Boots"


def test_two_letters_are_a_name_only_in_capitals_of_their_own(model: OfflineModel) -> None:
    assert chosen(model, "GUはどこですか", "ZARA", "GU") == "GU"
    assert chosen(model, "Where is the guitar shop?", "ZARA", "GU") is None


def test_own_small_words_are_no_english(knowledge: Knowledge) -> None:
    assert "accessory" not in dict(read_question("Wer hat hier einen Geldautomaten gesehen?", knowledge).wanted)


@pytest.mark.parametrize(
    ("sign", "kind"),
    [
        ("Danger Zone Games", "video_games"),
        ("Wet Paint Art Supplies", "art_supplies"),
        ("High Voltage Gym", "leisure/fitness_centre"),
        ("Caution Clothing Co.", "clothes"),
        ("Caution Hot Coffee", "sign/warning"),
        ("Danger Deep Water", "sign/warning"),
        ("Do not touch the books", "sign/warning"),
        ("NO SHOES", "sign/warning"),
        ("No shopping carts beyond this point", "sign/warning"),
        ("No Name Bar", "amenity/bar"),
        ("Green Leaf Vegetarian", "cuisine/vegetarian"),
        ("Horlogerie du Pont – Réparation", "watch"),
    ],
)
def test_what_ends_a_sign_and_what_begins_it(sign: str, kind: str) -> None:
    assert load_sign_reader().read(sign).kinds[0][0] == kind


def test_a_watchmaker_mends_no_telephones(model: OfflineModel) -> None:
    names = ("Horlogerie du Pont Réparation", "王师傅手机快修")
    assert chosen(model, "哪儿有修手机的？", *names) == "王师傅手机快修"
    assert chosen(model, "My watch is broken, who repairs it?", *names) == "Horlogerie du Pont Réparation"


def test_an_article_is_no_tea() -> None:
    assert not load_sign_reader().read("The Blue Comet").kinds
    assert dict(load_sign_reader().read("The Red Lion").kinds).keys() == {"amenity/pub"}


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        ("Zara is way out of my budget, where do I get a dress?", "H&M"),
        ("El Zara está petadísimo y yo solo quiero unos pantalones", "H&M"),
        ("Bei Zara ist die Schlange endlos, wo finde ich sonst eine Hose?", "H&M"),
        ("ZARA人山人海的，去哪儿买裤子好？", "H&M"),
        ("Where is Zara? I need a dress", "ZARA"),
        ("I need a dress, is there a Zara here?", "ZARA"),
    ],
)
def test_a_place_that_is_only_told_of_beside_a_want_is_refused(question: str, answer: str, model: OfflineModel) -> None:
    assert chosen(model, question, "ZARA", "H&M", "KFC") == answer


def test_what_is_told_of_in_another_sentence_weighs_less_than_what_is_asked_for(model: OfflineModel) -> None:
    question = "서점은 벌써 들렀다 왔어. 이제 카메라 사러 갈 거야"
    assert chosen(model, question, "紀伊國屋書店", "ビックカメラ") == "ビックカメラ"


def test_the_end_of_one_korean_word_and_the_beginning_of_the_next_make_no_third(knowledge: Knowledge) -> None:
    # 하나 사려고 has no 나사, a screw, in it.
    assert "diy/fixings" not in dict(read_question("하나 사려고 하는데요", knowledge).wanted)
    assert "diy/fixings" in dict(read_question("나사 사려고 하는데요", knowledge).wanted)


def test_words_mean_nothing_together_with_what_is_refused(knowledge: Knowledge) -> None:
    wish = read_question("a toilet, but not the disabled one", knowledge)
    assert [concept for concept, weight in wish.wanted if weight >= 1.0] == ["amenity/toilets"]


def test_a_list_goes_on_being_refused(knowledge: Knowledge) -> None:
    wish = read_question("No pizza, burgers or kebab. Where else can I eat?", knowledge)
    assert {"cuisine/pizza", "cuisine/burger", "cuisine/kebab"} <= set(wish.refused)


def test_a_present_is_wanted_when_a_sort_of_it_is_refused(knowledge: Knowledge) -> None:
    wish = read_question("선물로 화장품 말고 다른 거 사고 싶어요", knowledge)
    assert "gift" in dict(wish.wanted)
    assert "cosmetics" in wish.refused


def test_an_ice_cream_may_be_wanted_from_elsewhere_than_the_parlour(model: OfflineModel) -> None:
    question = "Me apetece un helado, pero la heladería esa es carísima"
    assert chosen(model, question, "Gelateria Dolomiti", "Lidl", "ZARA") == "Lidl"


def test_that_stands_for_what_was_named_before(knowledge: Knowledge) -> None:
    wish = read_question("I've had Asian food all week, anything but that for dinner tonight.", knowledge)
    assert "asian_food" in wish.refused
    assert "food" in dict(wish.wanted)


def test_who_dislikes_coffee_may_have_tea_in_a_cafe(model: OfflineModel) -> None:
    assert chosen(model, "Kaffee vertrag ich nicht, ich hätt gern einen Tee", "Starbucks", "ZARA") == "Starbucks"
    assert chosen(model, "Kein Kaffee bitte, nur was zu trinken", "Starbucks", "7-ELEVEN") == "7-ELEVEN"


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        ("Is there a florist in this hospital?", "Petals Florist"),
        ("It's freezing out here. Which way is the cinema?", "CGV Cinemas"),
        ("A present for my aunt please, she has hay fever", "Petals Florist"),
    ],
)
def test_where_one_is_and_why_is_no_wish(question: str, answer: str, model: OfflineModel) -> None:
    assert chosen(model, question, "Hospital Pharmacy", "UNIQLO", "Petals Florist", "CGV Cinemas") == answer


def test_two_letters_are_a_name_where_they_stand_as_they_are_painted(model: OfflineModel) -> None:
    question = "Ich brauch Windeln. Bei dm war ich grad, die sind ausverkauft."
    assert chosen(model, question, "dm", "REWE", "KFC") == "REWE"


def test_one_name_in_two_scripts_is_one_brand(model: OfflineModel) -> None:
    question = "Au Family Mart, plus un seul parapluie. Ailleurs peut-être ?"
    assert chosen(model, question, "ファミリーマート", "セブン-イレブン", "KFC") == "セブン-イレブン"


def test_where_nothing_else_is_wanted_another_of_the_same_sort_is(model: OfflineModel) -> None:
    question = "刚从Costa出来，咖啡太难喝了，还有别家吗"
    assert chosen(model, question, "Costa Coffee", "Starbucks", "ZARA") == "Starbucks"


def test_a_dessert_cafe_is_no_dinner(model: OfflineModel) -> None:
    assert chosen(model, "唔知去邊度食晚飯好", "滿記甜品", "鼎泰豐") == "鼎泰豐"
