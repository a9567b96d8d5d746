"""A map as the page has it: numbers and strings, whatever signs say cleaned."""

import base64
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import PageConfig, RoomConfig
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.export import corrections_record
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.pictures import ground_picture, picture_of
from lpslam.page.points import PackedPoints, filled_cloud, packed_points
from lpslam.poses import quaternions_from_rotations
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.remembering.histories import score_histories
from lpslam.text.remembering.memory import LongShortTermMemory
from lpslam.text.types import Landmark

Array = NDArray[np.float64]

_MOST_POSES, _MOST_VARIANTS = 2000, 8
_USUAL_RATE = 30.0  # frames a second
_ROOM_TO_FILL = 2  # between readings, where there may be so many times as many points
_GREY = 150
_MOST_CLASSES, _MOST_SAMPLES = 150, 120  # histories of classes, and samples of each


def map_record(world: LanguageMap, config: RoomConfig | None = None, *, soon: bool = False) -> dict[str, Any]:
    """What is shown of a map at once; its picture is made soon rather than small where somebody waits."""
    drawn = picture_of(*world.room_from_above(config), None, config, compression=3 if soon else 9)
    poses = world.frame_poses()
    return {
        "title": clean_text(world.source) or "lpslam",
        "picture": "" if drawn is None else _png(drawn.png),
        "picture_extent": None if drawn is None else [round(each, 3) for each in drawn.extent],
        "lens": lens_record(world.camera),
        "trajectory": way_record(poses.world_from_camera, poses.timestamps),
        "memory": memory_record(world.text.memory),
        **said_record(world),
    }


def ground_record(world: LanguageMap) -> dict[str, Any] | None:
    """The ground below the map; None where no floor was seen."""
    grid = world.grid()
    ground = None if grid is None else ground_picture(grid)
    if ground is None:
        return None
    return {"picture": _png(ground.png), "extent": _rounded(np.array(ground.extent)), "height": round(ground.height, 3)}


def room_points(world: LanguageMap, most: int, config: PageConfig) -> PackedPoints:
    """What keyframes saw of the room, as points; where nothing was kept of that, the map's own points in grey."""
    points, colours = world.coloured_cloud()
    if world.scans is not None and len(points) * _ROOM_TO_FILL < most:
        points, colours = filled_cloud(world.scans, world.pose_of_scan)
    if not len(points):
        points = world.cloud()
        colours = np.full((len(points), 3), _GREY, np.uint8)
    return packed_points(points, colours, most, config)


def lens_record(camera: PinholeCamera) -> list[float]:
    """Width and height of a picture, and fx, fy, cx and cy, all in pixels."""
    return _rounded(np.array([camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy]))


def _png(content: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(content).decode("ascii")


def memory_record(memory: LongShortTermMemory) -> dict[str, Any]:
    """How the scores of classes rose and faded: those that were strongest, thinned."""
    known = [each for each in score_histories(memory) if each.samples]
    known.sort(key=lambda each: (not each.is_long_term, -max(score for _, score in each.samples)))
    histories = [
        {
            "id": each.id,
            "name": clean_text(each.name),
            "kept": each.is_long_term,
            "samples": [_rounded(np.array(at)) for at in _thinned(each.samples)],
        }
        for each in known[:_MOST_CLASSES]
    ]
    return {"promotion": memory.config.promotion, "histories": histories}


def _thinned(samples: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """A few samples of a history: its ends, and of each stretch between them the highest and the lowest."""
    if len(samples) <= _MOST_SAMPLES:
        return list(samples)
    kept = {0, len(samples) - 1}
    for rows in np.array_split(np.arange(len(samples)), _MOST_SAMPLES // 2):
        scores = [samples[row][1] for row in rows]
        kept |= {int(rows[int(np.argmax(scores))]), int(rows[int(np.argmin(scores))])}
    return [samples[row] for row in sorted(kept)]


def said_record(world: LanguageMap) -> dict[str, Any]:
    """The signs of a map, by which question they are judged, and what a person has said of them."""
    return {
        "signs": sign_records(world.landmarks()),
        "question": world.text.question,
        "edits": corrections_record(world.text.corrections),
    }


def empty_record(title: str) -> dict[str, Any]:
    """The same of a map of which nothing is known yet."""
    return {
        "title": clean_text(title) or "lpslam",
        "picture": "",
        "picture_extent": None,
        "lens": None,
        "trajectory": [],
        "memory": None,
        "signs": [],
        "question": None,
        "edits": corrections_record(Corrections()),
    }


def way_record(world_from_camera: Array, timestamps: Array | None = None) -> list[list[float]]:
    """The camera's way, thinned: x, y and z in metres, its turn as x, y, z and w, and seconds since the first.

    Args:
        world_from_camera: (n, 4, 4), in order of time.
        timestamps: (n,) seconds; without, frames are told as many to a second as cameras usually give.
    """
    times = np.arange(len(world_from_camera)) / _USUAL_RATE if timestamps is None else timestamps
    known = np.isfinite(world_from_camera).all(axis=(1, 2))
    poses, times = world_from_camera[known], times[known]
    step = max(1, -(-len(poses) // _MOST_POSES))
    poses, times = poses[::step], times[::step]
    turns = quaternions_from_rotations(poses[:, :3, :3])
    return [
        [*_rounded(pose[:3, 3]), *(round(float(each), 4) for each in turn), round(float(at - times[0]), 2)]
        for pose, turn, at in zip(poses, turns, times, strict=True)
    ]


def sign_records(marks: Iterable[Landmark]) -> list[dict[str, Any]]:
    """The landmarks that have a place."""
    return [_sign(mark) for mark in marks if np.isfinite(mark.position).all()]


def _sign(mark: Landmark) -> dict[str, Any]:
    counted = sorted(mark.variants.items(), key=lambda each: (-each[1], each[0]))
    return {
        "id": mark.id,
        "name": clean_text(mark.name),
        "lines": [clean_text(line.text) for line in mark.lines],
        "variants": {clean_text(text): int(count) for text, count in counted[:_MOST_VARIANTS]},
        "position": _rounded(mark.position),
        "normal": _rounded(np.nan_to_num(mark.normal)),
        "width": round(float(np.nan_to_num(mark.width)), 3),
        "height": round(float(np.nan_to_num(mark.height)), 3),
        "spread": round(float(np.nan_to_num(mark.spread)), 3),
        "observations": int(mark.observations),
        "confidence": round(float(np.nan_to_num(mark.confidence)), 3),
        "is_landmark": mark.is_landmark,
        "corrections": [each.number for each in mark.corrections],
    }


def _rounded(values: Array) -> list[float]:
    return [round(float(value), 3) for value in values]
