from dataclasses import replace
from typing import Any

import pytest

from lpslam.camera import PinholeCamera
from lpslam.config import CameraMatchConfig
from lpslam.errors import UserError
from lpslam.mapfile.compatibility import refuse_other_camera

OURS = PinholeCamera(640, 480, 585.0, 586.0, 320.0, 240.0)
LENS = (0.2312, -0.7849, -0.0033, -0.0001, 0.9172)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"fx": 590.0, "fy": 581.0},
        {"cx": 326.0, "cy": 234.0},
        {"depth_scale": 5000.0, "fps": 15.0},
        {"distortion": (0.01, -0.01, 0.0, 0.0, 0.0)},
    ],
)
def test_another_calibration_of_the_same_camera_is_accepted(changes: dict[str, Any]) -> None:
    refuse_other_camera(OURS, replace(OURS, **changes), "hall.lpmap")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"width": 1280, "height": 720}, "its images are 640×480, the recording's 1280×720"),
        ({"fx": 592.0}, "its fx is 585, the recording's 592"),
        ({"fy": 579.0}, "its fy is 586, the recording's 579"),
        ({"cx": 329.0}, "its cx is 320, the recording's 329"),
        ({"cy": 225.0}, "its cy is 240, the recording's 225"),
        ({"distortion": LENS}, "its distortion moves pixels "),
    ],
)
def test_another_camera_is_refused_in_one_line_with_both_values(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(UserError) as refusal:
        refuse_other_camera(OURS, replace(OURS, **changes), "hall.lpmap")
    message = str(refusal.value)
    assert message.startswith(f"hall.lpmap was made with another camera: {said}")
    assert "\n" not in message
    # The same both ways.
    with pytest.raises(UserError):
        refuse_other_camera(replace(OURS, **changes), OURS, "hall.lpmap")


def test_a_lens_is_compared_by_what_it_does_and_not_by_its_coefficients() -> None:
    """Higher terms may trade places: these two differ in every coefficient and by less than a pixel."""
    camera = replace(OURS, distortion=(0.1, -0.2, 0.0, 0.0, 0.0))
    refuse_other_camera(camera, replace(OURS, distortion=(0.103, -0.214, 0.0005, 0.0, 0.02)), "hall.lpmap")


def test_the_tolerances_are_those_of_the_configuration() -> None:
    with pytest.raises(UserError, match="fx is 585"):
        refuse_other_camera(OURS, replace(OURS, fx=586.0), "hall.lpmap", CameraMatchConfig(focal_share=0.001))
