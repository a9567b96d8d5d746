from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.language.model import Naming
from lpslam.text.boards.boards import boards
from lpslam.text.boards.lines import as_measured, lines_of
from lpslam.text.boards.overlaps import overlap, without_overlaps
from lpslam.text.placing.places import Place, places_of_class
from lpslam.text.remembering.memory import Pool, TextClass, Variant
from lpslam.text.types import Bearing, Placement, TextObservation

CONFIG, MEMORY = InstanceConfig(), MemoryConfig()


def place(
    identifier: int,
    name: str,
    x: float,
    y: float,
    *,
    width: float = 1.0,
    height: float = 0.2,
    count: int = 10,
    frames: range | None = None,
    z: float = 3.0,
    normal: tuple[float, float, float] = (0.0, 0.0, -1.0),
) -> Place:
    """A text on a wall before the camera: x right, y down."""
    position = np.array([x, y, z])
    # A pose error that all texts of a frame share, far larger than the gaps between lines.
    shake = np.random.default_rng(5).normal(scale=0.3, size=(100, 3))
    return Place(
        id=identifier,
        name=name,
        variants={name: count},
        position=position,
        normal=np.array(normal),
        baseline=np.array([1.0, 0.0, 0.0]),
        spread=0.02,
        width=width,
        height=height,
        positions_by_frame={frame: position + shake[frame] for frame in (frames or range(count))},
        normals_by_frame={frame: np.array(normal) for frame in (frames or range(count))},
        grounds_by_frame={},
        observations=count,
        evidence=0.95 * count,
        confidence=0.95,
    )


def names(groups: list[list[Place]]) -> list[list[str]]:
    """What boards say, line by line."""
    return [[line.text for line in lines_of(group)[1]] for group in groups]


def test_lines_of_a_bilingual_board_are_joined_top_to_bottom() -> None:
    found = boards([place(0, "STARBUCKS", 0, 0.3, height=0.15), place(1000, "星巴克", 0.1, 0.0, width=0.8)], CONFIG)
    assert names(found) == [["星巴克", "STARBUCKS"]]


def test_words_of_a_line_are_joined_left_to_right() -> None:
    words = [place(0, "HUT", 0.95, 0.01, width=0.6), place(1000, "PIZZA", 0.0, 0.0), place(2000, "必胜客", 0.4, -0.25)]
    assert names(boards(words, CONFIG)) == [["必胜客", "PIZZA HUT"]]


@pytest.mark.parametrize(
    "other",
    [
        place(1000, "DOOR", 0.0, 0.9),  # far below
        place(1000, "NEXT SHOP", 1.6, 0.0),  # the neighbour on the same fascia
        place(1000, "BEHIND", 0.0, 0.25, z=3.4),  # on another surface
        place(1000, "TURNED", 0.0, 0.25, normal=(-0.8, 0.0, -0.6)),
    ],
)
def test_what_is_not_on_the_board_stays_apart(other: Place) -> None:
    assert len(boards([place(0, "STARBUCKS", 0.0, 0.0), other], CONFIG)) == 2


def test_lines_never_seen_together_are_joined_by_where_they_stand() -> None:
    lines = [place(0, "ATM", 0, 0), place(1000, "自动取款机", 0, 0.25, frames=range(50, 60))]
    assert names(boards(lines, CONFIG)) == [["ATM", "自动取款机"]]


def test_no_places_no_boards() -> None:
    assert boards([], CONFIG) == []


def test_overlap_is_of_the_smaller() -> None:
    whole, half = place(0, "STARBUCKS", 0.0, 0.0), place(1, "STAR", -0.25, 0.0, width=0.5)
    assert overlap(whole, half) == pytest.approx(1.0)
    assert overlap(whole, place(1, "STAR", -0.5, 0.0, width=0.5)) == pytest.approx(0.5)
    assert overlap(whole, place(1, "STAR", -0.25, 0.0, width=0.5, z=3.5)) == 0.0
    assert overlap(whole, place(1, "STAR", -0.25, 0.0, width=0.5, normal=(0, 0, 1))) == 0.0


@pytest.mark.parametrize("contact", ["Tel. 0221 403118", "9:00-18:30", "19 Harbour Road", "人民路128號"])
def test_a_contact_belongs_to_a_name_that_stands_too_far_off_to_share_a_board_with_another(contact: str) -> None:
    name = place(0, "FERN BOOKS", 0.0, 0.0)
    far = {"width": 0.8, "height": 0.15}
    assert names(boards([name, place(1000, contact, 1.4, 0.0, **far)], CONFIG)) == [["FERN BOOKS", contact]]
    assert len(boards([name, place(1000, "OAK SHOES", 1.4, 0.0, **far)], CONFIG)) == 2
    # Its own name being nearer, it does not draw the neighbour in.
    neighbour = place(2000, "OAK SHOES", 2.8, 0.0)
    found = boards([name, place(1000, contact, 1.2, 0.0, **far), neighbour], CONFIG)
    assert names(found) == [["FERN BOOKS", contact], ["OAK SHOES"]]


def test_fragments_and_misreadings_yield_to_the_text_that_stands_there() -> None:
    whole = place(0, "STARBUCKS", 0.0, 0.0)
    fragment = place(1000, "STARB", -0.2, 0.0, width=0.6, count=25)
    misreading = place(2000, "5TPREJGE5", 0.0, 0.02, count=3)
    below = place(3000, "COFFEE", 0.0, 0.4)
    assert [each.name for each in without_overlaps([fragment, misreading, below, whole], CONFIG, MemoryConfig())] == [
        "STARBUCKS",
        "COFFEE",
    ]


def test_a_longer_text_read_once_in_a_while_does_not_replace_a_sure_one() -> None:
    sure, odd = place(0, "KFC", 0.0, 0.0, count=30), place(1000, "KFC lll", 0.05, 0.0, count=2)
    assert [each.name for each in without_overlaps([sure, odd], CONFIG, MemoryConfig())] == ["KFC"]


def observations(text: str, x: float, count: int, first: int = 0, right: float = 0.9) -> list[TextObservation]:
    placement = Placement((x, 0.0, 3.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.8, 0.2, 0.01)
    return [
        TextObservation(first + number, 0.1 * number, number, text, 0.9, placement, 24.0, right=right)
        for number in range(count)
    ]


def text_class(seen: list[TextObservation], name: str) -> TextClass:
    variants: dict[str, Variant] = {}
    for each in seen:
        variant = variants.setdefault(each.text, Variant())
        variant.count, variant.confidence = variant.count + 1, variant.confidence + each.confidence
    naming = Naming(name, 1.0, "", "test")
    return TextClass(7, 0.0, 1.0, variants, 5.0, Pool.LONG_TERM, 0.5, [], seen, naming=naming)


def world(_: int) -> NDArray[np.float64]:
    return np.eye(4)


def test_each_place_of_a_class_is_a_place_with_a_stable_id() -> None:
    seen = (
        observations("EXIT", 0.0, 5) + observations("EXIT", 9.0, 4, first=20) + observations("EX1T", 4.0, 1, first=40)
    )
    found = places_of_class(text_class(seen, "EXIT"), world, CONFIG, MEMORY)
    assert [(each.id, each.observations) for each in found] == [(7000, 5), (7001, 4)]
    longer = places_of_class(text_class(seen + observations("EXIT", 20.0, 3, first=60), "EXIT"), world, CONFIG, MEMORY)
    assert [each.id for each in longer] == [7000, 7001, 7003]


def test_a_class_seen_once_still_stands_somewhere() -> None:
    assert len(places_of_class(text_class(observations("EXIT", 0.0, 1), "EXIT"), world, CONFIG, MEMORY)) == 1
    assert (
        places_of_class(
            replace(text_class(observations("EXIT", 0.0, 1), "EXIT"), observations=[]), world, CONFIG, MEMORY
        )
        == []
    )


def test_another_word_at_another_place_keeps_its_own_name() -> None:
    seen = observations("WASHROOM", 0.0, 6) + observations("BATHROOM", 8.0, 4) + observations("WASHR0OM", 16.0, 4)
    found = places_of_class(text_class(seen, "WASHROOM"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["WASHROOM", "BATHROOM", "WASHROOM"]


def test_rooms_that_differ_in_a_digit_keep_their_numbers() -> None:
    seen = observations("MEETING ROOM 2", 0.0, 6) + observations("MEETING ROOM 1", 8.0, 3)
    seen += observations("MEETING ROOM!", 8.0, 2, right=0.5) + observations("MEETING ROOME", 8.0, 1, right=0.5)
    found = places_of_class(text_class(seen, "MEETING ROOM 2"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["MEETING ROOM 2", "MEETING ROOM 1"]


def test_a_price_keeps_its_comma_where_its_class_is_called_by_another() -> None:
    seen = observations("450", 0.0, 6) + observations("490", 8.0, 9, first=20) + observations("4,90", 8.0, 2, first=40)
    found = places_of_class(text_class(seen, "450"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["450", "4,90"]


def test_a_name_is_as_sure_as_its_own_place_says_where_other_places_of_the_class_say_another() -> None:
    seen = observations("ROOM 201", 0.0, 6, right=0.97) + observations("ROOM 204", 8.0, 6, right=0.97)
    class_of_two = text_class(seen, "ROOM 201")
    class_of_two.naming = Naming("ROOM 201", 0.13, "", "test")
    found = places_of_class(class_of_two, world, CONFIG, MEMORY)
    assert [(each.name, each.confidence > 0.9) for each in found] == [("ROOM 201", True), ("ROOM 204", True)]
    badly = observations("ROOM 201", 0.0, 6, right=0.3) + observations("ROOM 204", 8.0, 6, right=0.97)
    class_of_two.observations = badly
    assert places_of_class(class_of_two, world, CONFIG, MEMORY)[0].confidence < 0.5


def test_of_another_text_the_whole_is_the_name_and_not_the_piece_that_is_like_the_class() -> None:
    seen = observations("Orchid Salon", 0.0, 6) + observations("SALE", 8.0, 1, right=0.99)
    seen += observations("BIG SALE", 8.0, 1, first=20, right=0.99) + observations("BOG SALE", 8.0, 1, 30, right=0.45)
    found = places_of_class(text_class(seen, "Orchid Salon"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["Orchid Salon", "BIG SALE"]


def carried(speed: float, seconds: float = 2.0, count: int = 12) -> TextClass:
    """A class read again and again while it moves along at `speed` metres a second."""
    text_class = TextClass(0, 0.0, seconds)
    rng = np.random.default_rng(4)
    for number in range(count):
        elapsed = seconds * number / (count - 1)
        x, y, z = rng.normal([speed * elapsed, 0.0, 2.0], 0.02)
        placement = Placement((x, y, z), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.4, 0.1, 0.01)
        text_class.observations.append(TextObservation(number, elapsed, 0, "STAFF", 0.9, placement, 24.0))
    text_class.variants["STAFF"] = Variant(count, 0.9 * count)
    return text_class


@pytest.mark.parametrize(("speed", "stands"), [(0.0, True), (0.8, False), (1.4, False)])
def test_a_text_on_someone_who_walks_by_is_no_landmark(speed: float, stands: bool) -> None:
    assert bool(places_of_class(carried(speed), lambda _: np.eye(4), InstanceConfig(), MEMORY)) == stands


def test_drift_over_a_minute_is_no_walk() -> None:
    assert places_of_class(carried(0.01, 60.0), lambda _: np.eye(4), InstanceConfig(), MEMORY)


def test_lines_on_different_grounds_are_two_boards() -> None:
    first, second = place(0, "COMPUTER", 0.0, 0.0), place(1000, "DAEDALUS", 0.0, 0.12)
    assert len(boards([first, second], InstanceConfig())) == 1
    black, purple = dict.fromkeys(range(9), (20, 20, 25)), dict.fromkeys(range(9), (130, 60, 140))
    on_two = [replace(first, grounds_by_frame=black), replace(second, grounds_by_frame=purple)]
    assert len(boards(on_two, InstanceConfig())) == 2


@pytest.mark.parametrize("lines", [1, 2, 6])
def test_boards_of_many_lines_on_different_grounds_are_two_however_many(lines: int) -> None:
    """Lines at the far ends are too far apart to be compared; they say nothing for one board."""
    white, green = dict.fromkeys(range(9), (230, 230, 230)), dict.fromkeys(range(9), (90, 200, 90))
    left = [place(1000 * k, f"LEFT {k}", -0.52 - 1.04 * k, 0.0) for k in range(lines)]
    right = [place(100_000 + 1000 * k, f"RIGHT {k}", 0.52 + 1.04 * k, 0.0) for k in range(lines)]
    painted = [replace(each, grounds_by_frame=white) for each in left]
    painted += [replace(each, grounds_by_frame=green) for each in right]
    found = [{each.name for each in group} for group in boards(painted, CONFIG)]
    assert found == [{each.name for each in left}, {each.name for each in right}]


@pytest.mark.parametrize(
    ("height", "name", "ink", "sheets"),
    [
        (0.2, "OSTERBY", (220, 220, 225), 2),
        (0.1, "OSTERBY", (220, 220, 225), 1),  # in smaller letters, as on a stripe of another colour
        (0.2, "+44 20 7946 0018", (220, 220, 225), 1),
        (0.2, "OSTERBY", (75, 70, 75), 1),  # ink and ground were taken for each other
    ],
)
def test_two_names_of_one_size_in_one_ink_on_unlike_grounds_are_on_two_sheets(
    height: float, name: str, ink: tuple[int, int, int], sheets: int
) -> None:
    def on(each: Place, bare: tuple[int, int, int], ink: tuple[int, int, int]) -> Place:
        # Between thick letters the ground of both is mostly blur.
        seen = [dict.fromkeys(range(9), colour) for colour in ((150, 105, 130), ink, bare)]
        return replace(each, grounds_by_frame=seen[0], inks_by_frame=seen[1], bare_by_frame=seen[2])

    first = on(place(0, "VELMORA", 0.0, 0.0), (75, 65, 70), (225, 225, 225))
    second = on(place(1000, name, 0.0, 0.1 + height / 2, height=height), (150, 105, 150), ink)
    assert len(boards([first, second], CONFIG)) == sheets
    apart = replace(second, bare_by_frame={99: (150, 105, 150)})
    assert len(boards([first, apart], CONFIG)) == 1, "light differs from frame to frame"
    assert len(boards([first, replace(second, inks_by_frame={})], CONFIG)) == 1, "nobody knows its ink"
    lit = [on(each, (21, green, 25), (94, 251, 123)) for each, green in ((first, 64), (second, 27))]
    assert len(boards(lit, CONFIG)) == 1, "letters glow on a dark ground"
    # Below a larger name they are lines of its board.
    name = on(place(2000, "TANSY QUILLS", 0.0, -0.3, height=0.4), (75, 65, 70), (225, 225, 225))
    assert len(boards([name, first, second], CONFIG)) == 1


@pytest.mark.parametrize(
    ("name", "width", "height", "found"),
    [
        ("廣和堂", 0.3, 1.2, 2),
        ("HARTLEY", 1.2, 0.3, 1),  # runs across as well
        ("廣和堂", 0.15, 0.6, 1),  # half as large: what a board says beside its name
        ("0755 8320 1166", 0.3, 1.2, 1),  # a telephone number is some board's
    ],
)
def test_two_names_of_one_size_one_across_and_one_down_are_on_two_boards(
    name: str, width: float, height: float, found: int
) -> None:
    across = place(0, "平价五金", 0.0, 0.0, width=1.2, height=0.3)
    # As near as two lines of one board are, on a ground as dark.
    beside = place(1000, name, 0.72 + width / 2.0, 0.0, width=width, height=height)
    assert len(boards([across, beside], CONFIG)) == found


def test_texts_that_may_be_some_way_off_are_on_one_board_as_surely_as_their_surfaces_differ() -> None:
    name = place(0, "MEADOW BARBER", 0.0, 0.0, height=0.3)
    behind = place(1000, "TEL 020 7946 6437", 0.0, 0.35, z=3.3)
    assert len(boards([name, behind], CONFIG)) == 2, "depth of both says that they are on two surfaces"
    # One was placed by what is around it, as a lit board without depth is.
    assert len(boards([name, replace(behind, uncertainty=0.3)], CONFIG)) == 1
    # Which hides no wall half a metre behind.
    far = replace(place(1000, "COPPER FOX", 0.0, 0.7, z=3.4, height=0.3), uncertainty=0.1)
    assert len(boards([name, far], CONFIG)) == 2


def test_texts_that_lie_over_one_another_are_no_pieces_of_one_line() -> None:
    upper = replace(place(0, "COLOMBIA", 0.0, 0.0, width=0.6, height=0.14), uncertainty=0.2)
    lower = replace(place(1000, "KOKE", 0.07, 0.03, width=0.45, height=0.14, z=3.3), uncertainty=0.3)
    _, lines = lines_of([upper, lower])
    assert sorted(each.text for each in lines) == ["COLOMBIA", "KOKE"]
    # Boxes are somewhat larger than their words.
    beside = place(1000, "KOKE", 0.5, 0.03, width=0.45, height=0.14)
    assert [each.text for each in lines_of([upper, beside])[1]] == ["COLOMBIA KOKE"]


def test_columns_and_rows_of_one_list_stay_together() -> None:
    rows = [place(1000 * row, name, 0.0, 0.25 * row, width=0.4, height=0.2) for row, name in ((0, "门锁"), (1, "灯泡"))]
    down = place(9000, "管线", 0.32, 0.125, width=0.2, height=0.4)
    assert len(boards([*rows, down], CONFIG)) == 1


def test_a_text_never_seen_large_enough_is_no_landmark() -> None:
    text_class = carried(0.0)
    text_class.observations = [replace(each, letter_height=12.0) for each in text_class.observations]
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY) == []
    # What would do for Latin letters does not for digits, as which small Chinese is read.
    of_digits = [replace(each, letter_height=17.0, text="80") for each in text_class.observations]
    text_class.observations = [replace(each, letter_height=17.0) for each in text_class.observations]
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY)
    text_class.observations = of_digits
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY) == []


def test_lines_of_a_sign_with_two_sides_are_one_board_whichever_side_showed_them_more() -> None:
    back = (0.0, 0.0, 1.0)
    cashier = place(0, "CASHIER", 0, 0.22, height=0.18, frames=range(20, 33))
    # From the front only the second line could be read; from behind both.
    cashier = replace(
        cashier,
        normals_by_frame={frame: np.array([0.0, 0.0, 1.0 if frame >= 28 else -1.0]) for frame in range(20, 33)},
    )
    chinese = place(1000, "收银台", 0.0, 0.0, height=0.25, frames=range(28, 45), z=3.07, normal=back)
    chinese = replace(chinese, baseline=-chinese.baseline)
    assert names(boards([cashier, chinese], CONFIG)) == [["收银台", "CASHIER"]]
    never_from_behind = place(0, "CASHIER", 0, 0.22, height=0.18, frames=range(20, 28))
    assert names(boards([never_from_behind, chinese], CONFIG)) == [["CASHIER"], ["收银台"]]


def test_a_sign_read_in_one_line_with_its_neighbour_keeps_its_number() -> None:
    seen = observations("MEETING ROOM 2", 0.0, 6) + observations("MEETING ROOM 1", 8.0, 3, first=20)
    slips = ["MEETING ROOM!", "MEETING ROOM E", "MEETING ROOME"]
    joined = ["Enjoy Every Day[MEETING ROOM ]", "Enjoy Every Da MEETING ROOM", "Every Day MEETING ROOM!"]
    for number, text in enumerate(slips + joined):
        seen += observations(text, 8.0, 1, first=30 + number, right=0.3)
    found = places_of_class(text_class(seen, "MEETING ROOM 2"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["MEETING ROOM 2", "MEETING ROOM 1"]


def test_columns_of_a_board_are_joined_and_those_of_two_signs_are_not() -> None:
    """A line that runs downwards is as wide as its letters: what is near is measured by these."""
    first, second = (
        place(0, "药房", 0.0, 0.0, width=0.2, height=0.8),
        place(1000, "营业中", 0.3, 0.0, width=0.2, height=0.8),
    )
    assert len(boards([first, second], CONFIG)) == 1
    neighbour = place(1000, "茶馆", 0.7, 0.0, width=0.2, height=0.8)
    assert len(boards([first, neighbour], CONFIG)) == 2


def test_someone_who_walks_by_twice_is_no_landmark() -> None:
    text_class = carried(1.2, seconds=0.7, count=5)
    again = [replace(each, timestamp=each.timestamp + 60.0, frame=each.frame + 900) for each in text_class.observations]
    text_class.observations += again
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY) == []


@pytest.mark.parametrize("count", [4, 5])
def test_someone_who_is_read_but_twice_a_second_is_no_landmark(count: int) -> None:
    """At a walking pace one reading is three quarters of a metre from the next: they fall into places of one or two."""
    text_class = carried(1.5, seconds=0.5 * (count - 1), count=count)
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY) == []


def test_a_sign_that_someone_walked_by_stands() -> None:
    text_class = carried(0.0)
    walker = carried(1.2, seconds=0.7, count=5)
    text_class.observations += [replace(each, timestamp=each.timestamp + 30.0) for each in walker.observations]
    (found,) = places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY)
    assert found.observations == 12
    assert found.position == pytest.approx([0.0, 0.0, 2.0], abs=0.05)


@pytest.mark.parametrize(
    ("name", "here", "count"),
    [("WOMEN", "MEN", 3), ("EXIT 2", "EXIT", 3), ("GAO", "GAP", 2), ("女洗手间", "男洗手间", 2)],
)
def test_few_readings_that_agree_name_a_door_against_its_neighbour(name: str, here: str, count: int) -> None:
    seen = observations(name, 0.0, 6) + observations(here, 8.0, count)
    found = places_of_class(text_class(seen, name), world, CONFIG, MEMORY)
    assert [each.name for each in found] == [name, here]


def test_unsure_slips_at_one_place_do_not_rename_what_another_place_says() -> None:
    seen = observations("霜口組", 0.0, 10) + observations("數口组", 8.0, 2, right=0.3)
    found = places_of_class(text_class(seen, "霜口組"), world, CONFIG, MEMORY)
    assert [each.name for each in found] == ["霜口組", "霜口組"]


@pytest.mark.parametrize("signs", [2, 3, 4])
def test_equal_signs_in_a_row_stand_though_each_is_read_after_the_other(signs: int) -> None:
    walk = carried(0.0, seconds=0.35 * signs, count=3 * signs)
    walk.observations = [
        replace(each, placement=replace(each.placement, position=(2.0 * (n // 3), 0.0, 2.0 + 0.01 * (n % 3))))
        for n, each in enumerate(walk.observations)
    ]
    assert len(places_of_class(walk, lambda _: np.eye(4), InstanceConfig(), MEMORY)) == signs


def test_a_slogan_and_a_number_in_small_letters_are_lines_of_their_board() -> None:
    lines = [
        place(0, "VELMORA", 0, 0, height=0.4),
        place(1000, "fine quills", 0, 0.35, height=0.12),
        place(2000, "5550 19420", 0, 0.65, height=0.12),
    ]
    assert names(boards(lines, CONFIG)) == [["VELMORA", "fine quills", "5550 19420"]]


def test_an_edge_between_two_texts_makes_two_boards() -> None:
    open_ground, rim = np.array([2.5, 2.5, 2.5, 2.5]), np.array([0.3, 0.3, 0.3, 0.3])
    first, second = place(0, "VELMORA", 0, 0), place(1000, "OSTERBY", 0, 0.4)
    assert len(boards([replace(each, clear=open_ground) for each in (first, second)], CONFIG)) == 1
    assert len(boards([replace(each, clear=rim) for each in (first, second)], CONFIG)) == 2


def test_shops_of_one_wall_stay_apart_though_each_is_near_the_next() -> None:
    grounds = [(200, 40, 40), (40, 160, 60), (230, 220, 60)]
    shops = [
        replace(place(1000 * row, name, 1.1 * row, 0), grounds_by_frame=dict.fromkeys(range(9), grounds[row]))
        for row, name in enumerate(("VELMORA", "OSTERBY", "TANSY"))
    ]
    assert names(boards(shops, CONFIG)) == [["VELMORA"], ["OSTERBY"], ["TANSY"]]


def test_uneven_light_on_one_board_does_not_split_it() -> None:
    bright, dim = dict.fromkeys(range(9), (205, 30, 37)), dict.fromkeys(range(9), (87, 13, 16))
    lines = [
        replace(place(0, "VELMORA", 0, 0), grounds_by_frame=bright),
        replace(place(1000, "fine quills", 0, 0.22), grounds_by_frame=dim),
    ]
    assert len(boards(lines, CONFIG)) == 1


def test_entries_side_by_side_are_no_name() -> None:
    entries = [place(1000 * row, name, 0.6 * row, 0, width=0.38) for row, name in enumerate(("米湯", "梅餅", "竹茶"))]
    (menu,) = boards(entries, CONFIG)
    named, lines = lines_of(menu)
    assert [(line.text, line.role) for line in lines] == [("米湯", "list"), ("梅餅", "list"), ("竹茶", "list")]
    assert named.text == "米湯"


def test_frames_that_saw_the_end_of_a_text_do_not_tell_where_its_middle_is() -> None:
    left, right = (
        place(0, "LONG FASCIA", 0, 0, width=1.6),
        place(1000, "NEXT", 1.8, 0, width=0.8, frames=range(8, 10)),
    )
    ends = {frame: left.positions_by_frame[frame] + np.array([0.5, 0.0, 0.0]) for frame in (8, 9)}
    sizes = {frame: (0.6 if frame in ends else 1.6, 0.2) for frame in left.positions_by_frame}
    cut = replace(left, positions_by_frame=left.positions_by_frame | ends, sizes_by_frame=sizes)
    assert names(boards([cut, right], CONFIG)) == [["LONG FASCIA"], ["NEXT"]]


def test_an_entry_of_a_list_beside_a_name_is_no_word_of_it() -> None:
    entries = [
        place(1000 * row, text, 0.0, 0.12 * row, width=0.4, height=0.15)
        for row, text in enumerate(("Tea", "Bread", "Cake"))
    ]
    name = place(9000, "Ada's Kitchen", -0.95, 0.12, width=1.4, height=0.19)
    assert [line.text for line in lines_of([name, *entries])[1]] == ["Tea", "Ada's Kitchen", "Bread", "Cake"]
    # Without a list it is one, however much smaller it is written.
    assert [line.text for line in lines_of([name, entries[1]])[1]] == ["Ada's Kitchen Bread"]


def test_a_text_that_comes_into_view_bit_by_bit_is_not_carried() -> None:
    """Its middle moves with what is in view, and its begin stays where it is."""
    text_class = TextClass(0, 0.0, 1.0)
    for at in range(8):
        width = 0.8 + 0.12 * at
        text = "Pebble & Fox"[: round(12 * width / 1.64)]
        placement = Placement((width / 2.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), width, 0.25, 0.01)
        text_class.observations.append(TextObservation(at, 0.1 * at, 0, text, 0.9, placement, 44.0))
        text_class.variants[text] = Variant(1, 0.9)
    assert places_of_class(text_class, lambda _: np.eye(4), InstanceConfig(), MEMORY)


@pytest.mark.parametrize("lean", [0.0, 8.0, 15.0])
def test_words_of_an_arc_that_lean_apart_are_one_line(lean: float) -> None:
    """Each has a box of its own; the larger one's direction leads past the other."""
    cos, sin = np.cos(np.radians(lean)), np.sin(np.radians(lean))
    first = replace(place(0, "Vornal", 0.0, 0.0, width=1.1), baseline=np.array([cos, -sin, 0.0]))
    second = replace(place(1000, "Sarter", 1.15, 0.0), baseline=np.array([cos, sin, 0.0]))
    slogan = place(2000, "fine quills", 0.6, 0.35, height=0.1)
    named, lines = lines_of([first, second, slogan])
    assert named.text == "Vornal Sarter"
    assert [line.text for line in lines] == ["Vornal Sarter", "fine quills"]


def test_a_word_that_leans_past_its_neighbour_is_no_word_of_its_line() -> None:
    first = place(0, "Vornal", 0.0, 0.0, width=1.1)
    second = replace(place(1000, "Sarter", 1.15, 0.22), baseline=np.array([0.94, -0.34, 0.0]))
    assert {line.text for line in lines_of([first, second])[1]} == {"Vornal", "Sarter"}


def test_a_price_in_a_column_of_its_own_is_in_one_line_with_its_goods() -> None:
    menu = [place(0, "BRAMBLE TEA", 0.0, 0.0), place(1000, "2.50", 1.6, 0.01, width=0.3)]
    menu += [place(2000, "桑茶", 0.0, 0.35, width=0.4), place(3000, "3元", 1.6, 0.36, width=0.3)]
    assert names([menu]) == [["BRAMBLE TEA 2.50", "桑茶 3元"]]
    beside = [place(0, "BRAMBLE TEA", 0.0, 0.0), place(1000, "VELMORA", 1.9, 0.0)]
    assert names([beside]) == [["BRAMBLE TEA", "VELMORA"]], "what is no price stays apart"
    larger = [place(0, "BRAMBLE", 0.0, 0.0, height=0.4), place(1000, "2.50", 1.6, 0.01, width=0.3)]
    assert names([larger]) == [["BRAMBLE", "2.50"]], "as does a price in other letters"


@pytest.mark.parametrize(("sideways", "stands"), [(0.0, 1), (1.5, 2)])
def test_a_text_on_glass_does_not_stand_behind_it(sideways: float, stands: int) -> None:
    """Depth through the pane puts some sightings a metre behind it; a second sign there is seen beside the first."""

    def seen(first: int, count: int, x: float, z: float) -> list[TextObservation]:
        origin = (0.0, 0.0, 0.0)
        on = Placement((x, 0.0, z), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.6, 0.2, 0.01)
        bearing, frames = Bearing(origin, (origin,) * 4), range(first, first + count)
        return [TextObservation(each, 0.1 * each, 0, "OPEN", 0.9, on, 30.0, bearing=bearing) for each in frames]

    both = seen(0, 10, 0.1, 2.0) + seen(20, 3, 0.15 + sideways, 3.2)
    found = places_of_class(text_class(both, "OPEN"), world, CONFIG, MEMORY)
    assert len(found) == stands
    assert found[0].position[2] == pytest.approx(2.0)


def test_a_line_is_said_to_be_as_sure_as_such_lines_are_right() -> None:
    """Of lines that their readings hold for all but certain some are wrong, and of doubted ones most are right."""
    stated = [as_measured(sure) for sure in (0.0, 0.1, 0.35, 0.6, 0.9, 0.988, 1.0)]
    assert stated == sorted(stated)
    assert stated[0] < 0.001
    assert stated[2] > 0.45
    assert 0.8 < stated[4] < 0.9
    assert 0.95 < stated[5] < 0.975
    assert stated[6] <= 1.0
    named, lines = lines_of([replace(place(0, "HARNOW", 0, 0), confidence=0.988)])
    assert named.confidence == lines[0].confidence == stated[5]
