"""Signs that were misread by a letter still say what they are; names that are no slips stay names."""

import pytest

from lpslam.language.signs.reader import load_sign_reader

READER = load_sign_reader()


@pytest.mark.parametrize(
    ("misread", "kind"),
    [
        ("BAKFRY Schmidt", "shop/bakery"),
        ("Apothexe am Markt", "amenity/pharmacy"),
        ("Fundbür0", "facility/lost_property"),
        ("Gep4ck Restaurante", "amenity/restaurant"),
        ("RESTAURAMT Adria", "amenity/restaurant"),
        ("Post Off ce", "amenity/post_office"),
        ("Phar acie du Port", "amenity/pharmacy"),
        ("康福动物医皖", "amenity/veterinary"),
    ],
)
def test_a_word_that_is_a_letter_off_is_read(misread: str, kind: str) -> None:
    assert kind in dict(READER.read(misread).kinds)


@pytest.mark.parametrize("name", ["Florian Keller", "Marisol", "Tamsin & Reed"])
def test_a_name_that_is_no_slip_says_nothing_new(name: str) -> None:
    assert "misread" not in READER.read(name).evidence
    assert not any(kind.startswith(("shop/", "amenity/")) for kind, _ in READER.read(name).kinds)


def test_a_known_word_is_not_taken_for_a_slip() -> None:
    assert dict(READER.read("洗护用品").kinds).keys().isdisjoint({"medical_supply"})
