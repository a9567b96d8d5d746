"""How a text is seen: legibility, and the ground it stands on."""

import cv2
import numpy as np
import pytest

from lpslam.text.boards.surroundings import surroundings
from lpslam.text.reading.legibility import SeenSize, frontal_cosine, ground_difference
from lpslam.text.types import Placement

BOX = np.array([[20.0, 20.0], [180.0, 20.0], [180.0, 60.0], [20.0, 60.0]])


def board(ground: tuple[int, int, int], ink: tuple[int, int, int]) -> np.ndarray:
    image = np.full((100, 200, 3), 90, np.uint8)
    image[5:75, 5:195] = ground
    cv2.putText(image, "OUTLET", (22, 55), cv2.FONT_HERSHEY_DUPLEX, 1.3, ink, 3)
    return image


@pytest.mark.parametrize("ground", [(200, 30, 30), (20, 20, 20), (240, 240, 230), (40, 60, 170)])
@pytest.mark.parametrize("ink", [(255, 255, 255), (0, 0, 0), (250, 210, 40)])
def test_the_ground_is_found_whatever_the_ink(ground: tuple[int, int, int], ink: tuple[int, int, int]) -> None:
    assert ground_difference(surroundings(board(ground, ink), BOX).ground, ground) < 0.1


def test_a_dimmer_board_keeps_apart_from_another_colour() -> None:
    red, dimmer, purple = (200, 40, 40), (185, 36, 37), (150, 40, 160)
    assert ground_difference(red, dimmer) < 0.1 < 0.3 < ground_difference(red, purple)
    assert ground_difference((3, 1, 0), (0, 2, 4)) < 0.15, "in the dark, colours are noise"


def test_larger_and_more_frontal_is_seen_better() -> None:
    assert SeenSize(70.0, 1.0).effective > 2.0 * SeenSize(28.0, 1.0).effective
    assert SeenSize(24.0, 0.6).effective < SeenSize(24.0, 1.0).effective
    assert SeenSize(24.0, -1.0).effective == 0.0


def test_frontal_is_where_the_normal_points() -> None:
    sign = Placement((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 0.5, 0.1, 0.01)
    assert frontal_cosine(sign, np.eye(4)) == pytest.approx(1.0)
    aside = np.eye(4)
    aside[0, 3] = 2.0
    assert frontal_cosine(sign, aside) == pytest.approx(np.sqrt(0.5))
