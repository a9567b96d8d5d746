"""Refusals told as clauses of their own, before or after what is wanted, in seven languages."""

from collections.abc import Sequence

import pytest

from language.asking import solved
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.polarity import parted_by_clauses

MODEL = OfflineModel()


def found(question: str, boards: Sequence[str]) -> str | None:
    return solved(MODEL, question, [(name,) for name in boards])[-1]


@pytest.mark.parametrize(
    ("language", "text", "wanted", "refused"),
    [
        ("en", "Tea? No. Juice? No. I want a coffee.", "I want a coffee", ["Tea", "Juice"]),
        ("en", "a bench, not the wet one, my coat is new", "a bench", ["wet one"]),
        ("en", "a gym yes, swimming no", "a gym", ["swimming"]),
        ("de", "Musik ja, aber bitte nicht vom Orchester, das ist mir zu laut", "Musik", ["Orchester"]),
        ("de", "ein Bad – nicht das im Keller und nicht bei den Gästen", "ein Bad", ["Keller", "Gästen"]),
        ("fr", "un cours, pas pour les enfants", "un cours", ["enfants"]),
        ("es", "Bailar sí, cantar no", "Bailar", ["cantar"]),
        ("zh", "想喝点东西，不要酒，也不要咖啡", "想喝点东西", ["酒", "咖啡"]),
        ("ja", "休める場所がほしいです。喫茶店以外で", "休める場所がほしいです", ["喫茶店"]),
        ("ko", "공항에 가야 해요. 택시는 싫어요", "공항에 가야 해요", ["택시"]),
    ],
)
def test_clauses_that_refuse_are_parted(language: str, text: str, wanted: str, refused: list[str]) -> None:
    assert parted_by_clauses(text, language) == (wanted, refused)


@pytest.mark.parametrize(
    ("language", "text"),
    [
        ("en", "my car won't start, where is a garage"),
        ("en", "somewhere not far"),
        ("de", "ich kann die Kasse nicht finden"),
        ("fr", "je ne trouve pas la sortie"),
        ("es", "no encuentro mi maleta"),
        ("zh", "拉链坏了，拉不上去"),
    ],
)
def test_what_only_tells_refuses_nothing(language: str, text: str) -> None:
    assert parted_by_clauses(text, language) is None


@pytest.mark.parametrize(
    ("question", "boards", "board"),
    [
        # What is refused is of what is wanted: so the rest was understood.
        (
            "Je veux apprendre un instrument, mais ni la flûte ni la harpe",
            ("Flûte", "Harpe", "Violoncelle", "Accueil"),
            "Violoncelle",
        ),
        ("a library, not the one for kids", ("Library for Children", "Library", "Café"), "Library"),
        # All that serves is refused by its name.
        ("Etwas zu trinken, Hauptsache nicht bei Seeblick", ("Café Seeblick", "Buchladen"), None),
    ],
)
def test_what_is_left_serves(question: str, boards: Sequence[str], board: str | None) -> None:
    assert found(question, boards) == board


@pytest.mark.parametrize(
    ("question", "boards", "board"),
    [
        ("a meeting room, not B12, the other one", ("Meeting Room B12", "Meeting Room B14"), "Meeting Room B14"),
        ("a locker, not 1 to 40, those are full", ("Lockers 1–40", "Lockers 41–80"), "Lockers 41–80"),
    ],
)
def test_numbers_and_kinds_are_left_out(question: str, boards: Sequence[str], board: str) -> None:
    assert found(question, boards) == board


def test_refusals_tell_places_of_a_sort_apart() -> None:
    for question, boards, board in (
        ("locker room, but not the guys one", ("Boys’ Locker Room", "Girls’ Locker Room", "Gym"), "Girls’ Locker Room"),
        ("to the kennels, not Block A though", ("Kennel Block A", "Kennel Block B", "Office"), "Kennel Block B"),
        (
            "上课的教室，不是Nordkette那间",
            ("Kursraum Nordkette", "Kursraum Patscherkofel", "WC"),
            "Kursraum Patscherkofel",
        ),
    ):
        assert found(question, boards) == board
