"""Replica as NICE-SLAM rendered it: results/frame000000.jpg, depth000000.png, and cam_params.json beside the scenes.

The layout: https://github.com/cvg/nice-slam#replica-1
"""

import json
from pathlib import Path

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.calibration import read_calibration
from lpslam.sources.captures.common import RATE, numbered
from lpslam.sources.image_pairs import ImagePair, ImagePairSource, first_image_size

_SCALE = 6553.5


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ImagePairSource:
    """Open a scene's folder; frame n is taken at n / 30 s.

    Raises:
        UserError: the calibration is malformed.
    """
    colours, depths = numbered(folder / "results", (".jpg",)), numbered(folder / "results", (".png",))
    pairs = [
        ImagePair(
            number / RATE, path, depths.get(number), "" if number in depths else f"{path.name} has no depth image"
        )
        for number, path in sorted(colours.items())
    ]
    camera, notes = _camera(folder, camera_file, first_image_size(list(colours.values())))
    return ImagePairSource(folder.resolve().name, camera, pairs, notes=notes, max_frames=max_frames)


def _camera(
    folder: Path, camera_file: Path | None, size: tuple[int, int] | None
) -> tuple[PinholeCamera, tuple[str, ...]]:
    if camera_file is not None:
        calibration = read_calibration(camera_file, image_size=size, default_depth_scale=_SCALE)
        return calibration.camera, calibration.notes
    path = next((place / "cam_params.json" for place in (folder, folder.resolve().parent)
                 if (place / "cam_params.json").is_file()), None)  # fmt: skip
    if path is None:
        camera = PinholeCamera(1200, 680, 600.0, 600.0, 599.5, 339.5, depth_scale=_SCALE)
        return camera, ("no cam_params.json: Replica's own calibration is used",)
    try:
        tree = json.loads(text_of(path))["camera"]
        width, height = int(tree["w"]), int(tree["h"])
        fx, fy, cx, cy = (float(tree[name]) for name in ("fx", "fy", "cx", "cy"))
        return PinholeCamera(width, height, fx, fy, cx, cy, depth_scale=float(tree.get("scale", _SCALE))), ()
    except (ValueError, OverflowError, KeyError, TypeError, RecursionError) as error:
        raise UserError(f"{path} is no calibration of Replica (camera: w, h, fx, fy, cx, cy, scale)") from error
