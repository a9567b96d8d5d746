"""Finding the pose of a view in the map of a walk, and believing nothing that was taken elsewhere."""

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from disturbances import Clip
from slam_scenes import flip_bits, pose_error

from lpslam.camera import inverse_transform
from lpslam.config import SimulationConfig, SlamConfig
from lpslam.frames import RgbdFrame
from lpslam.simulation.replay import NoisyAgain
from lpslam.simulation.source import MallSource
from lpslam.slam.features import FeatureExtractor, Features, gray_of
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.located import Expected, Located
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.looking import Looking
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.system import RgbdSlam

pytestmark = pytest.mark.slow

FRAMES = 70  # of the walk
CONFIG = SlamConfig()


@dataclass(frozen=True)
class Walked:
    """The map of a walk, with the tools that find views in it.

    Attributes:
        poses: (n, 4, 4) world from camera of every frame as mapped.
    """

    clip: Clip
    slam: RgbdSlam
    poses: np.ndarray
    extractor: FeatureExtractor
    locator: Locator
    relocaliser: Relocaliser

    def again(self, index: int, seed: int = 1) -> RgbdFrame:
        """A frame of the walk as the sensor sees it another time."""
        return NoisyAgain(self.clip, seed).disturbed(list(self.clip)[index], seed)

    def find(self, frame: RgbdFrame) -> Located | None:
        return self.relocaliser.find(self.extractor.extract(frame), -1)

    def near(self, index: int) -> int:
        """The living keyframe whose camera stood nearest to a frame's."""
        living = self.slam.map.living_keyframes()
        centres = np.array([self.slam.map.world_from_keyframe(int(k))[:3, 3] for k in living])
        return int(living[np.linalg.norm(centres - self.poses[index][:3, 3], axis=1).argmin()])


@pytest.fixture(scope="module")
def walked_here(walk: Path) -> Walked:
    clip = Clip(walk, range(FRAMES))
    slam = RgbdSlam(clip.camera)
    for frame in clip:
        assert slam.process(frame).is_tracked
    slam.finish()
    locator = Locator(slam.map, slam.sensor, CONFIG.tracking, CONFIG.locating)
    relocaliser = Relocaliser(slam.map, PlaceIndex.of(slam.map), locator, CONFIG.tracking, CONFIG.locating)
    _, poses = slam.trajectory.world_from_camera(slam.map)
    return Walked(clip, slam, poses, FeatureExtractor(clip.camera, CONFIG.features), locator, relocaliser)


@pytest.fixture(scope="module")
def mall() -> MallSource:
    """The mall of the walk and all of the way round, without the sensor's noise, which takes long to draw."""
    return MallSource(7, options=SimulationConfig(loop_length=26.0, sensor_noise=False))


def test_views_with_fresh_noise_are_located_to_two_centimetres(walked_here: Walked) -> None:
    errors = []
    for index in range(4, FRAMES, 10):
        located = walked_here.find(walked_here.again(index))
        assert located is not None, f"frame {index}"
        errors.append(pose_error(inverse_transform(located.camera_from_world), walked_here.poses[index]))
        assert located.inliers == (located.points >= 0).sum() >= CONFIG.locating.min_inliers
        assert located.seen_share >= CONFIG.locating.min_seen_share
        assert located.depth_agreement > 0.9
    metres, radians = np.array(errors).T
    assert metres.max() < 0.02
    assert np.degrees(radians.max()) < 0.5


def test_views_from_between_the_frames_are_located(walked_here: Walked, mall: MallSource) -> None:
    """The recording holds every second frame of the walk: here are some of the others, rendered anew."""
    assert mall.camera == walked_here.clip.camera
    truth = mall.ground_truth.world_from_camera
    for index in (11, 71, 131):
        frame = NoisyAgain(mall, 5, share=1.0).disturbed(mall.frame(index), 5)
        located = walked_here.find(frame)
        assert located is not None, f"frame {index}"
        # Against the frame just before it, for the map is turned and shifted against the mall.
        before = index // 2
        moved = inverse_transform(walked_here.poses[before]) @ inverse_transform(located.camera_from_world)
        metres, radians = pose_error(moved, inverse_transform(truth[index - 1]) @ truth[index])
        assert metres < 0.02
        assert np.degrees(radians) < 0.5


def test_a_picture_shows_what_its_place_has_in_view_and_not_what_another_has(walked_here: Walked) -> None:
    looking = Looking(walked_here.slam.map, walked_here.extractor, CONFIG.locating)
    for index in range(4, FRAMES, 25):
        frame = walked_here.again(index)
        located = walked_here.find(frame)
        assert located is not None
        assert looking.share(gray_of(frame.rgb), located) > 0.6, f"frame {index}"
        elsewhere = gray_of(walked_here.again((index + FRAMES // 2) % FRAMES).rgb)
        assert looking.share(elsewhere, located) < 0.3, f"frame {index}"


def test_a_picture_that_lacks_a_sign_contradicts_a_place_that_it_shows_otherwise(walked_here: Walked) -> None:
    """What stands together is painted over, as if it had never hung there: all else is as it was."""
    looking, lacking = Looking(walked_here.slam.map, walked_here.extractor, CONFIG.locating), 0
    for index in range(4, FRAMES, 25):
        frame = walked_here.again(index)
        located, gray = walked_here.find(frame), gray_of(frame.rgb)
        assert located is not None
        assert not looking.contradicts(gray, located), f"frame {index}"
        pixels = located.expected.pixels
        near = np.argsort(np.linalg.norm(pixels - pixels[len(pixels) // 2], axis=1))[:40]
        (left, top), (right, bottom) = pixels[near].min(axis=0).astype(int), pixels[near].max(axis=0).astype(int)
        without = gray.copy()
        without[max(top - 8, 0) : bottom + 8, max(left - 8, 0) : right + 8] = int(np.median(gray))
        lacking += looking.contradicts(without, located)
        few = replace(located, expected=Expected(*(column[:30] for column in located.expected)))
        assert not looking.contradicts(without, few), "of a few points nothing is usual"
    assert lacking >= len(range(4, FRAMES, 25)) - 1


def test_a_picture_that_cannot_be_asked_says_nothing_against_a_place(walked_here: Walked) -> None:
    looking, frame = Looking(walked_here.slam.map, walked_here.extractor, CONFIG.locating), walked_here.again(4)
    located = walked_here.find(frame)
    assert located is not None
    few = Expected(*(column[:5] for column in located.expected))
    blank = np.zeros_like(gray_of(frame.rgb))
    assert looking.share(blank, located) < CONFIG.locating.min_there_share
    assert looking.share(blank, replace(located, expected=few)) == CONFIG.locating.min_there_share


@pytest.mark.parametrize(("elsewhere", "is_located"), [(0.0, True), (0.1, True), (0.4, False)])
def test_a_view_in_which_much_that_looks_alike_is_elsewhere_is_of_another_place(
    walked_here: Walked, elsewhere: float, is_located: bool
) -> None:
    """A pattern and fronts that are all alike fit in their greater part; the rest contradicts."""
    index = 60
    features = walked_here.extractor.extract(walked_here.again(index))
    random = np.random.default_rng(2)
    moved = random.random(features.rows) < elsewhere
    pixels = features.pixels + np.where(moved[:, None], random.choice([-40.0, 40.0], (features.rows, 2)), 0.0)
    located = walked_here.locator.locate(
        features._replace(pixels=pixels.astype(features.pixels.dtype)), walked_here.near(index)
    )
    assert (located is not None) == is_located


def test_a_view_whose_patches_look_different_is_located_from_where_something_else_says_it_is(
    walked_here: Walked,
) -> None:
    index = 60
    features = walked_here.extractor.extract(walked_here.again(index))
    # Beyond what is believed without a place to look at, within what is in a window.
    changed = features._replace(descriptor=flip_bits(np.random.default_rng(0), features.descriptor, 75))
    near = walked_here.near(index)
    assert walked_here.locator.locate(changed, near) is None
    for off in ([0.06, -0.04, 0.05, 0.02, -0.02, 0.01], [-0.05, 0.03, -0.06, -0.01, 0.03, -0.02]):
        guess = exponential(np.array(off)) @ inverse_transform(walked_here.poses[index])
        located = walked_here.locator.locate(changed, near, guess=guess)
        assert located is not None
        metres, radians = pose_error(inverse_transform(located.camera_from_world), walked_here.poses[index])
        assert metres < 0.03
        assert np.degrees(radians) < 0.7
    elsewhere = exponential(np.array([1.0, 0, 0, 0, 0.6, 0])) @ inverse_transform(walked_here.poses[index])
    assert walked_here.locator.locate(changed, near, guess=elsewhere) is None


def test_views_of_another_mall_are_never_located(walked_here: Walked) -> None:
    """Built of the same tiles, lamps and fonts."""
    other = MallSource(19, options=SimulationConfig(loop_length=26.0, sensor_noise=False))
    keyframes = walked_here.slam.map.living_keyframes()[::4]
    views = range(0, len(other), len(other) // 20)
    for number, index in enumerate(views):
        features = walked_here.extractor.extract(other.frame(index))
        assert features.rows > 300
        assert walked_here.relocaliser.find(features, int(keyframes[number % len(keyframes)])) is None, index
    assert len(views) >= 20


def test_a_part_of_the_same_mall_that_was_not_mapped_is_not_located(walked_here: Walked, mall: MallSource) -> None:
    # Half round the loop, on the other side of the block.
    for index in range(len(mall) // 2, len(mall) // 2 + 60, 20):
        assert walked_here.find(mall.frame(index)) is None, index


@pytest.mark.parametrize("factor", [1.3, 0.75])
def test_a_view_whose_depth_contradicts_the_map_is_refused(walked_here: Walked, factor: float) -> None:
    """A picture of the place, or the same front built larger: looks agree, measures do not."""
    for index in (14, 34, 64):
        frame = walked_here.again(index)
        assert walked_here.find(frame) is not None
        assert walked_here.find(replace(frame, depth=frame.depth * np.float32(factor))) is None


def test_without_depth_looks_alone_suffice(walked_here: Walked) -> None:
    frame = walked_here.again(54)
    located = walked_here.find(replace(frame, depth=np.zeros_like(frame.depth)))
    assert located is not None
    metres, radians = pose_error(inverse_transform(located.camera_from_world), walked_here.poses[54])
    assert metres < 0.03
    assert np.degrees(radians) < 0.7


def test_a_poster_of_the_place_is_not_the_place(walked_here: Walked) -> None:
    """The view fills a quarter of the picture; the rest is a wall."""
    frame = walked_here.again(54)
    rng = np.random.default_rng(3)
    rgb = rng.normal(190, 2, frame.rgb.shape).clip(0, 255).astype(np.uint8)
    depth = np.full_like(frame.depth, 1.5)
    rgb[120:360, 160:480] = cv2.resize(frame.rgb, (320, 240), interpolation=cv2.INTER_AREA)
    assert walked_here.find(replace(frame, rgb=rgb, depth=depth)) is None


def test_a_view_of_nothing_is_not_located(walked_here: Walked) -> None:
    frame = walked_here.again(10)
    assert walked_here.find(replace(frame, rgb=np.full_like(frame.rgb, 90))) is None


def test_the_same_view_is_located_the_same_to_the_bit(walked_here: Walked) -> None:
    features, keyframe = walked_here.extractor.extract(walked_here.again(30)), walked_here.near(30)
    first = walked_here.locator.locate(features, keyframe)
    assert first is not None
    cv2.setRNGSeed(77)
    second = walked_here.locator.locate(Features(*(column.copy() for column in features)), keyframe)
    assert second is not None
    np.testing.assert_array_equal(first.camera_from_world, second.camera_from_world)
    np.testing.assert_array_equal(first.points, second.points)
    assert (first.inliers, len(first.expected.points), first.depth_agreement) == (
        (second.inliers, len(second.expected.points), second.depth_agreement)
    )


def test_only_the_points_of_allowed_keyframes_are_used(walked_here: Walked) -> None:
    slam_map = walked_here.slam.map
    features, keyframe = walked_here.extractor.extract(walked_here.again(60)), walked_here.near(60)
    allowed = np.zeros(slam_map.keyframe_count, np.bool_)
    allowed[keyframe] = True
    located = walked_here.locator.locate(features, keyframe, allowed)
    assert located is not None
    seen = slam_map.columns.point[slam_map.columns.keyframe_slot[keyframe]]
    assert set(located.points[located.points >= 0].tolist()) <= set(seen[seen >= 0].tolist())
    assert pose_error(inverse_transform(located.camera_from_world), walked_here.poses[60])[0] < 0.03


def test_where_nothing_of_what_should_be_seen_is_seen_is_another_place(walked_here: Walked) -> None:
    """A floor may be the same everywhere: the wall above it is not."""
    index = 60
    features = walked_here.extractor.extract(walked_here.again(index))
    assert walked_here.locator.locate(features, walked_here.near(index)) is not None
    # The upper third shows something else.
    changed = features.pixels[:, 1] < walked_here.clip.camera.height / 3
    other = flip_bits(np.random.default_rng(0), features.descriptor, 120)
    elsewhere = features._replace(descriptor=np.where(changed[:, None], other, features.descriptor))
    assert walked_here.locator.locate(elsewhere, walked_here.near(index)) is None
