"""Where no space parts words, common Chinese words tell the likelier string."""

from lpslam.language.model import Reading, Slots
from lpslam.language.naming.marks import is_in_a_word, words_in
from lpslam.language.offline import embedded_model


def slots(read: str, at: int, taken: float, other: str, possible: float) -> Slots:
    return tuple(
        ((letter, taken), (other, possible)) if place == at else ((letter, 0.99),) for place, letter in enumerate(read)
    )


def test_a_key_is_cut_into_the_fewest_listed_words_that_cover_most_of_it() -> None:
    assert words_in("欢迎光临") == ["欢迎光临"]
    assert words_in("珍珠奶茶88元") == ["珍珠", "奶茶"]
    assert words_in("kfc") == words_in("") == []
    assert is_in_a_word("菠萝包", 1)
    assert not is_in_a_word("菠梦包", 1)


def test_a_letter_that_makes_a_word_is_preferred_to_a_likelier_one_that_makes_none() -> None:
    """A leaf hides the stroke that tells the two; the reader holds both for possible, the second hardly."""
    read = [Reading("自鷺電器", 6, 0.95, 0.7, 1.5, slots("自鷺電器", 0, 0.96, "白", 0.03))]
    assert embedded_model().name(read).name == "白鷺電器"


def test_a_letter_that_the_reader_is_sure_of_stays_though_another_made_a_word() -> None:
    read = [Reading("自鷺電器", 6, 0.99, 0.97, 3.0)]
    assert embedded_model().name(read).name == "自鷺電器"


def test_what_is_read_well_needs_no_kind_of_shop_at_its_end() -> None:
    """The same with one more character is a kind of shop; what was read is two words."""
    read = [Reading("珍珠奶茶", 5, 0.99, 0.97, 2.0), Reading("珍珠奶茶", 4, 0.99, 0.9, 1.0, whole=(0.3, 1.0))]
    assert embedded_model().name(read).name == "珍珠奶茶"
