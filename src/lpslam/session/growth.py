"""How far a map has grown, for whoever watches it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class Growth:
    """A growing map at one moment; nothing in it changes later.

    Attributes:
        poses: (n, 4, 4) `world_from_camera` of all tracked frames, in order of time.
        keyframes: `world_from_keyframe`, 4×4, of the keyframes that have a scan and a place in the map frame.
        scans: new scans, as `Scans.to_arrays` gives them.
    """

    poses: NDArray[np.float64]
    keyframes: Mapping[int, NDArray[np.float64]]
    scans: Mapping[str, NDArray[Any]]
