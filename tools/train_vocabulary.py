r"""Learn the descriptor's test pairs and the words of place recognition, on imagery of many kinds.

    python tools/train_vocabulary.py pairs --out FOLDER             # test_pairs.npy, to compare
    python tools/train_vocabulary.py vocabulary --pictures FOLDER   # src/lpslam/slam/assets/vocabulary.npz

The imagery: photographs, drawings and documents; frames of worlds, of seeds from 9000 on, and of rendered malls, of
seeds from 900 on, that nothing else uses; pictures of noise, shapes, materials and words. The vocabulary is learned
with the pairs as they are. The pairs that lpslam has were learned on malls and generated pictures; `pairs --pictures`
learns them on all kinds, which is no better (docs/benchmarks/words_and_loops.md), and other pairs make saved maps
useless. The same command on the same pictures gives the same files, to the byte; but malls have changed since the pairs
were learned, and `pairs` gives others now. Raise the version of the map file with them.

The pictures come from Debian 12, whose licences allow any use; none of them is part of this project:

    mkdir pictures && cd pictures
    for each in plasma-workspace-wallpapers lomiri-wallpapers-16.04 lomiri-wallpapers-20.04 ukui-wallpapers \
                palapeli-data opencv-doc tuxpaint-stamps-default hugin-data gimp-help-en stellarium-data; do
        apt-get download $each && dpkg -x ${each}_*.deb $each && rm ${each}_*.deb
    done
    mv stellarium-data/usr/share/stellarium/landscapes stellarium-landscapes && rm -r stellarium-data

What is learned is compared on others, with `benchmarks/descriptors.py`:

    mkdir others && cd others
    apt-get download mate-backgrounds && dpkg -x mate-backgrounds_*.deb mate-backgrounds
    pip download --no-deps --only-binary :all: --python-version 3.7 --platform manylinux1_x86_64 scikit-image==0.16.2
    pip download --no-deps scikit-learn==1.5.2
    for each in scikit_*.whl; do python -m zipfile -e $each ${each%%-*}; done
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam.features import FeatureExtractor, as_gray, gray_of, smoothed
from lpslam.slam.kernels import image as kernels
from lpslam.slam.places.vocabulary import Vocabulary
from training_pictures import FIRST_SEED, generated_pictures, mall_frames, photographed, world_frames

ASSETS = Path(__file__).parents[1] / "src" / "lpslam" / "slam" / "assets"
MALLS_FOR_PAIRS, GENERATED_FOR_PAIRS = (6, 14), 60  # without pictures
PHOTOGRAPHS, WORLDS, MALLS, GENERATED = 320, (40, 7), (10, 24), 100  # views; worlds and malls, and frames of each
BRANCHES, LEVELS = 22, 3

PATCHES, TESTS, SAMPLE = 20_000, 100_000, 250_000  # patches compared, tests tried, descriptors clustered
# From 0.4 the chosen tests are too fine to survive a change of view as well, from 0.7 they say the same too often.
START_CORRELATION = 0.5
PATCH_LEVELS = 4  # of a pyramid, each 1.44 times smaller

Gray = NDArray[np.uint8]
Patches = NDArray[np.uint8]
Bits = NDArray[np.uint64]


# Test pairs -------------------------------------------------------------------------------------------------------


def reachable_points() -> NDArray[np.float64]:
    """Whole pixels (n, 2) that a patch may reach in every direction."""
    reach = np.arange(-kernels.BORDER, kernels.BORDER + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(reach, reach))
    return np.column_stack([x, y])[np.hypot(x, y) <= kernels.BORDER - 3.5].astype(float)


def patches_in_two_views(rng: np.random.Generator, picture: NDArray[np.uint8], points: NDArray[np.float64]) -> Patches:
    """Grey values (2, n, points) about the corners of a picture, turned upright, and the same after a turn."""
    extractor = extractor_for(640, 480)
    level = gray_of(picture)
    found: list[Patches] = []
    for _ in range(PATCH_LEVELS):
        height, width = level.shape
        corners = extractor.corners(level, smoothed(level), 120)[0].astype(float)
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
    return as_gray(smoothed(image)[rows, columns])


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


@lru_cache(maxsize=16)
def extractor_for(width: int, height: int) -> FeatureExtractor:
    """Finds and describes the keypoints of pictures of a size; lens and focal length do not matter."""
    camera = PinholeCamera(width=width, height=height, fx=560.0, fy=560.0, cx=width / 2, cy=height / 2)
    return FeatureExtractor(camera, FeatureConfig())


def describe(picture: NDArray[np.uint8]) -> Bits:
    """Descriptors (n, 4) of a picture."""
    height, width = picture.shape[:2]
    frame = RgbdFrame(0, 0.0, picture, np.zeros((height, width), np.float32))
    return extractor_for(width, height).extract(frame).descriptor


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


def imagery(folder: Path) -> Iterator[Iterator[NDArray[np.uint8]]]:
    """The pictures to learn from, kind by kind."""
    yield photographed(folder, PHOTOGRAPHS)
    yield world_frames(*WORLDS)
    yield mall_frames(*MALLS)
    yield generated_pictures(GENERATED)


def learn_pairs(kinds: Sequence[Iterator[NDArray[np.uint8]]]) -> NDArray[np.int8]:
    """Test pairs (512, 2) from as many patches of each kind."""
    rng, points = np.random.default_rng(FIRST_SEED), reachable_points()
    chosen = []
    for pictures in kinds:
        patches = np.concatenate([patches_in_two_views(rng, each, points) for each in pictures], axis=1)
        chosen.append(patches[:, np.sort(rng.permutation(patches.shape[1])[: PATCHES // len(kinds)])])
    return choose_pairs(rng, np.concatenate(chosen, axis=1), points, TESTS)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("pairs", "vocabulary"))
    parser.add_argument("--pictures", type=Path, help="a folder with a folder of pictures per package")
    parser.add_argument("--out", type=Path, default=ASSETS)
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    if arguments.what == "vocabulary" and arguments.pictures is None:
        parser.error("the vocabulary needs --pictures")
    rendered = chain(mall_frames(*MALLS_FOR_PAIRS), generated_pictures(GENERATED_FOR_PAIRS))
    kinds = [rendered] if arguments.pictures is None else list(imagery(arguments.pictures))
    if arguments.what == "pairs":
        np.save(arguments.out / "test_pairs.npy", learn_pairs(kinds))
        return
    described = [describe(picture) for pictures in kinds for picture in pictures]
    vocabulary = train_vocabulary(described, BRANCHES, LEVELS, SAMPLE)
    path = arguments.out / "vocabulary.npz"
    np.savez(path, tree=vocabulary.tree, branches=vocabulary.branches, rarity=vocabulary.rarity.astype(np.float16))
    print(f"{path}: {vocabulary.size} words, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
