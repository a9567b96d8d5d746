"""A pose from one sign and keypoints around it."""

import numpy as np
import pytest
from slam_scenes import rigid

from lpslam.slam.advice import Anchor
from lpslam.slam.places.anchored import anchored_pose

INTRINSICS = np.array([525.0, 525.0, 319.5, 239.5, 40.0])
SIGN = np.array([[-0.7, -0.9, 6.0], [0.7, -0.9, 6.0], [0.7, -0.6, 6.0], [-0.7, -0.6, 6.0]])
POSE = rigid([0.4, -0.2, 0.6], [0.05, -0.25, 0.03])


def seen(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions in the camera's frame, and pixels."""
    local = points @ POSE[:3, :3].T + POSE[:3, 3]
    pixels = local[:, :2] / local[:, 2:] * INTRINSICS[:2] + INTRINSICS[2:4]
    return local / np.linalg.norm(local, axis=1, keepdims=True), pixels.astype(np.float32)


def anchored(*signs: np.ndarray) -> Anchor:
    return Anchor(np.array(signs or [SIGN]), np.array([seen(sign)[0] for sign in signs or [SIGN]]))


def front(count: int, seed: int = 1) -> np.ndarray:
    """Points of a shop front around the sign."""
    random = np.random.default_rng(seed)
    return np.column_stack(
        [random.uniform(-1.5, 1.5, count), random.uniform(-1, 1, count), random.uniform(6, 6.5, count)]
    )


@pytest.mark.parametrize("wrong", [0, 20, 60])
def test_the_pose_is_found_among_many_wrong_matches(wrong: int) -> None:
    points = front(20 + wrong)
    _, pixels = seen(points)
    random = np.random.default_rng(2)
    pixels[20:] = random.uniform([0, 0], [640, 480], (wrong, 2))
    found = anchored_pose(anchored(), points, pixels, INTRINSICS, 8.0, 6)
    assert found is not None
    pose, rows = found
    np.testing.assert_allclose(pose, POSE, atol=1e-2)
    assert set(range(20)) <= set(rows.tolist())
    assert len(rows) <= 20 + wrong // 4


def test_matches_of_another_front_make_no_pose() -> None:
    points = front(15)
    _, pixels = seen(points + np.array([3.3, 0.0, 0.0]))
    assert anchored_pose(anchored(), points, pixels, INTRINSICS, 8.0, 6) is None


def test_without_matches_there_is_none() -> None:
    anchor = anchored()
    assert anchored_pose(anchor, np.zeros((0, 3)), np.zeros((0, 2), np.float32), INTRINSICS, 8.0, 6) is None
    alone = SIGN[:1] + np.array([0.0, 0.2, 0.1])
    assert anchored_pose(anchor, alone, seen(alone)[1], INTRINSICS, 8.0, 2) is None


def test_the_scale_of_the_view_at_an_anchor() -> None:
    pixels, anchor = seen(SIGN)[1], anchored()
    np.testing.assert_allclose(anchor.pixels(INTRINSICS), pixels[None], atol=1e-3)
    assert anchor.pixels_per_metre(INTRINSICS).tolist() == [pytest.approx(525 / 6.6, rel=0.1)]
    np.testing.assert_allclose(anchor.middles, [[0.0, -0.75, 6.0]])


def test_of_several_signs_the_ends_that_are_farthest_apart_hold_the_pose() -> None:
    points = front(12)
    other = SIGN + np.array([3.3, 0.0, 0.0])
    random = np.random.default_rng(3)
    off: list[list[float]] = [[], []]
    for _ in range(20):
        for count in (1, 2):
            anchor = anchored(*(SIGN, other)[:count])
            noisy = anchor.directions / anchor.directions[..., 2:]
            noisy[..., :2] += random.normal(0, 1.5 / 525, (count, 4, 2))
            anchor = Anchor(anchor.corners, noisy)
            found = anchored_pose(anchor, points, seen(points)[1], INTRINSICS, 8.0, 6)
            assert found is not None
            off[count - 1].append(float(np.abs(found[0] - POSE).max()))
    assert np.median(off[1]) < 0.7 * np.median(off[0])
