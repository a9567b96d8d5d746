"""Folders of colour and depth images: Redwood's and Open3D's color/ and depth/, or rgb/ and depth/ of equal names.

Open3D's layout: http://www.open3d.org/docs/release/tutorial/reconstruction_system/capture_your_own_dataset.html
"""

from pathlib import Path

from lpslam.camera import PinholeCamera
from lpslam.errors import UserError
from lpslam.sources.calibration import Calibration, read_calibration
from lpslam.sources.captures.common import RATE, numbered
from lpslam.sources.image_pairs import ImagePair, ImagePairSource, first_image_size
from lpslam.sources.tum import CAMERA_FILES

_COLOURS, _DEPTHS = (".jpg", ".jpeg", ".png"), (".png", ".tif", ".tiff")
_MILLIMETRES = 1000.0


def open_capture(folder: Path, camera_file: Path | None, max_frames: int | None, *, nominal: bool) -> ImagePairSource:
    """Open the pair of folders; images of equal number belong together, the n-th is taken at n / 30 s.

    Raises:
        UserError: there are no pairs, or no calibration.
    """
    colours = numbered(next(path for path in (folder / "color", folder / "rgb") if path.is_dir()), _COLOURS)
    depths = numbered(folder / "depth", _DEPTHS)
    if not colours or not depths:
        raise UserError(f"{folder}: its folders hold no images with numbers in their names")
    if not colours.keys() & depths.keys():
        raise UserError(f"{folder}: no image of depth/ has the number of one of {colours[min(colours)].parent.name}/")
    pairs = [
        ImagePair(
            (number - min(colours)) / RATE,
            path,
            depths.get(number),
            "" if number in depths else f"{path.name} has no depth image of its number",
        )
        for number, path in sorted(colours.items())
    ]
    size = first_image_size(list(colours.values()))
    calibration = _calibration(folder, camera_file, size, nominal)
    return ImagePairSource(
        folder.resolve().name,
        calibration.camera,
        pairs,
        notes=(*calibration.notes, f"its images carry no times: {RATE:g} a second are taken"),
        displacement=calibration.displacement,
        may_displace=nominal,
        max_frames=max_frames,
    )


def _calibration(folder: Path, camera_file: Path | None, size: tuple[int, int] | None, nominal: bool) -> Calibration:
    own = camera_file or next((folder / name for name in CAMERA_FILES if (folder / name).is_file()), None)
    if own is not None:
        return read_calibration(own, image_size=size, default_depth_scale=_MILLIMETRES)
    width, height = size or (640, 480)
    if folder.joinpath("color").is_dir() or nominal:
        # Redwood's recordings state none: PrimeSense's factory values, as Open3D takes them too.
        focal, note = 525.0 * width / 640, "no calibration: PrimeSense's focal length 525 at 640 pixels is used"
        middle = (width - 1) / 2, (height - 1) / 2
        return Calibration(PinholeCamera(width, height, focal, focal, *middle, depth_scale=_MILLIMETRES), (note,))
    raise UserError(f"{folder} has no {CAMERA_FILES[0]}; give its calibration with --camera FILE")
