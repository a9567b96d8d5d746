"""Why a path is no recording that can be opened, as far as what lies there tells."""

import zipfile
from collections import Counter
from collections.abc import Callable
from itertools import islice
from pathlib import Path

from lpslam.sources.captures.series import Pictures

_CLOUDS = (".ply", ".pcd", ".las", ".laz", ".xyz", ".e57")
_ZARR = (".zgroup", ".zattrs", ".zmetadata", "zarr.json")
_OTHERS = {
    ".pb": "protobuf messages, which are not read: export pictures, depth of 16 bits and the calibration with their "
    "maker's tools, or record a ROS bag",
    **dict.fromkeys(
        (".pkl", ".pickle"), "pickles, which are programs and are not read: save plain arrays (.npz) or pictures"
    ),
    **dict.fromkeys(
        (".svo", ".svo2"),
        "a ZED recording, which its maker's library alone reads: export it to pictures and depth of 16 bits",
    ),
    ".oni": "an OpenNI recording, which is not read: export it to pictures and depth of 16 bits",
}
_SHOWN = 6
_MOST = 1000
"""Files that are looked at."""


def reason_for(path: Path, inner: list[Path]) -> str:
    """What is wrong with a path, and the remedy, in one line; empty where nothing is known.

    Args:
        path: a file or a folder in no layout that is known.
        inner: recordings that lie in the folder.
    """
    tests: tuple[Callable[[Path], str], ...] = (_of_file,) if path.is_file() else (_of_zarr, _of_pictures, _of_others)
    if len(inner) > 1:
        names = ", ".join(each.name for each in inner[:_SHOWN])
        return f"it holds {len(inner)} recordings ({names}); give one of them; did you mean {inner[0]}?"
    return next((reason for test in tests if (reason := test(path))), "")


def _of_file(path: Path) -> str:
    if path.suffix.lower() == ".npz" and zipfile.is_zipfile(path):
        return (
            "its arrays are objects of Python (pickles), which are programs and are not read, or no pictures; save "
            "plain arrays, one for colour (n, height, width, 3) and one for depth (n, height, width)"
        )
    return ""


def _of_zarr(folder: Path) -> str:
    if not any((folder / name).is_file() for name in _ZARR):
        return ""
    return "it is a store of zarr, which is not read; save its arrays as .npz or HDF5, as xarray's to_netcdf does"


def _of_pictures(folder: Path) -> str:
    pictures = Pictures(folder)
    painted = pictures.painted
    if painted is not None:
        return (
            f"{painted.paths[0].name} and the like are called depth and have eight bits a channel, as a view in false "
            "colours has; export depth of 16 bits, or state in a text how they make a number (“depth = R * 256 + G”)"
        )
    clouds = [path for path in islice(pictures.files, _MOST) if path.suffix.lower() in _CLOUDS]
    if pictures.depth is None and clouds:
        return (
            f"its depth lies in point clouds ({clouds[0].name}), which have no pixels; project them into depth "
            "pictures of 16 bits, one for each colour picture"
        )
    return ""


def _of_others(folder: Path) -> str:
    kinds = Counter(path.suffix.lower() for path in islice(Pictures(folder).files, _MOST))
    kind = next((kind for kind, _ in kinds.most_common() if kind in _OTHERS), None)
    return f"it holds {_OTHERS[kind]}" if kind is not None else ""
