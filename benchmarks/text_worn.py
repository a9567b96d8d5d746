"""Photographs of boards as others would have taken them: from elsewhere, in other light, less sharp, farther away."""

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.simulation.boards.labels import LabelledBoard
from lpslam.simulation.boards.street import width_of

SIZE = (0.75, 1.15)  # of the board's own width: a smaller one is seen from farther away
ASLANT = 0.06  # of a side, at most, by which a corner is moved inwards
LIGHT = (0.4, 1.05)  # of the photograph's own, at either end of the board
CAST = (0.85, 1.0)  # of each channel
BLUR = (0.0, 0.003)  # metres, sigma
GRAIN = 4.0  # grey values, at most


def worn(board: LabelledBoard, rng: np.random.Generator) -> LabelledBoard:
    """Draw one look of a board."""
    width = width_of(board) * float(rng.uniform(*SIZE))
    image = _aslant(board.image, rng).astype(np.float32)
    sigma = float(rng.uniform(*BLUR)) / width * image.shape[1]
    if sigma > 0.3:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), sigma), np.float32)
    ends = rng.uniform(*LIGHT, 2)
    image *= np.linspace(*ends, image.shape[1], dtype=np.float32)[None, :, None] * rng.uniform(*CAST, 3)
    image += rng.normal(0.0, rng.uniform(0.0, GRAIN), image.shape)
    return replace(board, image=np.clip(image, 0, 255).astype(np.uint8), width=width)


def looks(boards: Sequence[LabelledBoard], count: int) -> list[list[LabelledBoard]]:
    """So many looks of every board, each time in another order."""
    drawn = []
    for look in range(count):
        rng = np.random.default_rng([look, 61])
        drawn.append([worn(boards[row], rng) for row in rng.permutation(len(boards)).tolist()])
    return drawn


def interval(
    stated: NDArray[np.float64], exact: NDArray[np.bool_], photographs: Sequence[str], draws: int = 2000
) -> tuple[float, float, float]:
    """Error of certainty with every photograph counted once: as measured, and what 95 % of resamplings lie between.

    Photographs are drawn, not lines: lines of one photograph, and looks of it, are right and wrong together.
    """
    names = sorted(set(photographs))
    rows = [np.flatnonzero(np.array(photographs) == name) for name in names]
    rng = np.random.default_rng(0)
    errors = [_error(stated, exact, [rows[k] for k in rng.integers(len(rows), size=len(rows))]) for _ in range(draws)]
    low, high = np.quantile(errors, [0.025, 0.975])
    return _error(stated, exact, rows), float(low), float(high)


def _error(stated: NDArray[np.float64], exact: NDArray[np.bool_], rows: Sequence[NDArray[np.intp]]) -> float:
    """As `text_calibration.calibration_error`, each group of rows of the weight of one."""
    taken = np.concatenate(rows)
    weights = np.concatenate([np.full(len(each), 1.0 / len(each)) for each in rows])
    part = np.minimum((stated[taken] * 10).astype(int), 9)
    off = weights * (stated[taken] - exact[taken])
    return float(sum(abs(off[part == k].sum()) for k in range(10)) / weights.sum())


def _aslant(image: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    height, width = image.shape[:2]
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    inwards = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * rng.uniform(0.0, ASLANT, (4, 2)) * [width, height]
    matrix = cv2.getPerspectiveTransform(corners, (corners + inwards).astype(np.float32))
    warped = cv2.warpPerspective(image, matrix, (width, height), borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(warped, np.uint8)
