import io
from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from lpslam.text.types import Landmark, LandmarkLine
from lpslam.views.drawable import printable, with_known_glyphs
from lpslam.views.tables import facts_table, landmark_table


def mark(identifier: int, name: str, verdict: bool | None, seen: int = 5) -> Landmark:
    return Landmark(
        identifier, name, {name: seen}, np.array([1.0, -2.0, 3.456]), np.array([0, 1.0, 0]), 0.05, 1, 0.3, seen, 0.9,
        is_landmark=verdict,
    )  # fmt: skip


def shown(table: object) -> str:
    buffer = io.StringIO()
    Console(file=buffer, width=200, color_system=None).print(table)
    return buffer.getvalue()


def test_the_table_of_landmarks_puts_them_first_and_takes_no_name_for_markup() -> None:
    marks = [mark(1, "[red]SALE[/red]", None), mark(2, "\x1b[2JDANGER", False), mark(3, "必胜客", True)]
    text = shown(landmark_table(marks))
    assert text.index("必胜客") < text.index("SALE")
    assert "[red]SALE[/red]" in text
    assert "\x1b" not in text
    assert "1.00 -2.00 3.46" in text
    assert "x y z [m]" in text
    assert "–" in text


def test_the_other_lines_of_a_board_stand_under_its_name() -> None:
    lines = tuple(
        LandmarkLine(text, "list", 0.9, np.zeros(3), 1, 0.1, 5) for text in ("KOKE", "[b]COLOMBIA[/b]", "KOKE")
    )
    text = shown(landmark_table([replace(mark(1, "KOKE", None), lines=lines)]))
    assert "[b]COLOMBIA[/b] · KOKE" in text
    assert text.count("KOKE") == 2


def test_facts_are_shown_as_they_are() -> None:
    text = shown(facts_table({"name": "[b]x[/b]", "frames": "900"}, title="a map"))
    assert "[b]x[/b]" in text
    assert "900" in text


@given(st.text())
def test_printable_text_is_one_short_line_without_control(text: str) -> None:
    line = printable(text, longest=20)
    assert len(line) <= 20
    assert line == " ".join(line.split())
    assert all(char.isprintable() for char in line)


def test_glyphs_that_a_font_lacks_are_replaced() -> None:
    assert with_known_glyphs("a🍕b", {ord("a"), ord("b")}) == "a?b"
