"""Learn the descriptor's test pairs and the words of place recognition, on imagery that this script makes.

    python tools/train_vocabulary.py pairs        # src/lpslam/slam/assets/test_pairs.npy, about two minutes
    python tools/train_vocabulary.py vocabulary   # src/lpslam/slam/assets/vocabulary.npz, with the pairs as they are

The imagery: frames of rendered malls, of seeds from 900 on that nothing else uses, and pictures of noise, shapes,
materials and words. The same command gives the same files, to the byte.
"""

import argparse
from collections.abc import Callable, Iterator, Sequence
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
from lpslam.slam.features import FeatureExtractor
from lpslam.slam.vocabulary import Vocabulary

ASSETS = Path(__file__).parents[1] / "src" / "lpslam" / "slam" / "assets"
FIRST_SEED = 900
BRANCHES, LEVELS = 10, 4

Gray = NDArray[np.uint8]
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


# Words ------------------------------------------------------------------------------------------------------------


def describe(pictures: Iterator[NDArray[np.uint8]]) -> list[Bits]:
    """Descriptors (n, 4) of each picture."""
    camera = PinholeCamera(width=640, height=480, fx=560.0, fy=560.0, cx=320.0, cy=240.0)
    extractor = FeatureExtractor(camera, FeatureConfig())
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
    parser.add_argument("what", choices=("vocabulary",))
    parser.add_argument("--malls", type=int, default=12)
    parser.add_argument("--frames", type=int, default=24, help="of each mall")
    parser.add_argument("--pictures", type=int, default=120, help="generated ones")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    pictures = describe(mall_frames(arguments.malls, arguments.frames))
    pictures += describe(generated_pictures(arguments.pictures))
    vocabulary = train_vocabulary(pictures, BRANCHES, LEVELS, 250_000)
    path = ASSETS / "vocabulary.npz"
    np.savez(path, tree=vocabulary.tree, branches=vocabulary.branches, rarity=vocabulary.rarity.astype(np.float16))
    print(f"{path}: {vocabulary.size} words, {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
