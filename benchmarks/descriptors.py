"""Test pairs and words compared: how well descriptors match between two views, and how well words find a place.

    python benchmarks/descriptors.py FOLDER [FOLDER ...] [--pictures FOLDER] [--assets NAME=FOLDER ...]

The recordings need depth and ground truth. A keypoint of one view is put into another by its depth and the two true
poses; what lies there at a like scale is its true match, and what lies far from there is a wrong one. Photographs are
compared with themselves seen aside. `--assets` names folders with a `test_pairs.npy` and a `vocabulary.npz`; those of
the package are always compared. Keyframes of all recordings go into one index. A query finds its place where a
keyframe of its own recording, two seconds or more away in time, is within 1 m and 45° of it; those that are not, but
within 2 m and 75°, do not count.
"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import FeatureConfig
from lpslam.frames import RgbdFrame
from lpslam.slam import features as described
from lpslam.slam.features import FeatureExtractor, Features
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.vocabulary import Vocabulary
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_uncalibrated

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
from training_pictures import photographed

OURS = Path(described.__file__).parent / "assets"
SPACING = 0.35  # seconds between views
MOST_VIEWS = 120  # of a recording
EVERY = 3  # views until the next that is matched
BESIDE, BEYOND = (1, 3), 6  # views from one that it is matched with; views are a place's again from so many on
NEAR, PERHAPS = (1.0, 45.0), (2.0, 75.0)  # metres and degrees: the same place, and one that may share some of the view
RIGHT, WRONG = 3.0, 20.0  # pixels, times the level's scale: true matches are nearer, wrong ones further
STRICT, RATIO = 60, 0.75  # bits, and best over second best, as tracking asks where nothing but descriptors decides
CAMERA = PinholeCamera(width=640, height=480, fx=560.0, fy=560.0, cx=320.0, cy=240.0)
PICTURES = 60  # views of photographs

Rows = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Recording:
    """Some views of a recording: true poses (n, 4, 4), and the keypoints by each set of test pairs."""

    name: str
    camera: PinholeCamera
    world_from_camera: Rows
    views: list[list[Features]]


@dataclass(eq=False)
class Tally:
    """Distances of true and wrong matches in bits, and what became of keypoints that have a true match."""

    true: NDArray[np.int64]
    wrong: NDArray[np.int64]
    partnered: int = 0
    nearest: int = 0
    taken: int = 0
    taken_right: int = 0

    @classmethod
    def empty(cls) -> "Tally":
        """Nothing counted."""
        return cls(np.zeros(257, np.int64), np.zeros(257, np.int64))

    def add(self, one: Features, other: Features, moved: Rows, rows: NDArray[np.int64]) -> None:
        """Count two views; keypoints `rows` of the first lie at `moved` (n, 2) in the second."""
        if not len(rows) or other.rows < 2:
            return
        bits = np.bitwise_count(one.descriptor[rows][:, None] ^ other.descriptor[None]).sum(axis=2)
        levels = np.abs(one.octave[rows].astype(int)[:, None] - other.octave[None].astype(int))
        scale = 1.2 ** one.octave[rows].astype(float)[:, None]
        apart = np.linalg.norm(moved[:, None] - other.pixels[None], axis=2)
        right, wrong = (apart < RIGHT * scale) & (levels <= 1), apart > WRONG * scale
        has = right.any(axis=1)
        best = np.where(right, bits, 999).min(axis=1)[has]
        self.true += np.bincount(best, minlength=257)[:257]
        self.wrong += np.bincount(bits[wrong & (levels <= 1)], minlength=257)[:257]
        order = np.argsort(bits, axis=1, kind="stable")[:, :2]
        first = order[:, 0]
        each = np.arange(len(rows))
        hit = ~wrong[each, first]
        taken = (bits[each, first] <= STRICT) & (bits[each, first] < RATIO * bits[each, order[:, 1]])
        self.partnered += int(has.sum())
        self.nearest += int((hit & has).sum())
        self.taken += int(taken.sum())
        self.taken_right += int((taken & hit).sum())

    def facts(self) -> dict[str, float]:
        """Shares: of true matches below the distance of one wrong pair in 200, found as nearest, taken and right."""
        limit = int(np.searchsorted(np.cumsum(self.wrong), 0.005 * self.wrong.sum()))
        return {
            "true_matches": int(self.true.sum()),
            "recall_at_half_percent": round(float(self.true[:limit].sum() / max(self.true.sum(), 1)), 4),
            "nearest": round(self.nearest / max(self.partnered, 1), 4),
            "taken_right": round(self.taken_right / max(self.partnered, 1), 4),
            "precision": round(self.taken_right / max(self.taken, 1), 4),
        }


def extractor_by(pairs: NDArray[np.int8], camera: PinholeCamera) -> FeatureExtractor:
    """Describes by these test pairs."""
    described._test_pairs = lambda: pairs.astype(np.float64)
    described._steered_offsets.cache_clear()
    return FeatureExtractor(camera, FeatureConfig())


def vocabulary_of(folder: Path) -> Vocabulary:
    with np.load(folder / "vocabulary.npz") as stored:
        return Vocabulary(stored["tree"], int(stored["branches"]), stored["rarity"].astype(np.float32))


def read_recording(folder: Path, pairs: Sequence[NDArray[np.int8]]) -> Recording | None:
    """Views of a recording, evenly in time; none where it has no ground truth."""
    source, truth = open_uncalibrated(folder), read_ground_truth(folder)
    if truth is None:
        return None
    extractors = [extractor_by(each, source.camera) for each in pairs]
    recording = Recording(folder.name, source.camera, np.empty((0, 4, 4)), [[] for _ in pairs])
    poses, due = [], -np.inf
    for number, timestamp in enumerate(source.timestamps):
        nearest = int(np.abs(truth.timestamps - timestamp).argmin())
        if timestamp < due or abs(truth.timestamps[nearest] - timestamp) > 0.02:
            continue
        frame = source.frame(number)
        if frame is None:
            continue
        due = timestamp + SPACING
        poses.append(truth.world_from_camera[nearest])
        for views, extractor in zip(recording.views, extractors, strict=True):
            views.append(extractor.extract(frame))
        if len(poses) == MOST_VIEWS:
            break
    return replace(recording, world_from_camera=np.array(poses))


def moved_to(recording: Recording, one: Features, first: int, second: int) -> tuple[Rows, NDArray[np.int64]]:
    """Where keypoints of one view lie in another (n, 2), and which they are."""
    camera, poses = recording.camera, recording.world_from_camera
    rows = np.flatnonzero(one.has_depth)
    z = one.depth[rows].astype(float)
    focal, centre = np.array([camera.fx, camera.fy]), np.array([camera.cx, camera.cy])
    points = np.column_stack([(one.pixels[rows] - centre) / focal * z[:, None], z])
    across = np.linalg.inv(poses[second]) @ poses[first]
    points = points @ across[:3, :3].T + across[:3, 3]
    ahead = points[:, 2] > 0.1
    pixels = points[ahead, :2] / points[ahead, 2:] * focal + centre
    inside = ((pixels > 0) & (pixels < (camera.width, camera.height))).all(axis=1)
    return pixels[inside], rows[ahead][inside]


def match_recording(recording: Recording, own: int) -> Tally:
    """Match views by the test pairs of that number."""
    views, tally = recording.views[own], Tally.empty()
    for beside in BESIDE:
        for first in range(0, len(views) - beside, EVERY):
            tally.add(views[first], views[first + beside], *moved_to(recording, views[first], first, first + beside))
    return tally


def pictures_aside(folder: Path) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.uint8], Rows]]:
    """Two views of each photograph, and the homography between them."""
    rng = np.random.default_rng(7)
    corners = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    for picture in photographed(folder, PICTURES):
        turn = cv2.getRotationMatrix2D((320, 240), float(rng.uniform(-25, 25)), float(rng.uniform(0.8, 1.25)))
        aside = (corners @ turn[:, :2].T + turn[:, 2] + rng.normal(0, 30, (4, 2))).astype(np.float32)
        warp = cv2.getPerspectiveTransform(corners, aside)
        other = cv2.GaussianBlur(cv2.warpPerspective(picture, warp, (640, 480)), (0, 0), float(rng.uniform(0.4, 1.2)))
        noisy = other * rng.uniform(0.6, 1.1) + rng.normal(0, rng.uniform(1, 4), other.shape)
        yield picture, np.clip(noisy, 0, 255).astype(np.uint8), warp


def match_pictures(
    pictures: Sequence[tuple[NDArray[np.uint8], NDArray[np.uint8], Rows]], pairs: NDArray[np.int8]
) -> Tally:
    extractor, tally = extractor_by(pairs, CAMERA), Tally.empty()
    blind = np.zeros((480, 640), np.float32)
    for picture, other, warp in pictures:
        one, two = (extractor.extract(RgbdFrame(0, 0.0, each, blind)) for each in (picture, other))
        moved = cv2.perspectiveTransform(one.pixels[None].astype(np.float64), warp)[0]
        rows = np.flatnonzero(((moved > 20) & (moved < (620, 460))).all(axis=1))
        tally.add(one, two, moved[rows], rows)
    return tally


def same_place(recording: Recording, metres: float, degrees: float) -> NDArray[np.bool_]:
    """(n, n) whether two views are within so many metres and degrees of each other."""
    centres, axes = recording.world_from_camera[:, :3, 3], recording.world_from_camera[:, :3, 2]
    apart = np.linalg.norm(centres[:, None] - centres[None], axis=2)
    return (apart < metres) & (axes @ axes.T > np.cos(np.radians(degrees)))


def find_places(recordings: Sequence[Recording], own: int, vocabulary: Vocabulary) -> dict[str, dict[str, float]]:
    """By recording: how many queries there are, and how often the best is right and one of the best four.

    And the share of pairs of a right and a wrong keyframe of which the right one scores more.
    """
    index, views = PlaceIndex(vocabulary), [each.views[own] for each in recordings]
    starts = np.cumsum([0, *(len(each) for each in views)])
    for keyframe, each in enumerate(view for some in views for view in some):
        index.add(keyframe, each.descriptor)
    found = {}
    for recording, some, (start, end) in zip(recordings, views, pairwise(starts.tolist()), strict=True):
        right, maybe = (same_place(recording, *limits) for limits in (NEAR, PERHAPS))
        ranks, order = [], []
        for query in range(len(some)):
            elsewhere = np.abs(np.arange(len(some)) - query) >= BEYOND
            if not (right[query] & elsewhere).any() or not some[query].rows:
                continue
            eligible, true = np.ones(starts[-1], np.bool_), np.zeros(starts[-1], np.bool_)
            true[start:end] = right[query] & elsewhere
            eligible[start:end] = (right[query] | ~maybe[query]) & elsewhere
            scores = index.query_keyframe(start + query, eligible)
            best, wrong = float(scores[true].max()), scores[eligible & ~true]
            ranks.append(int((wrong >= best).sum()))
            order.append(float((scores[true][:, None] > wrong[None]).mean()))
        if ranks:
            found[recording.name] = {
                "queries": len(ranks),
                "recall_at_1": round(float(np.mean(np.array(ranks) < 1)), 4),
                "recall_at_4": round(float(np.mean(np.array(ranks) < 4)), 4),
                "in_order": round(float(np.mean(order)), 4),
            }
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", type=Path)
    parser.add_argument("--pictures", type=Path, help="photographs, none of which the assets were learned on")
    parser.add_argument("--assets", nargs="*", default=[], metavar="NAME=FOLDER")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    assets = {"ours": OURS, **{name: Path(place) for name, place in (each.split("=", 1) for each in arguments.assets)}}
    loaded = {name: np.load(folder / "test_pairs.npy") for name, folder in assets.items()}
    pairs = list({each.tobytes(): each for each in loaded.values()}.values())
    which = {name: [each.tobytes() for each in pairs].index(own.tobytes()) for name, own in loaded.items()}
    pictures = list(pictures_aside(arguments.pictures)) if arguments.pictures else []
    recordings = [read for folder in arguments.recordings if (read := read_recording(folder, pairs)) is not None]
    seen = [match_pictures(pictures, each).facts() if pictures else {} for each in pairs]
    matched = [{each.name: match_recording(each, own).facts() for each in recordings} for own in range(len(pairs))]
    for name, own in which.items():
        print(json.dumps({"assets": name, "of": "photographs", **seen[own]}), flush=True)
        places = find_places(recordings, own, vocabulary_of(assets[name]))
        for recording in (each.name for each in recordings):
            facts = {**matched[own][recording], **places.get(recording, {})}
            print(json.dumps({"assets": name, "of": recording, **facts}), flush=True)


if __name__ == "__main__":
    main()
