"""Expected signs and wrong landmarks, each drawn into the frame that shows it best."""

import csv
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.evaluation.landmarks import LandmarkScore
from lpslam.evaluation.signs import TrueSign
from lpslam.frames import RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.types import Landmark
from lpslam.views.overlay import draw_boxes
from slam_recordings import Recording

Array = NDArray[np.float64]
COLUMNS, ROWS = 3, 4  # pictures a sheet
UP = np.array([0.0, 0.0, 1.0])
FARTHEST = 8.0  # metres at which a landmark is drawn


def draw_signs(
    out: Path, recording: Recording, world: LanguageMap, signs: Sequence[TrueSign], score: LandmarkScore
) -> None:
    """Write sheets OUT-1.png and so on: landmarks that are right in green, wrong ones in yellow, signs in white."""
    marks = world.landmarks()
    wrong = {stray.landmark for stray in score.strays}
    two_sided = {sign.id for sign in signs if sign.double_sided}
    from_both_sides = {match.landmark for match in score.matches if match.sign in two_sided}
    best = _best_frames(recording.folder)
    missed = {sign.id for sign in score.misses}
    wanted = [
        (best[sign.id], f"{'MISSED ' if sign.id in missed else ''}{sign.text}")
        for sign in signs
        if sign.id in best and (sign.id in missed or (sign.readable_frames or 0) >= 10)
    ]
    for mark in marks:
        if mark.id in wrong:
            seen = [each for c in world.text.long_term for each in c.observations if each.text in mark.variants]
            if seen:
                largest = max(seen, key=lambda each: each.letter_height)
                wanted.append((largest.frame, f"WRONG {mark.name}"))
    frames = _frames(recording, {index for index, _ in wanted})
    poses = world.frame_poses()
    tiles = []
    for index, title in wanted:
        frame = frames[index]
        row = int(np.abs(poses.timestamps - frame.timestamp).argmin())
        pose = poses.world_from_camera[row]
        seen_marks = [
            mark for mark in marks if mark.id in from_both_sides or (pose[:3, 3] - mark.position) @ mark.normal > 0
        ]
        picture = _with_landmarks(frame, world.camera, pose, seen_marks, wrong)
        _outline(picture, world.camera, recording, frame, signs)
        tiles.append(_titled(picture, f"{title} #{index}"))
    for sheet in range(0, len(tiles), COLUMNS * ROWS):
        some = tiles[sheet : sheet + COLUMNS * ROWS]
        some += [np.zeros_like(some[0])] * (-len(some) % COLUMNS)
        rows = [np.hstack(some[i : i + COLUMNS]) for i in range(0, len(some), COLUMNS)]
        path = out.with_name(f"{out.name}-{sheet // (COLUMNS * ROWS) + 1}.png")
        cv2.imwrite(str(path), cv2.cvtColor(np.vstack(rows), cv2.COLOR_RGB2BGR))


def _best_frames(folder: Path) -> dict[int | str, int]:
    """The frame in which each sign is seen best: readable if any is, then with the largest letters."""
    best: dict[int | str, tuple[int, float, int]] = {}
    try:
        with (folder / "readability.csv").open(encoding="utf-8") as file:
            for row in csv.DictReader(file):
                sign = int(row["sign"])
                rank = (int(row["readable"]), float(row["letter_pixels"]) * float(row["seen_share"]), int(row["frame"]))
                best[sign] = max(best.get(sign, (0, 0.0, 0)), rank)
    except FileNotFoundError:
        return {}
    return {sign: frame for sign, (_, _, frame) in best.items()}


def _frames(recording: Recording, indices: set[int]) -> dict[int, RgbdFrame]:
    found = {}
    for frame in recording.open():
        if frame.index in indices:
            found[frame.index] = frame
        if len(found) == len(indices):
            break
    return found


def _with_landmarks(
    frame: RgbdFrame, camera: PinholeCamera, world_from_camera: Array, marks: Sequence[Landmark], wrong: set[int]
) -> NDArray[np.uint8]:
    boxes, kept, labels = [], [], []
    for mark in marks:
        corners = transform_points(inverse_transform(world_from_camera), _corners(mark))
        if not 0.3 < corners[:, 2].min() < FARTHEST:
            continue
        box = camera.project(corners)
        u, v = np.rint(box.mean(axis=0)).astype(int)
        if not (0 <= u < camera.width and 0 <= v < camera.height):
            continue
        # What the frame shows nearer than the landmark hides it.
        if 0 < frame.depth[v, u] < 0.9 * corners[:, 2].mean():
            continue
        boxes.append(box)
        kept.append(mark.id not in wrong)
        labels.append(mark.name)
    return draw_boxes(frame.rgb, np.array(boxes).reshape(-1, 4, 2), kept, labels)


def _corners(mark: Landmark) -> Array:
    right = np.cross(UP, mark.normal)
    right /= max(float(np.linalg.norm(right)), 1e-9)
    down = np.cross(right, mark.normal)
    sides = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    return np.array([mark.position + (a * mark.width * right + b * mark.height * down) / 2 for a, b in sides])


def _outline(
    picture: NDArray[np.uint8], camera: PinholeCamera, recording: Recording, frame: RgbdFrame, signs: Sequence[TrueSign]
) -> None:
    """Draw the true ink of every line, whether it is hidden or not, with the true pose."""
    truth = recording.truth
    pose = truth.world_from_camera[np.abs(truth.timestamps - frame.timestamp).argmin()]
    for sign in signs:
        if sign.normal is None or np.linalg.norm(pose[:3, 3] - np.array(sign.centre)) > FARTHEST:
            continue
        facing = (pose[:3, 3] - np.array(sign.centre)) @ np.array(sign.normal)
        if facing < 0 and not sign.double_sided:
            continue
        right = np.cross(UP, sign.normal)
        for line in sign.lines:
            sides = ((-1, 1), (1, 1), (1, -1), (-1, -1))
            corners = np.array(
                [np.array(line.centre) + (a * line.width * right + b * line.height * UP) / 2 for a, b in sides]
            )
            seen = transform_points(inverse_transform(pose), corners)
            if seen[:, 2].min() > 0.3:
                cv2.polylines(picture, [np.rint(camera.project(seen)).astype(np.int32)], True, (255, 255, 255), 1)


def _titled(picture: NDArray[np.uint8], title: str) -> NDArray[np.uint8]:
    strip = np.full((24, picture.shape[1], 3), 30, np.uint8)
    box = np.array([[2.0, 20.0], [3.0, 20.0], [3.0, 21.0], [2.0, 21.0]])
    return np.vstack([draw_boxes(strip, box[None], [not title.startswith(("MISSED", "WRONG"))], [title]), picture])
