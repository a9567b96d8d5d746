"""Roles of lines by size and form; all words are made up."""

import pytest

from lpslam.text.boards.roles import LineShape, Role, role_by_form, roles_of


def line(text: str, letter: float, x: float, y: float, sure: float = 0.95) -> LineShape:
    width = 0.6 * letter * len(text)
    return LineShape(text, letter, x, y, x + width, y + letter, sure)


@pytest.mark.parametrize(
    ("text", "role"),
    [
        ("+49 30 5550 199", Role.CONTACT),
        ("專線 5550-1942", Role.CONTACT),
        ("www.velmora.example", Role.CONTACT),
        ("info@velmora.example", Role.CONTACT),
        ("Lu-Ve 8:30-19:00", Role.CONTACT),
        ("9am to 5pm", Role.CONTACT),
        ("17 Quill Street", Role.CONTACT),
        ("Fenstraße 12", Role.CONTACT),
        ("梅溪路219號", Role.CONTACT),
        ("Sopa 4,50 €", Role.LIST),
        ("湯麵 60元", Role.LIST),
        ("Broth 3.20", Role.LIST),
        ("VELMORA STREET", None),
        ("SINCE 1931", None),
        ("No. 7", None),
    ],
)
def test_the_form_of_a_line_tells_contacts_and_prices(text: str, role: Role | None) -> None:
    assert role_by_form(text) is role


def test_a_board_is_called_by_its_largest_line_and_not_by_its_number() -> None:
    lines = [line("fine quills", 0.1, 0, 0), line("VELMORA", 0.2, 0, 0.2), line("5550 19420", 0.3, 0, 0.5)]
    assert roles_of(lines) == (1, [Role.SECONDARY, Role.PRIMARY, Role.CONTACT])


def test_a_menu_is_a_list_called_by_its_first_entry_that_can_be_read() -> None:
    lines = [line(text, 0.1, 0, 0.15 * row) for row, text in enumerate(("Bramble", "Brindle", "Marrow", "Tansy"))]
    lines[0] = line("Brqxmle", 0.1, 0, 0, sure=0.05)
    assert roles_of(lines) == (1, [Role.LIST] * 4)


def test_a_number_beside_an_unsure_name_is_not_the_name() -> None:
    lines = [line("411", 0.25, 0, 0, sure=0.6), line("OSTER LANE", 0.25, 0, 0.3, sure=0.1)]
    assert roles_of(lines)[0] == 1


@pytest.mark.parametrize("measure", ["MAX 2500 RPM", "120 kg net", "40% more", "載重630公斤"])
def test_a_measure_is_not_the_name_though_it_is_longer(measure: str) -> None:
    lines = [line("OSTER 4", 0.1, 0, 0), line(measure, 0.11, 0, 0.2)]
    assert roles_of(lines) == (0, [Role.PRIMARY, Role.SECONDARY])
    assert roles_of(lines[1:]) == (0, [Role.PRIMARY]), "where nothing else stands there it is"


@pytest.mark.parametrize("name", ["3M", "GATE 2 A", "STUDIO 54"])
def test_a_number_before_a_letter_is_part_of_a_name(name: str) -> None:
    assert roles_of([line(name, 0.2, 0, 0), line("quills", 0.1, 0, 0.3)])[0] == 0
