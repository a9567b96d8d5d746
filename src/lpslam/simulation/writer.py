"""Writes a rendered walk as a TUM RGB-D folder with its calibration, ground truth and signs."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from lpslam.errors import UserError
from lpslam.simulation.recording import as_png, recorded, write_list
from lpslam.simulation.source import WalkSource
from lpslam.whole_files import refuse_unwritable_folder


def refuse_recording(folder: Path) -> None:
    """Raise a `UserError` if `folder` holds anything, or can hold nothing: two recordings would mix."""
    if folder.is_dir() and any(folder.iterdir()):
        raise UserError(f"simulation: {folder} is not empty, and is not overwritten; choose another folder")
    refuse_unwritable_folder(folder, "simulation")


def write_sequence(source: WalkSource, folder: Path, on_progress: Callable[[int, int], None] | None = None) -> None:
    """Render every frame into a folder.

    The folder gets `rgb/`, `depth/` (16 bit, 5000 a metre), `rgb.txt`, `depth.txt`, `groundtruth.txt` (TUM format, the
    camera's optical frame in the world), `camera.yaml`, `signs.json` and `readability.csv`: how each sign is seen in
    every frame that shows some of it.

    Args:
        source: the walk.
        folder: created if need be.
        on_progress: called with (frames written, frames in all) after each frame.

    Raises:
        UserError: the folder cannot be written.
    """
    with recorded(Path(folder), "simulation") as recording:
        recording.describe(source.camera, source.signs)
        write_list(recording.folder / "groundtruth.txt", "timestamp tx ty tz qx qy qz qw", _true_path(source))
        readability = "\n".join([_VIEW_COLUMNS, *_view_rows(source)]) + "\n"
        (recording.folder / "readability.csv").write_text(readability, encoding="utf-8")
        for done, frame in enumerate(source, start=1):
            depth = np.clip(np.rint(frame.depth * source.camera.depth_scale), 0, 65535).astype(np.uint16)
            recording.add("rgb", frame.timestamp, as_png(cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR)))
            recording.add("depth", frame.timestamp, as_png(depth))
            if on_progress is not None:
                on_progress(done, len(source))


def _true_path(source: WalkSource) -> list[str]:
    """A line for each pose."""
    truth = source.ground_truth
    quaternions = Rotation.from_matrix(truth.world_from_camera[:, :3, :3]).as_quat()
    rows = np.column_stack([truth.timestamps, truth.world_from_camera[:, :3, 3], quaternions])
    return [" ".join(f"{value:.6f}" if i == 0 else f"{value:.7f}" for i, value in enumerate(row)) for row in rows]


_VIEW_COLUMNS = "frame,sign,letter_pixels,angle_degrees,distance_m,blur_pixels,seen_share,readable"


def _view_rows(source: WalkSource) -> Iterator[str]:
    """A line for each frame and sign that it shows some of."""
    views = source.sign_views
    readable = [each.readable() for each in views]
    for frame in range(len(source)):
        for sign, each in zip(source.signs, views, strict=True):
            if each.seen_share[frame] > 0:
                yield (
                    f"{frame},{sign.id},{each.letter_pixels[frame]:.1f},{math.degrees(each.angle[frame]):.1f},"
                    f"{each.distance[frame]:.2f},{each.blur_pixels[frame]:.1f},{each.seen_share[frame]:.2f},"
                    f"{int(readable[sign.id][frame])}"
                )
