"""Writes a rendered walk as a TUM RGB-D folder with its calibration, ground truth and signs."""

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.simulation.source import MallSource


def refuse_recording(folder: Path) -> None:
    """Raise a `UserError` if `folder` holds a recording that was not rendered: it could not be made again."""
    if (folder / "rgb.txt").exists() and not (folder / "signs.json").exists():
        raise UserError(f"simulation: {folder} holds a recording that is not overwritten; choose another folder")


def write_sequence(source: MallSource, folder: Path, on_progress: Callable[[int, int], None] | None = None) -> None:
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
    try:
        _write(source, Path(folder), on_progress)
    except OSError as error:
        raise UserError(f"simulation: {folder} cannot be written ({error.strerror}); choose another folder") from error


def _write(source: MallSource, folder: Path, on_progress: Callable[[int, int], None] | None) -> None:
    for name in ("rgb", "depth"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    truth = source.ground_truth
    quaternions = Rotation.from_matrix(truth.world_from_camera[:, :3, :3]).as_quat()
    rows = np.column_stack([truth.timestamps, truth.world_from_camera[:, :3, 3], quaternions])
    lines = [" ".join(f"{value:.6f}" if i == 0 else f"{value:.7f}" for i, value in enumerate(row)) for row in rows]
    write_list(folder / "groundtruth.txt", "timestamp tx ty tz qx qy qz qw", lines)
    (folder / "camera.yaml").write_text(yaml.safe_dump(camera_fields(source.camera), sort_keys=False), encoding="utf-8")
    signs = {"signs": [sign.as_json() for sign in source.signs]}
    (folder / "signs.json").write_text(json.dumps(signs, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    (folder / "readability.csv").write_text("\n".join([_VIEW_COLUMNS, *_view_rows(source)]) + "\n", encoding="utf-8")
    listed: dict[str, list[str]] = {"rgb": [], "depth": []}
    for done, frame in enumerate(source, start=1):
        depth = np.clip(np.rint(frame.depth * source.camera.depth_scale), 0, 65535).astype(np.uint16)
        pictures = {"rgb": cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR), "depth": depth}
        for name, picture in pictures.items():
            file = f"{name}/{frame.timestamp:.6f}.png"
            _write_png(folder / file, picture)
            listed[name].append(f"{frame.timestamp:.6f} {file}")
        if on_progress is not None:
            on_progress(done, len(source))
    for name, entries in listed.items():
        write_list(folder / f"{name}.txt", "timestamp filename", entries)


_VIEW_COLUMNS = "frame,sign,letter_pixels,angle_degrees,distance_m,blur_pixels,seen_share,readable"


def _view_rows(source: MallSource) -> Iterator[str]:
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


def _write_png(path: Path, picture: np.typing.NDArray[np.generic]) -> None:
    # Level 1 is three times as fast as the default at a tenth more size.
    _, encoded = cv2.imencode(".png", np.asarray(picture), [cv2.IMWRITE_PNG_COMPRESSION, 1])
    path.write_bytes(encoded.tobytes())


def write_list(path: Path, header: str, lines: list[str]) -> None:
    """A text file with a heading."""
    path.write_text("\n".join([f"# {header}", *lines]) + "\n", encoding="utf-8")


def camera_fields(camera: PinholeCamera) -> dict[str, float | int | list[float]]:
    """A calibration as camera.yaml holds it."""
    return {
        "width": camera.width,
        "height": camera.height,
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        "distortion": list(camera.distortion),
        "depth_scale": camera.depth_scale,
        "fps": camera.fps,
    }
