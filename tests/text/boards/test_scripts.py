from dataclasses import replace

import pytest

from lpslam.language.model import Slots
from lpslam.language.tables.forms import load_folder
from lpslam.text.boards.scripts import in_one_script, script_ahead
from lpslam.text.placing.places import Place, places_of_class
from small_maps import small_map


def board(*names: str) -> list[Place]:
    world = small_map([f"Sign {number}" for number in range(len(names))], spacing=0.4)
    config = world.text.config
    found = [
        place
        for each in world.text.long_term
        for place in places_of_class(each, world.world_from_keyframe, config.instances, config.memory)
    ]
    return [replace(place, name=name) for place, name in zip(found, names, strict=True)]


def read_as(taken: str, other: str, probability: float) -> Slots:
    return (((taken, 1.0 - probability), (other, probability)),)


def names(lines: list[Place], slots: Slots) -> list[str]:
    return [place.name for place in in_one_script(lines, lambda place: [slots])]


def test_a_line_of_a_traditional_board_is_traditional_where_the_reader_held_it_for_possible() -> None:
    lines = board("石橋麵館", "正宗粤菜", "訂餐熱線")
    assert names(lines, read_as("粤", "粵", 0.01)) == ["石橋麵館", "正宗粵菜", "訂餐熱線"]


@pytest.mark.parametrize("painted", [["石桥面馆", "正宗粤菜"], ["正宗粤菜"], ["Dim sum", "正宗粤菜"]])
def test_other_boards_stay_as_they_were_read(painted: list[str]) -> None:
    assert names(board(*painted), read_as("粤", "粵", 0.2)) == painted


def test_a_form_that_is_clearly_painted_stays() -> None:
    painted = ["石橋麵館", "點心", "正宗粤菜"]
    assert names(board(*painted), ()) == painted
    assert names(board(*painted), read_as("粤", "奥", 0.3)) == painted


@pytest.mark.parametrize(
    ("painted", "taken", "other"),
    [("恒興銀樓", "恒", "恆"), ("周記麵館", "周", "週"), ("姜記藥局", "姜", "薑"), ("沈氏診所", "沈", "瀋")],
)
def test_a_form_that_traditional_texts_have_as_well_is_not_exchanged(painted: str, taken: str, other: str) -> None:
    assert names(board(painted, "訂餐熱線"), read_as(taken, other, 0.1))[0] == painted


@pytest.mark.parametrize("painted", ["恒興銀樓", "老家餐廳", "酸辣湯麵", "梁氏藥局", "余記麵館"])
def test_traditional_texts_with_such_forms_do_not_mix_scripts(painted: str) -> None:
    assert load_folder().is_traditional(painted)
    assert not load_folder().is_mixed(painted)


def test_a_traditional_name_stays_on_a_simplified_board() -> None:
    painted = ["飛鶴", "正宗粤菜", "订餐热线"]
    assert names(board(*painted), read_as("飛", "飞", 0.3)) == painted


STREET = ["永豐銀樓", "石橋麵館", "飛鶴書店", "恆發藥局", "華新電器", "東門燒臘", "鴻興眼鏡", "聯合診所"]


def in_a_street(own: str, around: list[str], slots: Slots) -> str:
    boards = [board(name) for name in [own, *around]]
    ahead = script_ahead(boards)[0]
    return in_one_script(boards[0], lambda place: [slots], ahead)[0].name


def test_a_lone_line_is_in_the_script_of_its_street_where_the_reader_held_that_for_possible() -> None:
    possible, hardly = read_as("满", "滿", 0.15), read_as("满", "滿", 0.005)
    assert in_a_street("金玉满堂", STREET, possible) == "金玉滿堂"
    assert in_a_street("金玉满堂", STREET, hardly) == "金玉满堂"
    assert in_a_street("金玉满堂", [], possible) == "金玉满堂"
    assert in_a_street("金玉满堂", ["永丰银楼", "石桥面馆", *STREET[:2]], possible) == "金玉满堂"
    assert in_a_street("鸿兴银楼满", STREET, possible) == "鸿兴银楼满"
