"""Writes a world as a TUM RGB-D folder with its calibration, ground truth, signs and factors."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.poses import StampedPoses
from lpslam.simulation.recording import as_png, camera_fields, recorded
from lpslam.simulation.worlds.factors import EDITION, World
from lpslam.simulation.worlds.source import WorldSource


def write_world(source: WorldSource, folder: Path, on_progress: Callable[[int, int], None] | None = None) -> None:
    """Render every frame into a folder.

    The folder gets `rgb/` (PNG or JPEG, as the world's camera stores pictures), `depth/` (16 bit), `rgb.txt`,
    `depth.txt`, `groundtruth.txt` (TUM format, the camera's optical frame in the world), `camera.yaml` (the calibration
    as stated), `signs.json`, and `world.json`: the factors, the true calibration, and in which frames nothing is seen.

    Args:
        source: the world.
        folder: created if need be.
        on_progress: called with (frames written, frames in all) after each frame.

    Raises:
        UserError: the folder cannot be written.
    """
    with recorded(Path(folder), "worlds") as recording:
        recording.describe(source.camera, source.signs)
        recording.write_json("world.json", _facts(source))
        truth = source.ground_truth
        StampedPoses(truth.timestamps, truth.world_from_camera).to_tum_file(recording.folder / "groundtruth.txt")
        kind = {"png": "png", "jpeg": "jpg"}[source.world.compression]
        for index in range(len(source)):
            rgb, raw = source.exposed(index)
            recording.add("rgb", source.timestamps[index], source.compressed(rgb), kind)
            recording.add("depth", source.depth_timestamps[index], as_png(raw))
            if on_progress is not None:
                on_progress(index + 1, len(source))


def read_world(folder: Path) -> tuple[World, dict[str, Any]]:
    """The factors of a written world, and the whole of its world.json."""
    tree = json.loads((folder / "world.json").read_text(encoding="utf-8"))
    return World.from_json(tree["world"]), tree


def _facts(source: WorldSource) -> dict[str, Any]:
    """world.json."""
    truth = source.ground_truth.world_from_camera
    turned = np.einsum("nij,nij->n", truth[1:, :3, :3], truth[:-1, :3, :3])
    return {
        "edition": EDITION,
        "world": source.world.as_json(),
        "true_camera": camera_fields(source.true_camera),
        "path_metres": round(float(np.linalg.norm(np.diff(truth[:, :3, 3], axis=0), axis=1).sum()), 4),
        "turned_radians": round(float(np.arccos(np.clip((turned - 1) / 2, -1, 1)).sum()), 4),
        "blind": [int(index) for index in np.flatnonzero(source.blind)],
    }
