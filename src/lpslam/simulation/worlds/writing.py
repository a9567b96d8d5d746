"""Writes a world as a TUM RGB-D folder with its calibration, ground truth, signs and factors."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml

from lpslam.errors import UserError
from lpslam.poses import StampedPoses
from lpslam.simulation.worlds.factors import EDITION, World
from lpslam.simulation.worlds.source import WorldSource
from lpslam.simulation.writer import camera_fields, write_list


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
    try:
        _write(source, Path(folder), on_progress)
    except OSError as error:
        raise UserError(f"worlds: {folder} cannot be written ({error.strerror}); choose another folder") from error


def read_world(folder: Path) -> tuple[World, dict[str, Any]]:
    """The factors of a written world, and the whole of its world.json."""
    tree = json.loads((folder / "world.json").read_text(encoding="utf-8"))
    return World.from_json(tree["world"]), tree


def _write(source: WorldSource, folder: Path, on_progress: Callable[[int, int], None] | None) -> None:
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    truth = source.ground_truth
    StampedPoses(truth.timestamps, truth.world_from_camera).to_tum_file(folder / "groundtruth.txt")
    camera = yaml.safe_dump(camera_fields(source.camera), sort_keys=False)
    (folder / "camera.yaml").write_text(camera, encoding="utf-8")
    _write_json(folder / "signs.json", {"signs": [sign.as_json() for sign in source.signs]})
    _write_json(folder / "world.json", _facts(source))
    listed: dict[str, list[str]] = {"rgb": [], "depth": []}
    suffix = {"png": "png", "jpeg": "jpg"}[source.world.compression]
    for index in range(len(source)):
        rgb, raw = source.exposed(index)
        _, depth = cv2.imencode(".png", raw, [cv2.IMWRITE_PNG_COMPRESSION, 1])
        stamps = {"rgb": source.timestamps[index], "depth": source.depth_timestamps[index]}
        for name, data, kind in (("rgb", source.compressed(rgb), suffix), ("depth", depth.tobytes(), "png")):
            file = f"{name}/{stamps[name]:.6f}.{kind}"
            (folder / file).write_bytes(data)
            listed[name].append(f"{stamps[name]:.6f} {file}")
        if on_progress is not None:
            on_progress(index + 1, len(source))
    for name, entries in listed.items():
        write_list(folder / f"{name}.txt", "timestamp filename", entries)


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


def _write_json(path: Path, tree: dict[str, Any]) -> None:
    path.write_text(json.dumps(tree, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
