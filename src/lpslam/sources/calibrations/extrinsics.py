"""Where the colour camera stands beside the depth camera, by a key that says which way its matrix leads."""

import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from lpslam.sources.yaml_tree import Tree

_COLOUR_FROM_DEPTH = re.compile(r"(?:t_)?(?:colou?r|rgb)_(?:from_)?depth|depth_?(?:to|2)_?(?:colou?r|rgb)|d2c")
_DEPTH_FROM_COLOUR = re.compile(r"(?:t_)?depth_(?:from_)?(?:colou?r|rgb)|(?:colou?r|rgb)_?(?:to|2)_?depth|c2d")
_FARTHEST = 1.0
"""Metres between two cameras of one device: a larger number is of millimetres."""
_MILLIMETRES = 1000.0
_ROTATION_ERROR = 1e-2


def transform_between(trees: Iterable[Tree]) -> NDArray[np.float64] | None:
    """The 4×4 colour_from_depth that one of the mappings states, metres; None where none does."""
    for tree in trees:
        for key, value in tree.items():
            for pattern, is_inverse in ((_COLOUR_FROM_DEPTH, False), (_DEPTH_FROM_COLOUR, True)):
                transform = _transform(value) if pattern.search(key) else None
                if transform is not None:
                    return np.asarray(np.linalg.inv(transform), np.float64) if is_inverse else transform
    return None


def _transform(value: object) -> NDArray[np.float64] | None:
    """4×4 of a matrix, flat or by rows, or of a mapping with a rotation and a translation; None of anything else."""
    transform = np.eye(4)
    try:
        if isinstance(value, dict):
            rotation, translation = (
                next((value[key] for key in value if key.startswith(begin)), None) for begin in ("r", "t")
            )
            transform[:3, :3] = np.array(rotation, np.float64).reshape(3, 3)
            transform[:3, 3] = np.array(translation, np.float64).reshape(3)
        else:
            flat = np.array(value, np.float64).ravel()
            transform[:3] = flat[:12].reshape(3, 4) if flat.size in (12, 16) else np.nan
    except (ValueError, TypeError):
        return None
    rotation = transform[:3, :3]
    if not np.isfinite(transform).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROTATION_ERROR:
        return None
    if np.abs(transform[:3, 3]).max() > _FARTHEST:
        transform[:3, 3] /= _MILLIMETRES
    return transform if np.abs(transform[:3, 3]).max() <= _FARTHEST else None
