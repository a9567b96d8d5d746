"""How far a ground goes on around a text."""

import cv2
import numpy as np
import pytest

from lpslam.text.boards.surroundings import REACH, surroundings

BOX = np.array([[195.0, 140.0], [340.0, 140.0], [340.0, 190.0], [195.0, 190.0]])


def test_a_ground_goes_on_between_letters_and_ends_at_a_frame() -> None:
    image = np.full((480, 640, 3), (200, 190, 180), np.uint8)
    cv2.rectangle(image, (100, 100), (500, 300), (60, 30, 30), -1)
    cv2.putText(image, "VELMO", (200, 180), 0, 1.5, (240, 240, 240), 4)
    cv2.putText(image, "quills", (200, 215), 0, 0.8, (240, 240, 240), 2)
    around = surroundings(image, BOX)
    assert around.ground == (60, 30, 30)
    assert min(around.ink) > 200
    # The board's rim is 40 px above, 95 px left and 110 px below; a letter's height is 50 px.
    assert around.clear == pytest.approx((0.8, REACH, 2.2, 1.9), abs=0.1)
    cv2.line(image, (100, 205), (500, 205), (240, 240, 240), 2)
    assert surroundings(image, BOX).clear[2] == pytest.approx(0.3, abs=0.1)


def test_on_a_slanted_surface_the_ground_is_measured_in_letters_of_that_surface() -> None:
    image = np.full((480, 640, 3), (200, 190, 180), np.uint8)
    cv2.rectangle(image, (145, 100), (390, 240), (60, 30, 30), -1)
    cv2.putText(image, "VELMO", (200, 180), 0, 1.5, (240, 240, 240), 4)
    assert surroundings(image, BOX).clear == pytest.approx((0.8, 1.0, 1.0, 1.0), abs=0.1)
    # A table that lies half away from the camera: what is 50 pixels high is as large as what is 100 wide.
    assert surroundings(image, BOX, (1.45, 1.0)).clear == pytest.approx((0.8, 0.5, 1.0, 0.5), abs=0.1)


def test_the_bare_ground_is_that_between_the_letters_and_not_another_sheet_that_the_box_takes_in() -> None:
    image = np.full((480, 640, 3), (75, 65, 70), np.uint8)
    cv2.putText(image, "VELMO", (200, 166), 0, 1.2, (240, 240, 240), 3)
    for top in (100, 170):
        cv2.rectangle(image, (100, top), (500, top + 39), (110, 80, 110), -1)
    around = surroundings(image, BOX)
    assert (around.ground, around.bare) == ((110, 80, 110), (75, 65, 70))
