import importlib
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lpslam.config import FeatureConfig
from lpslam.simulation.source import MallSource
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.places.index import PlaceIndex, group_candidates
from lpslam.slam.places.vocabulary import Vocabulary

VOCABULARY = Vocabulary.load()


def descriptors(seed: int, count: int = 200) -> NDArray[np.uint64]:
    return np.random.default_rng(seed).integers(0, 2**64, (count, 4), np.uint64)


def nearest_by_hand(descriptor: NDArray[np.uint64], vocabulary: Vocabulary) -> int:
    """The word, by plain numpy down the tree."""
    node, start, size = 0, 0, vocabulary.branches
    while start < len(vocabulary.tree):
        children = node * vocabulary.branches + np.arange(vocabulary.branches)
        bits = np.bitwise_count(vocabulary.tree[start + children] ^ descriptor).sum(axis=1)
        node = int(children[bits.argmin()])
        start, size = start + size, size * vocabulary.branches
    return node


def test_words_are_the_leaves_of_a_walk_to_the_nearest_children() -> None:
    some = descriptors(1, 50)
    assert VOCABULARY.words(some).tolist() == [nearest_by_hand(row, VOCABULARY) for row in some]


def test_the_vocabulary_is_small_and_every_word_of_it_can_be_reached() -> None:
    assert VOCABULARY.size == 22**3
    assert VOCABULARY.tree.nbytes + 2 * VOCABULARY.size < 400_000
    leaves = VOCABULARY.tree[-VOCABULARY.size :]
    reached = VOCABULARY.words(leaves)
    # Twins fill nodes with few members, and a leaf may lie across its parent's border: most reach themselves.
    assert (reached == np.arange(VOCABULARY.size)).mean() > 0.5


def test_a_view_without_keypoints_is_like_nothing() -> None:
    index = PlaceIndex()
    index.add(0, np.empty((0, 4), np.uint64))
    index.add(1, descriptors(1))
    assert index.query(np.empty((0, 4), np.uint64)).tolist() == [0.0, 0.0]
    assert index.query(descriptors(1))[0] == 0.0


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(0, 40), min_size=1, max_size=12, unique=True), st.integers(0, 40))
def test_a_query_finds_itself_and_agrees_with_similarity_both_ways(keyframes: list[int], query: int) -> None:
    index = PlaceIndex()
    for keyframe in keyframes:
        index.add(keyframe, descriptors(keyframe))
    scores = index.query(descriptors(query))
    assert len(scores) == max(keyframes) + 1
    assert scores.dtype == np.float32
    assert (scores <= 1 + 1e-5).all()
    assert not scores[np.setdiff1d(np.arange(len(scores)), keyframes)].any()
    for keyframe in keyframes:
        expected = 1.0 if keyframe == query else index_of_two(keyframe, query)
        assert scores[keyframe] == pytest.approx(expected, abs=1e-5)
    first, last = keyframes[0], keyframes[-1]
    assert index.query_keyframe(first)[last] == pytest.approx(index.query_keyframe(last)[first])
    assert index.query_keyframe(first)[first] == pytest.approx(1.0, abs=1e-5)
    np.testing.assert_array_equal(index.query_keyframe(first), index.query(descriptors(first)))


def index_of_two(a: int, b: int) -> float:
    """The L1 score by its definition, 1 − ½·|v − w|."""
    vectors = np.zeros((2, VOCABULARY.size))
    for row, seed in enumerate((a, b)):
        words, weights = VOCABULARY.weighted(descriptors(seed))
        vectors[row, words] = weights
    return float(1 - 0.5 * np.abs(vectors[0] - vectors[1]).sum())


@settings(max_examples=25, deadline=None)
@given(st.lists(st.tuples(st.booleans(), st.integers(0, 30)), max_size=80))
def test_adding_and_removing_leaves_what_a_fresh_index_holds(steps: list[tuple[bool, int]]) -> None:
    index, held = PlaceIndex(), set()
    for adds, keyframe in steps:
        if not adds:
            index.remove(keyframe)
            held.discard(keyframe)
        elif keyframe not in held:
            index.add(keyframe, descriptors(keyframe, 60))
            held.add(keyframe)
    fresh = PlaceIndex()
    for keyframe in sorted(held):
        fresh.add(keyframe, descriptors(keyframe, 60))
    scores, expected = index.query(descriptors(3, 60)), fresh.query(descriptors(3, 60))
    np.testing.assert_array_equal(scores[: len(expected)], expected)
    assert not scores[len(expected) :].any()
    assert len(index) == len(held)
    assert all((keyframe in index) == (keyframe in held) for keyframe in range(31))


def test_postings_of_one_word_outgrow_many_blocks_and_shrink_again() -> None:
    index, same = PlaceIndex(), descriptors(5, 30)
    for keyframe in range(200):
        index.add(keyframe, same)
    blocks = len(index._postings.next_block)
    for keyframe in range(0, 200, 2):
        index.remove(keyframe)
    np.testing.assert_allclose(index.query(same), np.arange(200) % 2, atol=1e-5)
    for keyframe in range(0, 200, 2):
        index.add(keyframe, same)
    assert len(index._postings.next_block) == blocks
    np.testing.assert_allclose(index.query(same), 1.0, atol=1e-5)


def test_only_eligible_keyframes_score() -> None:
    index = PlaceIndex()
    for keyframe in range(4):
        index.add(keyframe, descriptors(0))
    assert index.query(descriptors(0), np.array([True, False, True])).round(4).tolist() == [1, 0, 1, 0]
    assert index.query(descriptors(0), np.zeros(9, np.bool_)).tolist() == [0, 0, 0, 0]


def test_what_is_not_indexed_is_refused() -> None:
    index = PlaceIndex()
    index.add(2, descriptors(0))
    with pytest.raises(ValueError, match="indexed already"):
        index.add(2, descriptors(1))
    for missing in (0, 3, -1):
        with pytest.raises(KeyError):
            index.query_keyframe(missing)
        index.remove(missing)
    assert 2 in index


@pytest.mark.slow
def test_ten_thousand_keyframes_are_searched_in_milliseconds() -> None:
    words = VOCABULARY.tree[-VOCABULARY.size :]
    random = np.random.default_rng(0)
    index = PlaceIndex()
    began = time.thread_time()
    for keyframe in range(2000):
        index.add(keyframe, words[random.integers(0, len(words), 1000)])
    assert time.thread_time() - began < 4.0
    for keyframe in range(2000, 10_000):
        index.add(keyframe, words[random.integers(0, len(words), 1000)])
    spent = []
    for _ in range(9):
        view = words[random.integers(0, len(words), 1000)]
        began = time.thread_time()
        index.query(view)
        spent.append(time.thread_time() - began)
    assert np.median(spent) < 0.02


def test_threads_may_add_remove_and_ask_at_once() -> None:
    index = PlaceIndex()
    errors: list[str] = []
    for keyframe in range(50):
        index.add(keyframe, descriptors(keyframe, 100))

    def grow() -> None:
        for keyframe in range(50, 400):
            index.add(keyframe, descriptors(keyframe, 100))
            index.remove(keyframe)

    def ask() -> None:
        errors.extend("lost" for _ in range(300) if index.query(descriptors(7, 100))[7] < 0.999)

    threads = [threading.Thread(target=work) for work in (grow, ask, ask)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    assert len(index) == 50


def chain(keyframe: int, least: int) -> NDArray[np.int32]:
    """Covisibility along a corridor: the keyframes next to one, nearest first."""
    around = [keyframe + d for step in (1, 2) for d in (-step, step)]
    return np.array([k for k in around if 0 <= k < 40], np.int32)


def test_keyframes_that_see_a_place_together_are_one_candidate() -> None:
    scores = np.zeros(40, np.float32)
    scores[[9, 10, 11]] = 0.2, 0.3, 0.25
    scores[30] = 0.35  # alone: what is seen by one keyframe only is less likely than what three agree on
    assert group_candidates(scores, chain, 5) == [10]
    scores[[29, 31]] = 0.2
    assert group_candidates(scores, chain, 5) == [10, 30]
    assert group_candidates(scores, chain, 1) == [10] or group_candidates(scores, chain, 1) == [30]


def test_candidates_below_the_floor_are_none_and_those_of_an_older_map_are_no_neighbours() -> None:
    scores = np.zeros(20, np.float32)
    assert group_candidates(scores, chain, 5) == []
    scores[[4, 19]] = 0.1, 0.2
    assert group_candidates(scores, chain, 5, floor=0.2) == []
    assert group_candidates(scores, chain, 5, floor=0.15) == [19]


@pytest.mark.slow
def test_frames_of_a_mall_find_the_keyframes_beside_them() -> None:
    mall = MallSource(951)
    extractor = FeatureExtractor(mall.camera, FeatureConfig())
    index = PlaceIndex()
    keyframes = np.arange(20, 900, 80)
    for number, frame in enumerate(keyframes.tolist()):
        index.add(number, extractor.extract(mall.frame(frame)).descriptor)
    queries = [extractor.extract(mall.frame(frame + 8)).descriptor for frame in keyframes.tolist()]
    scores = np.array([index.query(query) for query in queries])
    right, rivals = np.diag(scores), np.where(np.eye(len(scores)), 0, scores).max(axis=1)
    assert (scores.argmax(axis=1) == np.arange(len(scores))).all()
    assert np.median(right / rivals) > 1.5


@pytest.fixture(scope="module")
def trainer() -> Iterator[ModuleType]:
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(Path(__file__).parents[3] / "tools"))
        yield importlib.import_module("train_vocabulary")


def test_views_are_cut_from_large_pictures_of_every_package_in_turn(trainer: ModuleType, tmp_path: Path) -> None:
    pictures = importlib.import_module("training_pictures")
    random = np.random.default_rng(0)
    for package, channel in (("red", 0), ("blue", 2)):
        (tmp_path / package / "deep").mkdir(parents=True)
        coarse = random.integers(0, 256, (60, 80, 3), np.uint8)
        coarse[..., channel] = 0
        large = cv2.resize(coarse, (800, 600), interpolation=cv2.INTER_NEAREST)
        cv2.imwrite(str(tmp_path / package / "deep" / "large.png"), large)
        cv2.imwrite(str(tmp_path / package / "smaller.png"), cv2.resize(large, (640, 480)))
        cv2.imwrite(str(tmp_path / package / "icon.png"), random.integers(0, 256, (100, 100, 3), np.uint8))
    views = list(pictures.photographed(tmp_path, 100))
    # The smaller file is the same picture, and the icon is too small.
    assert 8 <= len(views) <= 2 * pictures.MOST_VIEWS
    assert all(view.shape == (480, 640, 3) and view.dtype == np.uint8 for view in views)
    blue, red = (view.mean(axis=(0, 1)) for view in views[:2])
    assert red[0] > red[2] + 40
    assert blue[2] > blue[0] + 40
    again = list(pictures.photographed(tmp_path, 5))
    assert len(again) == 5
    assert all((one == other).all() for one, other in zip(views, again, strict=False))


def test_training_twice_gives_the_same_words_and_they_hold_clusters_together(trainer: ModuleType) -> None:
    random = np.random.default_rng(0)
    centres = random.integers(0, 2, (9, 256))
    members = centres[np.arange(360) % 9] ^ (random.random((360, 256)) < 0.05)
    bits = np.packbits(members.astype(np.uint8), axis=1).view(np.uint64)
    pictures = [bits[:180], bits[180:]]
    one, other = (trainer.train_vocabulary(pictures, 3, 2, 360) for _ in range(2))
    np.testing.assert_array_equal(one.tree, other.tree)
    np.testing.assert_array_equal(one.rarity, other.rarity)
    words = one.words(bits)
    pure = sum(np.bincount(np.arange(360)[words == word] % 9).max() for word in np.unique(words))
    assert pure / 360 > 0.9


def test_chosen_test_pairs_differ_between_patches_and_depend_on_each_other_little(trainer: ModuleType) -> None:
    random = np.random.default_rng(0)
    points = trainer.reachable_points()
    first = random.integers(0, 256, (1500, len(points)), np.uint8)
    second = np.clip(first + random.normal(0, 10, first.shape), 0, 255).astype(np.uint8)
    patches = np.stack([first, second])
    one, other = (trainer.choose_pairs(np.random.default_rng(2), patches, points, 600) for _ in range(2))
    np.testing.assert_array_equal(one, other)
    assert one.shape == (512, 2)
    assert one.dtype == np.int8
    row_of = {tuple(point): row for row, point in enumerate(points.astype(int).tolist())}
    rows = np.array([row_of[tuple(point)] for point in one.tolist()])
    outcome = first[:, rows[::2]] < first[:, rows[1::2]]
    assert np.abs(outcome.mean(axis=0) - 0.5).max() < 0.1
    assert np.abs(np.corrcoef(outcome.T) - np.eye(256)).max() < 0.7
