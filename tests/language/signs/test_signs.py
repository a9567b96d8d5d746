"""What a sign's words say together."""

import pytest

from lpslam.language.signs.meaning import WARNING
from lpslam.language.signs.reader import SignReader, load_sign_reader


@pytest.fixture(scope="module")
def signs() -> SignReader:
    return load_sign_reader()


def sure_kinds(signs: SignReader, name: str) -> set[str]:
    return {kind for kind, weight in signs.read(name).kinds if weight >= 0.6}


def test_the_letters_of_a_brand_say_nothing_else(signs: SignReader) -> None:
    # 大福, a rice cake, stands within 周大福.
    assert sure_kinds(signs, "周大福珠宝") == {"shop/jewelry", "jewelry"}


def test_a_brand_that_is_only_alike_does_not_go_before_another_trade(signs: SignReader) -> None:
    # 鲍师傅 is a bakery.
    kinds = sure_kinds(signs, "王师傅手机快修")
    assert "phone_repair" in kinds
    assert "shop/bakery" not in kinds


def test_of_two_scripts_either_may_be_the_known_name(signs: SignReader) -> None:
    assert "cuisine/pizza" in sure_kinds(signs, "達美樂 Domino's")


@pytest.mark.parametrize(("name", "kind"), [("Spielzeugkiste Kunterbunt", "shop/toys"), ("Brezelhaus Huber", "bread")])
def test_a_compound_in_a_name_says_its_trade(name: str, kind: str, signs: SignReader) -> None:
    assert kind in sure_kinds(signs, name)


def test_a_chinese_restaurant_is_not_thereby_a_sichuan_one(signs: SignReader) -> None:
    assert "cuisine/sichuan" not in sure_kinds(signs, "Golden Dragon Chinese Restaurant")


@pytest.mark.parametrize("name", ["Ladies Fashion", "Women's Shoes", "Mode Femme", "Damen Schuhe", "Gents Hairdresser"])
def test_whom_the_goods_are_for_is_no_toilet(name: str, signs: SignReader) -> None:
    assert not any("toilets" in kind for kind in sure_kinds(signs, name))


@pytest.mark.parametrize("name", ["Ladies", "Damen WC", "Women's Toilet", "Baby Room & Ladies"])
def test_a_toilet_stays_one(name: str, signs: SignReader) -> None:
    assert any("toilets" in kind for kind in sure_kinds(signs, name))


def test_a_station_of_goods_has_no_trains(signs: SignReader) -> None:
    assert "train" not in sure_kinds(signs, "Toy Station 玩具站")
    assert "train" in sure_kinds(signs, "Central Station")


def test_wine_in_a_kitchen_is_no_wine_shop(signs: SignReader) -> None:
    assert "shop/wine" not in sure_kinds(signs, "La Tasca – Tapas y Vino")
    assert "shop/wine" in sure_kinds(signs, "Vinos García")


@pytest.mark.parametrize(
    "name", ["危险品 禁止入内", "Danger High Voltage", "Hazardous Materials Keep Out", "危険 立入禁止"]
)
def test_a_warning_of_dangerous_goods_stays_one(name: str) -> None:
    assert load_sign_reader().read(name).kinds[0][0] == WARNING


@pytest.mark.parametrize(
    ("board", "kind"),
    [
        ("FRESH EVERY DAY | NADIA'S BAKERY | BAKERY", "shop/bakery"),
        ("全场八折 | 鸿达茶餐厅", "cuisine/cantonese"),
        ("SEE YOU | SOON AT | KFC", "amenity/fast_food"),
        ("Stop & Shop | open daily", "shop/supermarket"),
    ],
)
def test_a_shop_may_have_a_slogan_on_a_line_of_its_own(signs: SignReader, board: str, kind: str) -> None:
    meaning = signs.read(board)
    assert meaning.is_place
    assert kind in {each for each, _ in meaning.kinds}


@pytest.mark.parametrize(
    "board", ["BIG SALE | 全场五折", "DO NOT | ENTER", "CAUTION | WET FLOOR | Nadia's Bakery", "小心地滑 | 星巴克"]
)
def test_slogans_and_warnings_over_several_lines_are_no_place(signs: SignReader, board: str) -> None:
    assert not signs.read(board).is_place
