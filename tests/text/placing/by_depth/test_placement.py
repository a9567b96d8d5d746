import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, transform_points
from lpslam.config import PlacementConfig
from lpslam.text.placing.by_depth.hiding import PlacementFault, hidden_pixels
from lpslam.text.placing.by_depth.placement import place_text
from lpslam.text.types import Placement

CAMERA = PinholeCamera(640, 480, 570.0, 570.0, 321.0, 238.0)
CONFIG = PlacementConfig()
Array = NDArray[np.float64]


def turned(degrees: float) -> Array:
    angle = np.radians(degrees)
    return np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])


def sign(centre: Array, yaw: float, width: float = 0.6, height: float = 0.15) -> tuple[Array, Array, Array]:
    """A sign's corners in space and image, and its normal."""
    rotation = turned(yaw)
    local = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * [width / 2, height / 2, 0]
    corners = centre + local @ rotation.T
    return corners, CAMERA.project(corners), -rotation[:, 2]


def wall_depth(centre: Array, normal: Array, noise: float = 0.0, seed: int = 0) -> NDArray[np.float32]:
    columns, rows = np.meshgrid(np.arange(640.0), np.arange(480.0))
    rays = np.stack([(columns - CAMERA.cx) / CAMERA.fx, (rows - CAMERA.cy) / CAMERA.fy, np.ones_like(rows)], axis=-1)
    depth = (centre @ normal) / (rays @ normal)
    depth[(depth < 0.3) | (depth > 8.0)] = 0.0
    error = np.random.default_rng(seed).normal(size=depth.shape) * (0.0007 + noise * depth**2) * (noise > 0)
    return np.where(depth > 0, depth + error, 0.0).astype(np.float32)


def placed(box: Array, depth: NDArray[np.float32], pose: Array | None = None) -> Placement:
    result = place_text(box, depth, CAMERA, np.eye(4) if pose is None else pose, CONFIG)
    assert isinstance(result, Placement)
    return result


@pytest.mark.parametrize("yaw", [-60.0, -30.0, 0.0, 45.0])
def test_a_sign_on_a_wall_is_placed_exactly(yaw: float) -> None:
    centre = np.array([0.2, -0.3, 2.5])
    _, box, normal = sign(centre, yaw)
    placement = placed(box, wall_depth(centre, normal))
    assert placement.position == pytest.approx(centre, abs=1e-3)
    assert placement.normal == pytest.approx(normal, abs=1e-3)
    assert placement.baseline == pytest.approx(turned(yaw)[:, 0], abs=1e-3)
    assert (placement.width, placement.height) == pytest.approx((0.6, 0.15), abs=2e-3)


def test_sensor_noise_is_averaged_out() -> None:
    centre = np.array([-0.4, -0.5, 4.0])
    _, box, normal = sign(centre, 35.0)
    errors = [
        np.linalg.norm(placed(box, wall_depth(centre, normal, 0.0022, seed)).position - centre) for seed in range(10)
    ]
    # One pixel's depth is 36 mm off here.
    assert max(errors) < 0.015


def test_an_occluder_and_holes_do_not_move_it() -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 20.0)
    depth = wall_depth(centre, normal, 0.0022)
    left, right = box[:, 0].min(), box[:, 0].max()
    depth[:, int(left) : int(left + 0.35 * (right - left))] = 1.2
    depth[::3] = 0.0
    depth[1::7] = np.nan
    assert placed(box, depth).position == pytest.approx(centre, abs=0.02)


def test_it_hangs_on_the_keyframe() -> None:
    centre = np.array([0.1, -0.2, 2.0])
    _, box, normal = sign(centre, -25.0)
    keyframe_from_camera = np.eye(4)
    keyframe_from_camera[:3, :3], keyframe_from_camera[:3, 3] = turned(40.0), [1.0, -0.5, 2.0]
    placement = placed(box, wall_depth(centre, normal), keyframe_from_camera)
    assert placement.position == pytest.approx(transform_points(keyframe_from_camera, centre[None])[0], abs=1e-3)
    assert placement.normal == pytest.approx(turned(40.0) @ normal, abs=1e-3)


def test_raw_pixels_of_a_distorting_lens_are_straightened() -> None:
    import cv2

    coefficients = (0.26, -0.95, -0.005, 0.003, 1.16)
    camera = PinholeCamera(640, 480, 517.3, 516.5, 318.6, 255.3, distortion=coefficients)
    local = np.array([[-0.3, -0.1, 0], [0.3, -0.1, 0], [0.3, 0.1, 0], [-0.3, 0.1, 0]])
    centre = np.array([1.0, -0.6, 2.5])
    raw = cv2.projectPoints(centre + local, np.zeros(3), np.zeros(3), camera.matrix, np.array(coefficients))[0][:, 0]
    depth = np.full((480, 640), 2.5, np.float32)
    placement = place_text(raw, depth, camera, np.eye(4), CONFIG)
    assert isinstance(placement, Placement)
    assert placement.position == pytest.approx(centre, abs=2e-3)


def test_a_ragged_surface_falls_back_to_the_median() -> None:
    _, box, _ = sign(np.array([0.0, 0.0, 3.0]), 0.0)
    depth = np.random.default_rng(0).uniform(2.0, 4.0, (480, 640)).astype(np.float32)
    placement = placed(box, depth)
    assert placement.position[2] == pytest.approx(3.0, abs=0.15)
    assert placement.normal == pytest.approx((0, 0, -1), abs=0.01)
    assert placement.uncertainty > placed(box, np.full((480, 640), 3.0, np.float32)).uncertainty


@pytest.mark.parametrize("value", [0.0, np.nan, 60.0])
def test_no_usable_depth_is_a_fault(value: float) -> None:
    _, box, _ = sign(np.array([0.0, 0.0, 3.0]), 0.0)
    depth = np.full((480, 640), value, np.float32)
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG) is PlacementFault.NO_DEPTH


def test_a_grazing_surface_is_a_fault() -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 84.0, width=1.0)
    assert place_text(box, wall_depth(centre, normal), CAMERA, np.eye(4), CONFIG) is PlacementFault.GRAZING


@pytest.mark.parametrize("yaw", [0.0, 40.0, -40.0])
@pytest.mark.parametrize("side", ["left", "right"])
def test_a_text_that_goes_on_behind_a_pillar_is_refused(yaw: float, side: str) -> None:
    centre = np.array([0.0, 0.0, 4.0])
    _, box, normal = sign(centre, yaw)
    depth = wall_depth(centre, normal, 0.0022)
    if side == "left":
        depth[:, : int(box[:, 0].min()) - 2] = 2.5
    else:
        depth[:, int(box[:, 0].max()) + 2 :] = 2.5
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG) is PlacementFault.HIDDEN


def test_what_lies_behind_or_hardly_before_a_sign_does_not_hide_it() -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 0.0)
    left, right = int(box[:, 0].min()) - 2, int(box[:, 0].max()) + 2
    for beyond in (5.0, 2.95, 0.0):
        depth = wall_depth(centre, normal, 0.0022)
        depth[:, :left] = depth[:, right:] = beyond
        assert placed(box, depth).position == pytest.approx(centre, abs=0.01)


def test_a_thin_sign_a_hand_before_the_wall_hides_what_is_behind_it() -> None:
    centre = np.array([0.0, 0.0, 5.5])
    _, box, normal = sign(centre, 0.0)
    depth = wall_depth(centre, normal, 0.0022)
    depth[:, int(box[:, 0].max()) + 2 :] -= 0.25
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG) is PlacementFault.HIDDEN


@pytest.mark.parametrize("is_hidden", [False, True])
def test_a_text_that_is_seen_to_end_before_something_nearer_is_not_hidden(is_hidden: bool) -> None:
    """A board between two pillars: ground is seen beyond the last letter, or it is not."""
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 0.0)
    left, top = (int(each) for each in box.min(axis=0))
    rgb = np.full((480, 640, 3), 40, np.uint8)
    last = int(box[:, 0].max())
    for column in range(left + 8, last - 12, 9):
        rgb[top + 6 : int(box[:, 1].max()) - 5, column : column + 6] = 230
    depth = wall_depth(centre, normal, 0.0022)
    depth[:, last + 2 :] = 2.5
    rgb[:, last + 2 :] = 40
    if is_hidden:
        rgb[top + 6 : int(box[:, 1].max()) - 5, last - 8 : last + 2] = 230
    result = place_text(box, depth, CAMERA, np.eye(4), CONFIG, rgb=rgb)
    assert (result is PlacementFault.HIDDEN) is is_hidden
    part = place_text(box, depth, CAMERA, np.eye(4), CONFIG, rgb=rgb, is_cut=True)
    assert isinstance(part, Placement)


@pytest.mark.parametrize("step", [-0.4, 0.4])
def test_two_signs_that_look_like_one_line_are_no_text(step: float) -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 0.0, width=1.0)
    depth = wall_depth(centre, normal, 0.0022)
    first = int(box[:, 0].min() + 0.35 * np.ptp(box[:, 0]))
    depth[:, :first] += step
    assert isinstance(place_text(box, depth, CAMERA, np.eye(4), CONFIG), PlacementFault)


def test_a_box_that_reaches_over_the_edge_of_its_board_is_placed_on_the_board() -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 0.0, width=1.0)
    depth = wall_depth(centre, normal, 0.0022)
    depth[:, : int(box[:, 0].min() + 0.05 * np.ptp(box[:, 0]))] += 0.4
    assert placed(box, depth).position == pytest.approx(centre, abs=0.02)


def test_a_glossy_sign_hangs_on_the_wall_around_it() -> None:
    centre = np.array([0.2, -0.3, 3.0])
    _, box, normal = sign(centre, 25.0)
    depth = wall_depth(centre, normal, 0.0022)
    (left, top), (right, bottom) = box.min(axis=0).astype(int), box.max(axis=0).astype(int)
    depth[top : bottom + 1, left : right + 1] = 0.0
    placement = placed(box, depth)
    assert placement.position == pytest.approx(centre, abs=0.02)
    assert placement.normal == pytest.approx(normal, abs=0.05)


def test_where_depth_fails_the_maps_points_say_where_a_sign_hangs() -> None:
    centre = np.array([0.2, -0.3, 3.0])
    _, box, normal = sign(centre, 25.0)
    local = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 3)) * [0.7, 0.5, 0.0]
    on_wall, strays = centre + local @ turned(25.0).T, centre + np.array([[0.1, 0.2, 1.0], [0.0, 0.2, -1.0]])
    none = np.zeros((480, 640), np.float32)

    def points() -> Array:
        return np.vstack([on_wall, strays])

    placement = place_text(box, none, CAMERA, np.eye(4), CONFIG, points)
    assert isinstance(placement, Placement)
    assert placement.position == pytest.approx(centre, abs=0.02)
    assert placement.normal == pytest.approx(normal, abs=0.05)
    assert place_text(box, none, CAMERA, np.eye(4), CONFIG, lambda: on_wall[:4]) is PlacementFault.NO_DEPTH


def test_points_scattered_in_space_are_no_surface() -> None:
    _, box, _ = sign(np.array([0.0, 0.0, 3.0]), 0.0)
    scattered = np.random.default_rng(1).uniform([-1.0, -1.0, 1.5], [1.0, 1.0, 6.0], (60, 3))
    none = np.zeros((480, 640), np.float32)
    assert place_text(box, none, CAMERA, np.eye(4), CONFIG, lambda: scattered) is PlacementFault.NO_DEPTH


def test_a_vertical_line_before_a_nearer_wall_is_not_hidden_and_one_cut_off_below_is() -> None:
    """A blade sign across the wall: what lies left of its letters is nearer, and hides none of them."""
    centre = np.array([0.0, 0.0, 4.0])
    _, box, normal = sign(centre, 0.0, width=0.15, height=0.8)
    depth = wall_depth(centre, normal, 0.0022)
    depth[:, : int(box[:, 0].min()) - 2] = 2.5
    assert placed(box, depth).position == pytest.approx(centre, abs=0.01)
    depth = wall_depth(centre, normal, 0.0022)
    depth[int(box[:, 1].max()) + 2 :] = 2.5
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG) is PlacementFault.HIDDEN


@pytest.mark.parametrize(("side", "fault"), [("left", PlacementFault.HIDDEN), ("above", PlacementFault.NO_DEPTH)])
def test_a_sign_beyond_the_sensors_reach_does_not_hang_on_what_is_beside_it(side: str, fault: PlacementFault) -> None:
    """What begins where the text does may hide its first letters."""
    _, box, _ = sign(np.array([0.0, 0.0, 7.0]), 0.0, width=1.2, height=0.3)
    depth = np.zeros((480, 640), np.float32)
    if side == "left":
        depth[:, : int(box[:, 0].min())] = 3.0
    else:
        depth[: int(box[:, 1].min())] = 3.0
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG) is fault


@pytest.mark.parametrize(("gap", "fault"), [(14, PlacementFault.NO_DEPTH), (1, PlacementFault.HIDDEN)])
def test_a_sign_beyond_the_sensors_reach_that_ends_before_a_pillar_is_not_hidden(
    gap: int, fault: PlacementFault
) -> None:
    """Ground is seen between the pillar and the first letter, or it is not."""
    _, box, _ = sign(np.array([0.0, 0.0, 7.0]), 0.0, width=1.2, height=0.3)
    (left, top), (right, bottom) = box.min(axis=0).astype(int), box.max(axis=0).astype(int)
    rgb = np.full((480, 640, 3), 40, np.uint8)
    for column in range(left + gap, right - 8, 9):
        rgb[top + 4 : bottom - 3, column : column + 6] = 230
    depth = np.zeros((480, 640), np.float32)
    depth[:, :left] = 3.0
    assert place_text(box, depth, CAMERA, np.eye(4), CONFIG, rgb=rgb) is fault


def test_a_black_sign_with_a_shadow_at_one_end_is_not_hidden() -> None:
    """The wall at the other end is no nearer than that above and below."""
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 0.0, width=0.8, height=0.2)
    depth = wall_depth(centre, normal, 0.0022)
    left, top = np.floor(box.min(axis=0)).astype(int)
    right, bottom = np.ceil(box.max(axis=0)).astype(int)
    depth[top : bottom + 1, left - 12 : right + 1] = 0.0
    assert placed(box, depth).position == pytest.approx(centre, abs=0.03)


def test_a_sign_without_depth_does_not_hang_between_a_pillar_and_the_wall_behind_it() -> None:
    _, box, _ = sign(np.array([0.0, 0.0, 7.0]), 0.0, width=1.6, height=0.4)
    none, random = np.zeros((480, 640), np.float32), np.random.default_rng(2)

    def points(depth: float, left: float, right: float) -> np.ndarray:
        """In view left and right of the middle by so many pixels, above and below the text."""
        rows = np.concatenate([random.uniform(-40, -25, 12), random.uniform(25, 40, 12)])
        pixels = np.column_stack([random.uniform(left, right, 24) + CAMERA.cx, rows + CAMERA.cy])
        return np.asarray(CAMERA.back_project(pixels, np.full(24, depth)))

    half = float(np.ptp(box[:, 0])) / 2.0
    ends = np.vstack([points(3.0, -half - 15, -half), points(7.0, half, half + 15)])
    assert place_text(box, none, CAMERA, np.eye(4), CONFIG, lambda: ends) is PlacementFault.NO_DEPTH
    wall = np.vstack([points(7.0, -half - 15, 0.0), points(7.0, 0.0, half + 15)])
    there = place_text(box, none, CAMERA, np.eye(4), CONFIG, lambda: wall)
    assert isinstance(there, Placement)
    assert there.position[2] == pytest.approx(7.0, abs=0.05)


def test_what_stands_before_the_end_of_a_placed_text_hides_it() -> None:
    centre = np.array([0.1, -0.1, 3.0])
    _, box, normal = sign(centre, 25.0)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turned(30.0), [0.5, 0.0, 1.0]
    depth = wall_depth(centre, normal)
    placement = placed(box, depth, pose)
    begin = int(box[0, 0]) - 3
    depth[:, :begin] = 1.5
    hidden = hidden_pixels(box, placement, depth, CAMERA, pose, CONFIG)
    row = int(box[:, 1].mean())
    assert hidden[row, begin - 8 : begin].all()
    assert not hidden[row, begin:].any(), "the wall itself hides nothing"


@pytest.mark.parametrize("at", [0.1, 0.4, 0.7])
def test_who_walks_by_before_a_sign_beyond_the_sensors_reach_does_not_carry_it(at: float) -> None:
    """The letters that he covers are missing; the depth of the rest is not known."""
    _, box, _ = sign(np.array([0.0, -0.5, 9.0]), 5.0, width=2.4, height=0.4)
    depth = np.zeros((480, 640), np.float32)
    left, right = box[:, 0].min(), box[:, 0].max()
    first, last = (int(left + share * (right - left)) for share in (at, at + 0.25))
    depth[100:, first:last] = 4.5
    result = place_text(box, depth, CAMERA, np.eye(4), CONFIG)
    assert result in (PlacementFault.NO_DEPTH, PlacementFault.HIDDEN)


def test_a_sign_half_of_which_has_depth_hangs_where_that_is() -> None:
    centre = np.array([0.0, 0.0, 3.0])
    _, box, normal = sign(centre, 20.0)
    depth = wall_depth(centre, normal, 0.0022)
    left, right = box[:, 0].min(), box[:, 0].max()
    depth[:, int(left + 0.55 * (right - left)) :] = 0.0
    assert placed(box, depth).position == pytest.approx(centre, abs=0.03)
    # Letters that have none, on a board that has it.
    letters = wall_depth(centre, normal, 0.0022)
    letters[:, int(left) : int(right)][:, (np.arange(int(right) - int(left)) // 6) % 2 == 0] = 0.0
    assert placed(box, letters).position == pytest.approx(centre, abs=0.03)


def test_of_a_text_without_depth_what_has_some_beyond_its_end_hides_the_rest() -> None:
    """A sign beyond the sensor's reach, of which a pillar covers a part: it may be placed on the pillar."""
    centre = np.array([0.0, -0.1, 3.0])
    _, box, normal = sign(centre, 0.0)
    depth = np.zeros_like(wall_depth(centre, normal))
    end = int(box[:, 0].max()) + 2
    depth[:, end : end + 60] = 2.0
    on_pillar = placed(box, wall_depth(np.array([0.0, -0.1, 2.0]), normal), np.eye(4))
    for placement in (None, on_pillar):
        hidden = hidden_pixels(box, placement, depth, CAMERA, np.eye(4), CONFIG)
        assert hidden[int(box[:, 1].mean()), end + 5]
