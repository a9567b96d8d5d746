"""Whether depth pictures are depth: what a plane looks like in them, and whether their upper bits are flags.

A plane's inverse depth is linear in the pixels, and its depth is not. So patches that are planes tell depth from its
inverse, whatever the units and the focal length. And a difference between neighbours that is a power of two, again and
again, is none of depth.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import EncodingCheckConfig
from lpslam.errors import UserError
from lpslam.sources.depths.encoding import DepthEncoding

Depth = NDArray[np.float32]
_SIDE = 12
"""Points along a patch's side that are looked at."""
_BITS = (12, 13, 14, 15)
"""What is depth where upper bits of sixteen are something else."""


class _Sampled(Protocol):
    """A recording whose depth can be looked at."""

    encoding: DepthEncoding | None

    @property
    def name(self) -> str: ...

    @property
    def camera(self) -> PinholeCamera: ...

    def sample_depths(self, count: int) -> list[Depth]: ...


def refuse_other_encodings(source: _Sampled, config: EncodingCheckConfig) -> None:
    """Raise a `UserError` where depth is something else, as its planes and its steps tell."""
    depths = source.sample_depths(config.frames)
    encoding = source.encoding
    scale = np.float32(source.camera.depth_scale)
    bits = None if encoding is not None else flag_bits([depth * scale for depth in depths], config)
    if bits is not None:
        raise UserError(
            f"{source.name}: the upper {16 - bits} bits of its depth are none (neighbours differ by {1 << bits} again "
            f"and again): state it in a text beside (“depth: lower {bits} bits”), or write depth without them"
        )
    if not looks_inverse(depths, config):
        return
    if encoding is not None and encoding.numerator is not None:
        raise UserError(f"{source.name}: its depth is stated to be inverse, and its planes are none then; state depth")
    raise UserError(
        f"{source.name}: planes are planes in its depth only if that is inverse (1/m, or disparity): state it in a "
        "text (“inverse_depth_scale: 16384”: the number by which a value is divided to be 1/m), or write depth"
    )


def looks_inverse(depths: Sequence[Depth], config: EncodingCheckConfig) -> bool:
    """Whether patches that are planes are so as inverse depth, frame by frame (h, w) in any unit."""
    votes = np.array([_votes(depth, config) for depth in depths]).reshape(-1, 2).sum(axis=0)
    return bool(votes[1] >= config.least_patches and votes[1] >= config.majority * votes[0])


def flag_bits(depths: Sequence[Depth], config: EncodingCheckConfig) -> int | None:
    """How many of the lowest bits of raw numbers are depth, where the upper ones are flags; None where they are not."""
    steps = np.concatenate([_steps(depth) for depth in depths]) if depths else np.zeros(0)
    shares: dict[int, float] = {}
    for bits in _BITS:
        large = steps[steps > (1 << bits) / 2]
        off = np.abs((large + (1 << (bits - 1))) % (1 << bits) - (1 << (bits - 1)))
        if len(large) >= config.least_steps:
            shares[bits] = float((off < config.step_share * (1 << bits)).mean())
    most = max(shares.values(), default=0.0)
    # Steps of a flag are steps of those below it too.
    return max(bits for bits in shares if shares[bits] > 0.9 * most) if most > config.most_by_chance else None


def _votes(depth: Depth, config: EncodingCheckConfig) -> tuple[int, int]:
    """Patches that are planes as depth, and as its inverse."""
    patches = _patches(depth, config.patches)
    if not len(patches):
        return 0, 0
    across, down = np.meshgrid(np.linspace(-0.5, 0.5, _SIDE), np.linspace(-0.5, 0.5, _SIDE))
    plane = np.stack([across.ravel(), down.ravel(), np.ones(_SIDE**2)], axis=1)
    onto = plane @ np.linalg.pinv(plane)
    level = patches / np.median(patches, axis=1, keepdims=True)
    as_inverse = np.median(np.abs(level @ onto.T / level - 1), axis=1)
    fitted = (1 / level) @ onto.T
    as_depth = np.median(np.abs(fitted * level - 1), axis=1)
    slope = np.ptp(level @ onto.T, axis=1)
    is_plane = (np.minimum(as_depth, as_inverse) < config.planar) & (slope > config.least_slope)
    ratio = (as_inverse + config.noise) / (as_depth + config.noise)
    return int((is_plane & (ratio > config.clear)).sum()), int((is_plane & (ratio < 1 / config.clear)).sum())


def _patches(depth: Depth, count: int) -> NDArray[np.float64]:
    """Points (n, side²) of overlapping patches, so many across the picture, that have depth everywhere."""
    height, width = depth.shape
    side = width // count
    if side < _SIDE or height < side:
        return np.zeros((0, _SIDE**2))
    inner = np.linspace(0, side - 1, _SIDE).astype(int)
    rows, columns = (np.arange(0, size - side + 1, max(side // 2, 1)) for size in (height, width))
    at_rows = (rows[:, None] + inner)[:, None, :, None]
    at_columns = (columns[:, None] + inner)[None, :, None, :]
    found = np.asarray(depth, np.float64)[at_rows, at_columns].reshape(-1, _SIDE**2)
    kept: NDArray[np.float64] = found[(found > 0).all(axis=1) & np.isfinite(found).all(axis=1)]
    return kept


def _steps(depth: Depth) -> NDArray[np.float64]:
    """Differences between neighbours that both have a reading."""
    raw = np.asarray(depth, np.float64)
    pairs = [(raw[:, 1:], raw[:, :-1]), (raw[1:], raw[:-1])]
    found = [np.abs(one - other)[(one > 0) & (other > 0)] for one, other in pairs]
    return np.asarray(np.concatenate(found), np.float64)
