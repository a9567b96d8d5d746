"""Wishes that refuse something: what serves what is wanted, less what serves what is refused, in seven languages."""

from collections.abc import Sequence

import pytest

from language.asking import solved
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.rules import parted

MODEL = OfflineModel()


def found(question: str, boards: Sequence[str]) -> str | None:
    return solved(MODEL, question, [(name,) for name in boards])[-1]


@pytest.mark.parametrize(
    ("language", "text", "wanted", "refused"),
    [
        ("en", "a class, but neither yoga nor pilates", "a class", ["yoga", "pilates"]),
        ("de", "ein Kurs, aber nichts mit Tanzen", "ein Kurs", ["Tanzen"]),
        ("fr", "un atelier, mais sans peinture", "un atelier", ["peinture"]),
        ("es", "un taller, pero nada de pintura", "un taller", ["pintura"]),
        ("zh", "想吃点东西，不吃牛肉", "想吃点东西", ["牛肉"]),
        ("ko", "뭔가 먹고 싶은데, 고기는 못 먹어요", "뭔가 먹고 싶", ["고기"]),
        ("en", "shoes, not for running but for dancing", "shoes for dancing", ["for running"]),
        ("de", "Schuhe, nicht zum Laufen, sondern zum Tanzen", "Schuhe zum Tanzen", ["zum Laufen"]),
        ("de", "ein Kurs, weder Yoga noch Pilates", "ein Kurs", ["Yoga", "Pilates"]),
        ("fr", "des chaussures, pas de course, plutôt de danse", "des chaussures de danse", ["course"]),
        ("es", "zapatos, no de correr sino de bailar", "zapatos de bailar", ["correr"]),
        ("zh", "买鞋，不要跑步的，要跳舞的", "买鞋 跳舞的", ["跑步的"]),
        ("ja", "靴、走るのじゃなくて踊るの", "靴 踊るの", ["走るの"]),
        ("ko", "신발, 달리기 말고 춤추는 걸로", "신발 춤추는 걸로", ["달리기"]),
    ],
)
def test_a_text_is_parted_by_its_refusal(language: str, text: str, wanted: str, refused: list[str]) -> None:
    assert parted(text, language) == (wanted, refused)


@pytest.mark.parametrize(
    ("question", "boards", "board"),
    [
        ("un atelier, mais rien de poterie", ("Atelier poterie", "Atelier couture", "Accueil"), "Atelier couture"),
        ("eine Ausstellung, aber weder Waffen noch Münzen", ("Waffenkammer", "Gemäldegalerie", "WC"), "Gemäldegalerie"),
    ],
)
def test_what_is_refused_is_left_out(question: str, boards: Sequence[str], board: str) -> None:
    assert found(question, boards) == board


@pytest.mark.parametrize(
    ("question", "boards", "expected"),
    [
        ("a ballroom, but not A, that's the wedding of the other people", ("연회장 A", "연회장 B"), "연회장 B"),
        ("el almacén, pero el A no", ("Almacén A", "Almacén B"), "Almacén B"),
    ],
)
def test_a_letter_alone_is_refused(question: str, boards: tuple[str, ...], expected: str) -> None:
    assert found(question, boards) == expected


def test_a_number_is_heeded_where_a_kind_is_read() -> None:
    assert found("Squash 9", ("Squash 1-4", "Toilets")) is None


@pytest.mark.parametrize(
    ("question", "boards", "expected"),
    [
        (
            "hab bock auf was Fettiges auf die Hand, aber bloß nich McDonalds",
            ["Bratwurst-Stand Uwe", "McDonald's", "WC", "Apotheke", "Gleis 1", "Bäckerei Korn"],
            "Bratwurst-Stand Uwe",
        ),
    ],
)  # fmt: skip
def test_what_is_like_a_refused_brand_is_left_though_the_brand_serves_far_better(
    question: str, boards: Sequence[str], expected: str
) -> None:
    assert found(question, boards) == expected


@pytest.mark.parametrize(
    ("question", "boards", "expected"),
    [
        (
            "a meeting room please, but not 12, that one is taken",
            ("Conference Hall", "Meeting Room 12", "Meeting Room 14"),
            "Meeting Room 14",
        ),
        ("会议室，除了305", ("多功能厅", "305 会议室", "307 会议室"), "307 会议室"),
        (
            "une salle de réunion, mais pas la 4",
            ("Amphi", "Salle de réunion 4", "Salle de réunion 6"),
            "Salle de réunion 6",
        ),
    ],
)
def test_of_what_is_refused_by_its_number_another_one_is_meant(
    question: str, boards: tuple[str, ...], expected: str
) -> None:
    assert found(question, boards) == expected
