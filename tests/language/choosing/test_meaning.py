"""Texts that have a sense in common without a common word."""

import numpy as np
import pytest

from lpslam.language.choosing.meaning import Pieces, folded, load_senses, packed


def nearest(question: str, boards: tuple[str, ...]) -> str:
    senses = load_senses()
    return boards[int(np.argmax(senses.boards(boards) @ senses.asked(question)))]


BOARDS = ("Cloakroom", "Dentist", "Aquarium", "Bakery", "Laundry")


@pytest.mark.parametrize(
    ("question", "board"),
    [
        ("my tooth hurts", "Dentist"),
        ("me duele una muela", "Dentist"),
        ("ich will Fische sehen", "Aquarium"),
        ("焼きたてのパンがほしい", "Bakery"),
        ("我想洗衣服", "Laundry"),
        ("où laisser mon manteau", "Cloakroom"),
    ],
)
def test_a_question_is_nearest_to_the_board_that_it_means(question: str, board: str) -> None:
    assert nearest(question, BOARDS) == board


def test_letters_of_no_piece_and_empty_texts_say_nothing() -> None:
    senses = load_senses()
    assert not senses.asked("").any()
    assert not senses.asked("\U00012000\U00012001").any()
    assert np.isfinite(senses.boards(["", "Bakery"])).all()


def test_one_form_of_each_letter_is_read() -> None:
    senses = load_senses()
    assert folded("  ＢＡＫＥＲＹ\n Ｃafé ") == "bakery café"
    assert np.array_equal(senses.asked("BAKERY"), senses.asked("ｂａｋｅｒｙ"))


def test_a_text_is_cut_into_the_likeliest_pieces() -> None:
    pieces = Pieces(("▁", "▁b", "an", "k", "a", "n", "▁bank"), np.array([-1.0, -5.0, -5.0, -5.0, -6.0, -6.0, -8.0]))
    assert [pieces.texts[row] for row in pieces.of("bank")] == ["▁bank"]
    assert [pieces.texts[row] for row in pieces.of("ban")] == ["▁b", "an"]
    assert [pieces.texts[row] for row in pieces.of("b?n")] == ["▁b", "n"]


def test_four_bits_keep_what_is_written() -> None:
    rng = np.random.default_rng(0)
    vectors = rng.normal(size=(3, 8)).astype(np.float32)
    turns = (np.eye(8, dtype=np.float32), np.eye(8, dtype=np.float32))
    written = packed(Pieces(("▁a", "b", "c"), np.array([-1.0, -1.0, -1.0])), vectors, turns, {"toilet": vectors[0]})
    rows = written["rows"]
    numbers = np.stack([rows >> 4, rows & 15], axis=-1).reshape(3, 8)
    error = (numbers - 7.5) * written["scale"][:, None] - vectors
    assert np.abs(error).max() <= 0.51 * written["scale"].max()


def test_no_texts_have_no_vectors() -> None:
    senses = load_senses()
    assert senses.boards([]).shape == (0, len(senses.asked("Bakery")))
