"""What a sign's words say together."""

import pytest

from lpslam.language.signs import SignReader, load_sign_reader


@pytest.fixture(scope="module")
def signs() -> SignReader:
    return load_sign_reader()


def sure_kinds(signs: SignReader, name: str) -> set[str]:
    return {kind for kind, weight in signs.read(name).kinds if weight >= 0.6}


def test_the_trade_goes_before_what_the_owner_is_called(signs: SignReader) -> None:
    kinds = sure_kinds(signs, "Boulangerie Petit Jean")
    assert "shop/bakery" in kinds
    assert "shop/clothes" not in kinds


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
