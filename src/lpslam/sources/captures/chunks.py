"""What PNG files say of themselves in chunks of text: a calibration, units, and when each was taken."""

import json
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from lpslam.sources.clocks import in_seconds
from lpslam.sources.inside import Inside, PictureFile
from lpslam.sources.yaml_tree import Tree, lower

_LONGEST, _MOST = 1 << 16, 64
"""Letters of a chunk, and chunks of a picture."""
_TIMES = ("timestamp", "time", "stamp", "creation time")


def tree_in(picture: PictureFile) -> Tree:
    """What a picture's chunks of text state, under lower-case keys; empty of what is no PNG."""
    tree: Tree = {}
    for key, value in _texts(picture).items():
        try:
            found = json.loads(value)
            tree[key] = lower(found) if isinstance(found, dict) else found
        except (ValueError, RecursionError):
            tree[key] = value
    return tree


def times_in_chunks(pictures: Sequence[PictureFile]) -> NDArray[np.float64] | None:
    """Seconds (n,) that each picture's chunks state; None where one does not."""
    name = next((name for name in _TIMES if name in _texts(pictures[0])), None)
    if name is None:
        return None
    try:
        stamps = np.array([float(_texts(picture)[name]) for picture in pictures])
    except (KeyError, ValueError):
        return None
    return in_seconds(stamps)[0] if np.isfinite(stamps).all() else None


def _texts(picture: PictureFile) -> dict[str, str]:
    if isinstance(picture, Inside) or picture.suffix.lower() != ".png":
        return {}
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            # Only what stands before the pixels is read.
            with Image.open(Path(str(picture))) as image:
                found = list(image.info.items())[:_MOST]
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        return {}
    return {str(key).lower(): value for key, value in found if isinstance(value, str) and len(value) <= _LONGEST}
