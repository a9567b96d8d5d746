"""Learn the descriptor's test pairs and the words of place recognition, on imagery that this script makes.

    python tools/train_vocabulary.py pairs        # src/lpslam/slam/assets/test_pairs.npy, about two minutes
    python tools/train_vocabulary.py vocabulary   # src/lpslam/slam/assets/vocabulary.npz, with the pairs as they are

The imagery: frames of rendered malls, of seeds from 900 on that nothing else uses, and pictures of noise, shapes,
materials and words. The same command gives the same files, to the byte.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig, SimulationConfig
from lpslam.frames import RgbdFrame
from lpslam.simulation import lexicon, textures
from lpslam.simulation.lettering import paint_board
from lpslam.simulation.source import MallSource
from lpslam.slam.features import FeatureExtractor, as_gray, gray_of
from lpslam.slam.kernels import image as kernels
from lpslam.slam.places.vocabulary import Vocabulary

ASSETS = Path(__file__).parents[1] / "src" / "lpslam" / "slam" / "assets"
FIRST_SEED = 900
IMAGERY = {"pairs": (6, 14, 60), "vocabulary": (10, 24, 100)}  # malls, frames of each, generated pictures
BRANCHES, LEVELS = 10, 4

CAMERA = PinholeCamera(width=640, height=480, fx=560.0, fy=560.0, cx=320.0, cy=240.0)
PATCHES, TESTS, SAMPLE = 20_000, 100_000, 250_000  # patches compared, tests tried, descriptors clustered
# From 0.4 the chosen tests are too fine to survive a change of view as well, from 0.7 they say the same too often.
START_CORRELATION = 0.5
PATCH_LEVELS = 4  # of a pyramid, each 1.44 times smaller

Gray = NDArray[np.uint8]
Patches = NDArray[np.uint8]
Bits = NDArray[np.uint64]


# Imagery ----------------------------------------------------------------------------------------------------------


def mall_frames(malls: int, frames: int) -> Iterator[NDArray[np.uint8]]:
    """Frames (480, 640, 3) spread over the walks through several malls, every third of them dark."""
    for seed in range(FIRST_SEED, FIRST_SEED + malls):
        mall = MallSource(seed, options=SimulationConfig(light=0.4 if seed % 3 == 2 else 1.0))
        for index in np.linspace(0, len(mall) - 1, frames).astype(int):
            yield mall.frame(int(index)).rgb


def generated_pictures(count: int) -> Iterator[NDArray[np.uint8]]:
    """Pictures (480, 640, 3) of materials, posters, words and noise, each seen a little aside and unsharp."""
    painters: Sequence[Callable[[np.random.Generator], NDArray[np.uint8]]] = (_noise, _shelf, _material, _words)
    for index in range(count):
        rng = np.random.default_rng([FIRST_SEED, index])
        yield _seen_aside(rng, painters[index % len(painters)](rng))


def _noise(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Blobs of all sizes; thresholded in half of the pictures, which gives sharp edges of any shape."""
    field = textures.clouds(rng, 480, 640, rng.uniform(60, 200), rng.uniform(2, 6))
    if rng.random() < 0.5:
        field = np.tanh(field * rng.uniform(3, 12)) * rng.uniform(0.4, 0.9)
    return textures.to_image(np.repeat((128 + 110 * field)[..., None], 3, axis=2))


def _shelf(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Posters side by side, as goods on a shelf."""
    rows, columns = int(rng.integers(1, 5)), int(rng.integers(2, 8))
    height, width = 480 // rows, 640 // columns
    goods = [np.hstack([textures.poster(rng, height, width) for _ in range(columns)]) for _ in range(rows)]
    return np.asarray(cv2.resize(np.vstack(goods), (640, 480)), np.uint8)


def _material(rng: np.random.Generator) -> NDArray[np.uint8]:
    scale = float(rng.uniform(80, 240))
    if rng.random() < 0.5:
        return textures.floor(rng, 480, 640, scale)
    kind = str(rng.choice(["brick", "tiles", "panels", "paper", "stone"]))
    return textures.wall(rng, 480, 640, scale, kind, textures.wall_colour(rng, 0.4))


def _words(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Boards with words on a plain wall."""
    picture = np.full((480, 640, 3), textures.wall_colour(rng, 0.3), np.uint8)
    for _ in range(12):
        wording = lexicon.EVERYTHING[int(rng.integers(len(lexicon.EVERYTHING)))]
        style = str(rng.choice(["plain", "shop", "friendly"]))
        lines = wording.lines("mixed")
        board = paint_board(rng, lines, wording.kind, style, rng.uniform(0.08, 0.25), 1.2, 200.0).image[:400, :500]
        top, left = int(rng.integers(480 - board.shape[0])), int(rng.integers(640 - board.shape[1]))
        picture[top : top + board.shape[0], left : left + board.shape[1]] = board
    return picture


def _seen_aside(rng: np.random.Generator, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    corners = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    aside = corners + rng.normal(0, 60, (4, 2)).astype(np.float32)
    turned = cv2.warpPerspective(
        picture, cv2.getPerspectiveTransform(corners, aside), (640, 480), borderMode=cv2.BORDER_REFLECT
    )
    unsharp = cv2.GaussianBlur(turned, (0, 0), float(rng.uniform(0.4, 1.6)))
    noisy = unsharp * rng.uniform(0.5, 1.1) + rng.normal(0, rng.uniform(1, 5), unsharp.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


# Test pairs -------------------------------------------------------------------------------------------------------


def reachable_points() -> NDArray[np.float64]:
    """Whole pixels (n, 2) that a patch may reach in every direction."""
    reach = np.arange(-kernels.BORDER, kernels.BORDER + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(reach, reach))
    return np.column_stack([x, y])[np.hypot(x, y) <= kernels.BORDER - 3.5].astype(float)


def patches_in_two_views(rng: np.random.Generator, picture: NDArray[np.uint8], points: NDArray[np.float64]) -> Patches:
    """Grey values (2, n, points) about the corners of a picture, turned upright, and the same after a turn."""
    extractor = FeatureExtractor(CAMERA, FeatureConfig())
    level = gray_of(picture)
    found: list[Patches] = []
    for _ in range(PATCH_LEVELS):
        height, width = level.shape
        corners = extractor._detect(level, 120).astype(float)
        turn, grow = float(rng.uniform(0, 360)), float(rng.uniform(0.85, 1.18))
        warp = cv2.getRotationMatrix2D((width / 2, height / 2), turn, grow)
        warp[:, :2] += rng.normal(0, 0.06, (2, 2))  # a view from aside
        warp[:, 2] += (width / 2, height / 2) - warp @ (width / 2, height / 2, 1)
        other = cv2.warpAffine(level, warp, (width, height), borderMode=cv2.BORDER_REFLECT).astype(float)
        other = cv2.GaussianBlur(other, (0, 0), rng.uniform(0.3, 0.9)) * rng.uniform(0.7, 1.1)
        other = np.clip(other + rng.normal(0, rng.uniform(1, 5), other.shape), 0, 255).astype(np.uint8)
        # Found again, a corner lies about a pixel off.
        moved = corners @ warp[:, :2].T + warp[:, 2] + rng.normal(0, 0.6, corners.shape)
        margin = kernels.BORDER + 1
        inside = ((moved > margin) & (moved < (width - margin, height - margin))).all(axis=1)
        views = ((level, corners[inside]), (as_gray(other), moved[inside]))
        found.append(np.stack([_upright(image, places, points) for image, places in views]))
        level = as_gray(cv2.resize(level, None, fx=1 / 1.44, fy=1 / 1.44, interpolation=cv2.INTER_LINEAR))
    return np.concatenate(found, axis=1)


def _upright(image: Gray, places: NDArray[np.float64], points: NDArray[np.float64]) -> Gray:
    """Grey values (n, points) about corners (n, 2), as the descriptor samples them: smoothed, turned, nearest pixel."""
    corners = np.rint(places).astype(np.int32)
    angles = kernels.orientations(image, corners)
    x, y = points.T
    columns = corners[:, :1] + np.rint(np.cos(angles)[:, None] * x - np.sin(angles)[:, None] * y).astype(int)
    rows = corners[:, 1:] + np.rint(np.sin(angles)[:, None] * x + np.cos(angles)[:, None] * y).astype(int)
    return as_gray(as_gray(cv2.blur(image, (5, 5)))[rows, columns])


def choose_pairs(
    rng: np.random.Generator, patches: Patches, points: NDArray[np.float64], tests: int
) -> NDArray[np.int8]:
    """256 tests (512, 2) that tell patches apart, stay the same for a patch, and depend on each other little.

    ORB's choice (Rublee et al. 2011, 4.3) prefers tests whose mean is near a half; here those are preferred that differ
    between two patches by as much more as they can than between two views of one. As there, the best test is taken
    whose correlation with all taken so far is low enough, and what is low enough rises until all are found.
    """
    first, second = rng.integers(0, len(points), (2, tests))
    one, other = (np.ascontiguousarray(view.T) for view in patches)
    count = one.shape[1]
    bits = np.empty((tests, -(-count // 64)), np.uint64)
    score, mean = np.zeros(tests), np.zeros(tests)
    for test in range(tests):
        outcome = one[first[test]] < one[second[test]]
        changed = float((outcome != (other[first[test]] < other[second[test]])).mean())
        mean[test] = outcome.mean()
        differs = 2 * mean[test] * (1 - mean[test])
        score[test] = (differs - changed) / np.sqrt(differs * (1 - differs) + changed * (1 - changed) + 1e-9)
        padded = np.zeros(bits.shape[1] * 8, np.uint8)
        padded[: -(-count // 8)] = np.packbits(outcome)
        bits[test] = padded.view(np.uint64)
    spread = np.sqrt(mean * (1 - mean))
    most = np.where(spread > 0.1, 0.0, np.inf)
    taken: list[int] = []
    allowed = START_CORRELATION
    while len(taken) < 256:
        free = np.flatnonzero(most < allowed)
        if not len(free):
            allowed += 0.01
            continue
        best = int(free[score[free].argmax()])
        taken.append(best)
        apart = np.bitwise_count(bits ^ bits[best]).sum(axis=1) / count
        both = (mean + mean[best] - apart) / 2
        most = np.maximum(most, np.abs(both - mean * mean[best]) / np.maximum(spread * spread[best], 1e-9))
        most[best] = np.inf
    print(f"correlation at most {allowed:.2f}")
    return np.stack([points[first[taken]], points[second[taken]]], axis=1).reshape(512, 2).astype(np.int8)


# Words ------------------------------------------------------------------------------------------------------------


def describe(pictures: Iterator[NDArray[np.uint8]]) -> list[Bits]:
    """Descriptors (n, 4) of each picture."""
    extractor = FeatureExtractor(CAMERA, FeatureConfig())
    blind = np.zeros((480, 640), np.float32)
    return [extractor.extract(RgbdFrame(0, 0.0, picture, blind)).descriptor for picture in pictures]


def signs_of(descriptors: Bits) -> NDArray[np.float32]:
    """Bits as ±1 (n, 256): the inner product of two rows is 256 less twice their Hamming distance."""
    bits = np.unpackbits(descriptors.view(np.uint8), axis=1)
    return np.asarray(2.0 * bits - 1.0, np.float32)


def centres_of(rng: np.random.Generator, signs: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """k-majority: as k-means, but every bit of a centre is what most of its members have (Grana et al. 2013).

    Begins as k-means++ does. Rows (count, 256) of ±1; where there are fewer different members, some come twice.
    """
    centres = signs[rng.integers(len(signs))][None]
    distance = 256.0 - signs @ centres[0]
    while len(centres) < count:
        total = float((distance**2).sum())
        pick = int(rng.choice(len(signs), p=distance**2 / total)) if total > 0 else 0
        centres = np.vstack([centres, signs[pick]])
        distance = np.minimum(distance, 256.0 - signs @ signs[pick])
    for _ in range(12):
        nearest = (signs @ centres.T).argmax(axis=1)
        members = np.zeros((len(signs), count), np.float32)
        members[np.arange(len(signs)), nearest] = 1.0
        votes = members.T @ signs
        new = np.where(votes == 0, centres, np.sign(votes))
        if (new == centres).all():
            break
        centres = new
    return np.asarray(centres, np.float32)


def grow_tree(signs: NDArray[np.float32], branches: int, levels: int, seed: int) -> Bits:
    """Cluster (n, 256) rows of ±1 into a tree of descriptors, as `Vocabulary.tree` lays them out."""
    rng = np.random.default_rng(seed)
    node_of = np.zeros(len(signs), np.int64)
    tree: list[NDArray[np.float32]] = []
    for level in range(levels):
        order = np.argsort(node_of, kind="stable")
        bounds = np.searchsorted(node_of[order], np.arange(branches**level + 1))
        layer = np.empty((branches**level, branches, 256), np.float32)
        for node in range(branches**level):
            rows = order[bounds[node] : bounds[node + 1]]
            if len(rows) == 0:
                layer[node] = tree[-1].reshape(-1, 256)[node]
                continue
            layer[node] = centres_of(rng, signs[rows], branches)
            node_of[rows] = node * branches + (signs[rows] @ layer[node].T).argmax(axis=1)
        tree.append(layer.reshape(-1, 256))
    return np.packbits(np.vstack(tree) > 0, axis=1).view(np.uint64)


def rarity_of(words: Callable[[Bits], NDArray[np.int32]], size: int, pictures: Sequence[Bits]) -> NDArray[np.float16]:
    """Inverse document frequency (size,) of words over pictures; a word never seen counts as seen once."""
    seen = np.zeros(size)
    for descriptors in pictures:
        seen[np.unique(words(descriptors))] += 1
    return np.log(len(pictures) / np.maximum(seen, 1)).astype(np.float16)


def train_vocabulary(pictures: Sequence[Bits], branches: int, levels: int, sample: int) -> Vocabulary:
    """A vocabulary from the descriptors of each picture; `sample` of them grow the tree."""
    everything = np.concatenate(list(pictures))
    chosen = np.random.default_rng(FIRST_SEED).permutation(len(everything))[:sample]
    tree = grow_tree(signs_of(everything[np.sort(chosen)]), branches, levels, FIRST_SEED)
    bare = Vocabulary(tree, branches, np.ones(branches**levels, np.float32))
    return Vocabulary(tree, branches, rarity_of(bare.words, bare.size, pictures).astype(np.float32))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("pairs", "vocabulary"))
    parser.add_argument("--out", type=Path, default=ASSETS)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    malls, frames, generated = IMAGERY[arguments.what]
    pictures = chain(mall_frames(malls, frames), generated_pictures(generated))
    if arguments.what == "pairs":
        rng, points = np.random.default_rng(FIRST_SEED), reachable_points()
        patches = np.concatenate([patches_in_two_views(rng, each, points) for each in pictures], axis=1)
        patches = patches[:, np.sort(rng.permutation(patches.shape[1])[:PATCHES])]
        np.save(arguments.out / "test_pairs.npy", choose_pairs(rng, patches, points, TESTS))
        return
    vocabulary = train_vocabulary(describe(pictures), BRANCHES, LEVELS, SAMPLE)
    path = arguments.out / "vocabulary.npz"
    np.savez(path, tree=vocabulary.tree, branches=vocabulary.branches, rarity=vocabulary.rarity.astype(np.float16))
    print(f"{path}: {vocabulary.size} words, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
