import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.text.reading.borders import cut_by_border, room_beyond, view_of

WHITE, BLACK, BLUE = (235, 235, 235), (25, 25, 25), (40, 60, 150)
HEIGHT, WIDTH = 240, 320


def seen(
    text: str, left: int, top: int, scale: float = 1.2, ink: tuple[int, ...] = BLACK, ground: tuple[int, ...] = WHITE
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A window on a wall with a text painted on it, whose letters begin at (left, top), and its box as detected."""
    (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 3)
    wall = np.full((HEIGHT + 400, WIDTH + 1200, 3), ground, np.uint8)
    cv2.putText(wall, text, (left + 600, top + 200 + height), cv2.FONT_HERSHEY_SIMPLEX, scale, ink, 3, cv2.LINE_AA)
    grown = 0.25 * height
    box = np.array([[left, top], [left + width, top], [left + width, top + height], [left, top + height]], float)
    box += np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * grown
    window = wall[200 : 200 + HEIGHT, 600 : 600 + WIDTH]
    return np.ascontiguousarray(window), np.clip(box, 0.0, [WIDTH - 1.0, HEIGHT - 1.0])


@pytest.mark.parametrize("colours", [(BLACK, WHITE), (WHITE, BLACK), (BLUE, BLACK), (WHITE, BLUE)])
@pytest.mark.parametrize(("left", "top"), [(20, 100), (20, 6), (100, 6), (100, 203), (150, 100)])
def test_a_whole_text_in_the_margin_is_kept(
    left: int, top: int, colours: tuple[tuple[int, ...], tuple[int, ...]]
) -> None:
    image, box = seen("COFFEE", left, top, ink=colours[0], ground=colours[1])
    assert cut_by_border(image, box[None]).tolist() == [False]


@pytest.mark.parametrize(
    ("text", "left", "top"),
    [
        ("COFFEE", -30, 100),
        ("COFFEE", -23, 100),
        ("COFFEE", 200, 100),
        ("STARBUCKS", 220, 100),
        ("COFFEE", 100, -10),
        ("COFFEE", 100, 222),
    ],
)
def test_a_text_that_goes_on_outside_is_cut(text: str, left: int, top: int) -> None:
    image, box = seen(text, left, top)
    assert cut_by_border(image, box[None]).tolist() == [True]


def test_the_first_word_of_two_is_cut_where_the_next_would_begin_outside() -> None:
    (width, _), _ = cv2.getTextSize("GRAND", cv2.FONT_HERSHEY_SIMPLEX, 1.2, 3)
    image, box = seen("GRAND", WIDTH - width - 2, 100)
    assert cut_by_border(image, box[None]).tolist() == [True]


def test_a_text_with_room_around_it_is_not_looked_at() -> None:
    blank = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
    box = np.array([[100, 100], [200, 100], [200, 130], [100, 130]], float)
    assert cut_by_border(blank, box[None]).tolist() == [False]
    assert cut_by_border(blank, np.zeros((0, 4, 2))).shape == (0,)


def test_a_line_that_runs_downwards_is_cut_at_its_foot_and_not_beside() -> None:
    image, box = seen("COFFEE", 40, 100)
    turned, corners = np.rot90(image, -1), np.column_stack([HEIGHT - 1 - box[:, 1], box[:, 0]])
    # Turned clockwise, the line runs downwards; its box begins at the upper left corner all the same.
    assert cut_by_border(np.ascontiguousarray(turned), np.roll(corners, 1, axis=0)[None]).tolist() == [False]
    image, box = seen("COFFEE", 200, 100)
    turned, corners = np.rot90(image, -1), np.column_stack([HEIGHT - 1 - box[:, 1], box[:, 0]])
    assert cut_by_border(np.ascontiguousarray(turned), np.roll(corners, 1, axis=0)[None]).tolist() == [True]


def test_what_stands_above_the_letters_does_not_cut_them() -> None:
    image, box = seen("think", 100, 14, ink=WHITE, ground=BLACK)
    cv2.ellipse(image, (145, 60), (120, 57), 0, 180, 360, WHITE, 2)
    assert cut_by_border(image, box[None]).tolist() == [False]


@pytest.mark.parametrize("degrees", [18, 25])
@pytest.mark.parametrize("kept", [4, 5])
def test_a_slanted_text_of_which_the_foot_of_a_letter_is_left_is_cut(degrees: float, kept: int) -> None:
    word, scale = "MEETING", 1.6
    (width, height), _ = cv2.getTextSize(word, cv2.FONT_HERSHEY_SIMPLEX, scale, 4)
    (whole, _), _ = cv2.getTextSize(word[-kept:], cv2.FONT_HERSHEY_SIMPLEX, scale, 4)
    wall = np.full((700, 1200, 3), BLUE, np.uint8)
    cv2.putText(wall, word, (600 - width, 350), cv2.FONT_HERSHEY_SIMPLEX, scale, WHITE, 4, cv2.LINE_AA)
    # The letters left out are those of which less than half is in view, at the top of the image.
    turn = cv2.getRotationMatrix2D((600.0, 350.0), -degrees, 1.0)
    middle = turn @ np.array([600.0 - whole - 0.35 * height, 350.0 - 0.45 * height, 1.0])
    turn[:, 2] += np.array([40.0, 0.0]) - middle
    window = cv2.warpAffine(wall, turn, (WIDTH + 200, HEIGHT), borderValue=BLUE)
    corners = np.array([[600 - whole, 350 - height], [600, 350 - height], [600, 350], [600 - whole, 350]], float)
    corners += np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * 0.2 * height
    box = corners @ turn[:, :2].T + turn[:, 2]
    box = np.clip(box, 0.0, [WIDTH + 199.0, HEIGHT - 1.0])
    assert cut_by_border(window, box[None]).tolist() == [True]


@pytest.mark.parametrize("level", [255, 0])
def test_a_blank_frame_around_the_image_is_no_ground(level: int) -> None:
    image, box = seen("COFFEE", -20, 100, ground=(200, 190, 180))
    # Rectified as recordings are, the same picture stands in a frame of blank pixels.
    framed = cv2.copyMakeBorder(image, 8, 8, 9, 9, cv2.BORDER_CONSTANT, value=(level, level, level))
    assert [each.tolist() for each in view_of(image)] == [[0, 0], [WIDTH - 1, HEIGHT - 1]]
    assert [each.tolist() for each in view_of(np.asarray(framed, np.uint8))] == [[10, 9], [WIDTH + 7, HEIGHT + 6]]
    assert cut_by_border(np.asarray(framed, np.uint8), box[None] + (9.0, 8.0)).tolist() == [True]


def test_a_blank_wall_at_one_side_is_no_frame() -> None:
    image, _ = seen("COFFEE", 100, 100, ground=(200, 190, 180))
    image[:12] = 255
    assert [each.tolist() for each in view_of(image)] == [[0, 0], [WIDTH - 1, HEIGHT - 1]]


def test_how_far_the_image_goes_on_beyond_the_ends_of_a_text() -> None:
    image, box = seen("ABC", 20, 100)
    height, left, right = box[3, 1] - box[0, 1], box[0, 0], WIDTH - 1.0 - box[1, 0]
    assert room_beyond(image, box) == pytest.approx((left / height, right / height))
    image, box = seen("LONGER", 230, 100)
    assert room_beyond(image, box)[1] == 0.0
    slanted = np.array([[60.0, 40.0], [160.0, 140.0], [140.0, 160.0], [40.0, 60.0]])
    assert room_beyond(image, slanted) == pytest.approx((2.25, (HEIGHT - 1.0 - 155.0) / 20.0), rel=0.01)


def test_what_hides_the_image_beyond_an_end_ends_the_view() -> None:
    image, box = seen("ABC", 120, 100)
    height, begin = box[3, 1] - box[0, 1], box[0, 0]
    hidden = np.zeros(image.shape[:2], np.bool_)
    hidden[:, : int(begin - 0.5 * height)] = True
    before, behind = room_beyond(image, box, hidden)
    assert before == pytest.approx(0.5, abs=2.0 / height)
    assert behind == room_beyond(image, box)[1]
    hidden[:, : int(begin) + 2] = True
    assert room_beyond(image, box, hidden)[0] == 0.0
    hidden[int(box[0, 1]) + 8 :] = False
    assert room_beyond(image, box, hidden)[0] == room_beyond(image, box)[0], "it is above the line"


def test_a_piece_of_a_column_that_is_as_wide_as_high_is_cut_at_its_head() -> None:
    """Of the upper of two blocks half is above the border: the box is about square."""
    image = np.full((HEIGHT, WIDTH, 3), WHITE, np.uint8)
    for top in (-30, 30):
        for row in range(0, 50, 12):
            cv2.line(image, (100, top + row), (148, top + row), BLACK, 4)
        cv2.line(image, (124, top), (124, top + 48), BLACK, 4)
    box = np.array([[95, 0], [153, 0], [153, 84], [95, 84]], float)
    assert cut_by_border(image, box[None]).tolist() == [True]
    assert room_beyond(image, box, either_way=True)[0] == 0.0
    lower = np.roll(image, 60, axis=0)
    lower[:60] = WHITE
    moved = np.array([[95, 60], [153, 60], [153, 144], [95, 144]], float)
    assert cut_by_border(lower, moved[None]).tolist() == [False]
    assert min(room_beyond(lower, moved, either_way=True)) > 0.5
