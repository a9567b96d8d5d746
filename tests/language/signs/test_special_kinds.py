"""Wishes for a special kind of goods: for women or men, sports shoes or others; and names painted in two scripts."""

import pytest
from asking import chosen

from lpslam.language.offline import OfflineModel

CLOTHES = ("茉莉女装 Jasmine", "Petit Bateau – Vêtements enfants", "Herrenmode Schmidt")


@pytest.mark.parametrize(
    ("question", "expected"),
    [
        ("Where can I buy men's clothes?", "Herrenmode Schmidt"),
        ("남자 옷 사고 싶은데 어디로 가야 하나요?", "Herrenmode Schmidt"),
        ("Busco una tienda de ropa para mujer.", "茉莉女装 Jasmine"),
        ("여자 옷 말고 남자 옷 매장이요", "Herrenmode Schmidt"),
        ("童装在哪里买？", "Petit Bateau – Vêtements enfants"),
        ("Clothes, but no women's clothes and no children's clothes.", "Herrenmode Schmidt"),
    ],
)
def test_clothes_for_whom(question: str, expected: str, model: OfflineModel) -> None:
    assert chosen(model, question, *CLOTHES) == expected


def test_clothes_for_nobody_in_particular_are_looked_for_where_everybody_finds_some(model: OfflineModel) -> None:
    assert chosen(model, "¿Dónde puedo comprar ropa?", *CLOTHES, "C&A Mode") == "C&A Mode"


def test_only_the_special_kind_is_refused(model: OfflineModel) -> None:
    signs = ("Nike", "百丽女鞋 BeLLE")
    assert chosen(model, "I need shoes, but not sports shoes.", *signs) == "百丽女鞋 BeLLE"
    assert chosen(model, "I need sports shoes.", *signs) == "Nike"


@pytest.mark.parametrize("question", ["¿Me llevas a Din Tai Fung?", "Take me to Din Tai Fung", "带我去鼎泰丰"])
def test_a_name_in_two_scripts_is_found_by_either(question: str, model: OfflineModel) -> None:
    assert chosen(model, question, "海底捞火锅", "鼎泰豐 DIN TAI FUNG") == "鼎泰豐 DIN TAI FUNG"


@pytest.mark.parametrize("question", ["便利店，不要7-11", "A convenience store, but not 7-11", "7-11以外のコンビニ"])
def test_a_brand_of_digits_is_refused_with_its_mark(question: str, model: OfflineModel) -> None:
    assert chosen(model, question, "7-ELEVEN", "全家便利商店") == "全家便利商店"


def test_bubble_tea_is_tea_and_no_coffee(model: OfflineModel) -> None:
    assert (
        chosen(model, "Quiero beber algo que no sea té.", "茶百道 ChaPanda", "Tim Hortons Coffee")
        == "Tim Hortons Coffee"
    )
    assert (
        chosen(model, "Ich hätte gern einen Kaffee zum Mitnehmen.", "茶百道 ChaPanda", "Tim Hortons") == "Tim Hortons"
    )


def test_heat_outside_asks_for_no_exit(model: OfflineModel) -> None:
    asked = "It's so hot outside, I need something to cool me down."
    assert chosen(model, asked, "Exit", "Eiscafé Venezia") == "Eiscafé Venezia"


def test_who_has_not_bought_a_ticket_wants_one(model: OfflineModel) -> None:
    assert chosen(model, "我要去苏黎世，可是还没买票。", "Burger King", "Tickets") == "Tickets"


@pytest.mark.parametrize(
    ("question", "fitting"),
    [
        ("想吃羊肉泡馍,往哪走?", {"老孙家羊肉泡馍"}),
        ("我想吃海南鸡饭。", {"阿明海南雞飯"}),
        ("豚肉は食べられません。お昼はどこで食べられますか", {"老孙家羊肉泡馍", "阿明海南雞飯"}),
        ("我对羊肉过敏,想吃点热乎的", {"老边饺子馆", "阿明海南雞飯"}),
    ],
)
def test_the_dish_that_a_sign_names_tells_it_from_its_like(
    question: str, fitting: set[str], model: OfflineModel
) -> None:
    assert chosen(model, question, "老边饺子馆", "老孙家羊肉泡馍", "阿明海南雞飯") in fitting


def test_a_jacket_for_the_husband_is_one_for_men(model: OfflineModel) -> None:
    assert (
        chosen(model, "남편이 면접 보는데 입을 만한 재킷이 없어요", "歌莉娅 GOELIA 女装", "七匹狼 男装")
        == "七匹狼 男装"
    )


@pytest.mark.parametrize("question", ["ケンタッキーはどこ?", "Take me to KFC", "带我去肯德基"])
def test_rows_of_one_brand_are_one_brand(question: str, model: OfflineModel) -> None:
    assert chosen(model, question, "Burger King", "肯德基 KFC") == "肯德基 KFC"


def test_what_is_written_by_hand_of_a_brand_stays(model: OfflineModel) -> None:
    assert chosen(model, "運動靴が欲しいけど、ナイキ以外でお願いします。", "ZARA", "李宁") == "李宁"


def test_a_bodega_with_tapas_is_no_corner_shop(model: OfflineModel) -> None:
    assert chosen(model, "I need toothpaste and milk", "La Bodega Tapas", "Carrefour Market") == "Carrefour Market"


def test_japanese_sweets_are_sweets_first_of_all(model: OfflineModel) -> None:
    asked = "Wo bekomme ich japanische Süßigkeiten, zum Beispiel Mochi?"
    assert chosen(model, asked, "スシロー", "和菓子処 たちばな") == "和菓子処 たちばな"


@pytest.mark.parametrize(
    ("question", "expected"),
    [("카레 먹고 싶어요.", "CoCo壱番屋"), ("我想吃荞麦面。", "手打ちそば 信濃庵"), ("うどんが食べたい", "丸亀製麺")],
)
def test_noodles_and_curry_are_told_apart(question: str, expected: str, model: OfflineModel) -> None:
    assert chosen(model, question, "丸亀製麺", "手打ちそば 信濃庵", "CoCo壱番屋") == expected


def test_a_boot_is_not_boots(model: OfflineModel) -> None:
    signs = ("Boots Pharmacy", "Timpson Shoe Repairs & Key Cutting")
    assert chosen(model, "The heel just came off my boot.", *signs) == "Timpson Shoe Repairs & Key Cutting"
    assert chosen(model, "Where is Boots?", *signs) == "Boots Pharmacy"
