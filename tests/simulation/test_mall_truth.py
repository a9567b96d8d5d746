"""The ground truth against the pictures: geometry that is stated must be geometry that is drawn."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lpslam.camera import inverse_transform, transform_points
from lpslam.frames import FrameSource
from lpslam.simulation.scene import Scene
from lpslam.simulation.source import MallSource

pytestmark = pytest.mark.slow


def cast(scene: Scene, eye: NDArray[np.float64], rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Brute force, independent of the renderer: distance along each ray (m, 3) to the nearest face's front."""
    slope = rays @ scene.normal.T
    gap = np.einsum("ij,ij->i", scene.normal, scene.origin - eye)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = gap / slope
    distance[~np.isfinite(distance)] = -1
    hit = eye + distance[..., None] * rays[:, None, :]
    offset = hit - scene.origin
    a = np.einsum("mfi,fi->mf", offset, scene.edge_u) / np.einsum("fi,fi->f", scene.edge_u, scene.edge_u)
    b = np.einsum("mfi,fi->mf", offset, scene.edge_v) / np.einsum("fi,fi->f", scene.edge_v, scene.edge_v)
    inside = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1) & (distance > 0.05)
    inside &= (slope < 0) | scene.two_sided
    return np.where(inside, distance, np.inf).min(axis=1)


def test_it_is_a_frame_source(mall: MallSource) -> None:
    assert isinstance(mall, FrameSource)
    assert (mall.camera.width, mall.camera.height, mall.camera.fps) == (640, 480, 30.0)


@pytest.mark.parametrize("index", [0, 333, 700])
def test_depth_is_that_of_an_independent_ray_cast(ideal_mall: MallSource, index: int) -> None:
    frame, camera = ideal_mall.frame(index), ideal_mall.camera
    world_from_camera = ideal_mall.ground_truth.world_from_camera[index]
    rng = np.random.default_rng(index)
    pixels = np.column_stack([rng.integers(2, 638, 300), rng.integers(2, 478, 300)])
    rays_in_camera = camera.back_project(pixels.astype(float), np.ones(len(pixels)))
    truth = cast(ideal_mall._mall.scene, world_from_camera[:3, 3], rays_in_camera @ world_from_camera[:3, :3].T)
    drawn = frame.depth[pixels[:, 1], pixels[:, 0]]
    # Only pixels cut by an edge may differ: their quarter sample may lie on the other face.
    assert np.mean(np.abs(drawn - truth) > 1e-3 * truth) < 0.02
    assert np.median(np.abs(drawn - truth)) < 1e-4


def test_pictures_agree_with_poses_and_depth(ideal_mall: MallSource) -> None:
    """A point seen in two frames has the same brightness in both, at the places that the poses and the depth say."""
    camera = ideal_mall.camera
    poses = ideal_mall.ground_truth.world_from_camera
    for first, second in ((50, 56), (400, 408)):
        one, two = ideal_mall.frame(first), ideal_mall.frame(second)
        v, u = np.mgrid[4:476:3, 4:636:3].reshape(2, -1)
        points = camera.back_project(np.column_stack([u, v]).astype(float), one.depth[v, u].astype(float))
        moved = transform_points(inverse_transform(poses[second]) @ poses[first], points)
        keep = moved[:, 2] > 0.3
        pixels = np.rint(camera.project(moved[keep])).astype(int)
        inside = (pixels >= 4).all(axis=1) & (pixels < [636, 476]).all(axis=1)
        x, y = pixels[inside].T
        visible = np.abs(two.depth[y, x] - moved[keep][inside, 2]) < 0.01 * moved[keep][inside, 2]
        assert visible.sum() > 10000
        before = one.rgb[v, u].mean(axis=1)[keep][inside][visible]
        after = two.rgb[y, x].mean(axis=1)[visible]
        wrong_pose = two.rgb[y, np.minimum(x + 6, 639)].mean(axis=1)[visible]
        assert np.median(np.abs(before - after)) < 4.0
        assert np.corrcoef(before, after)[0, 1] > 0.93
        assert np.corrcoef(before, after)[0, 1] > np.corrcoef(before, wrong_pose)[0, 1] + 0.03


def test_signs_are_where_they_are_said_to_be(ideal_mall: MallSource) -> None:
    camera, poses = ideal_mall.camera, ideal_mall.ground_truth.world_from_camera
    signs = [sign for sign in ideal_mall.signs if sign.readable_frames >= 10]
    assert len(signs) >= 6
    checked = 0
    for index in range(20, len(ideal_mall), 60):
        depth = ideal_mall.frame(index).depth
        for sign in signs:
            centre = transform_points(inverse_transform(poses[index]), sign.centre[None])
            facing = sign.normal @ (poses[index][:3, 3] - sign.centre)
            if centre[0, 2] < 0.5 or facing < 0.3:
                continue
            u, v = np.rint(camera.project(centre)[0]).astype(int)
            if 5 <= u < 635 and 5 <= v < 475 and depth[v, u] > 0.98 * centre[0, 2]:
                # Nothing stands before it, so the picture's depth must be the sign's.
                assert depth[v, u] == pytest.approx(centre[0, 2], abs=0.03)
                checked += 1
    assert checked >= 10
    # Boards keep their proportions, and letters are smaller than boards.
    for sign in signs:
        assert np.linalg.norm(sign.normal) == pytest.approx(1.0)
        assert abs((sign.corners[1] - sign.corners[0]) @ sign.normal) < 1e-9
        assert 0.03 < sign.letter_height <= 1.6 * sign.height


@pytest.mark.usefixtures("built_anew")
def test_the_same_seed_gives_the_same_frames(mall: MallSource) -> None:
    again = MallSource(3, frames=4, options=mall._options)
    frames = list(again)
    assert [frame.index for frame in frames] == list(range(4))
    for index in (0, 3):
        expected = mall.frame(index)
        assert np.array_equal(frames[index].rgb, expected.rgb)
        assert np.array_equal(frames[index].depth, expected.depth)
        assert frames[index].timestamp == pytest.approx(index / 30)
    other = MallSource(4, frames=1, options=mall._options)
    assert {sign.text for sign in other._mall.signs} != {sign.text for sign in mall._mall.signs}
    assert np.abs(other.frame(0).rgb.astype(float) - mall.frame(0).rgb).mean() > 10


def test_a_reader_may_stop_early(mall: MallSource) -> None:
    for frame in mall:
        if frame.index == 2:
            break
    assert next(iter(mall)).index == 0
