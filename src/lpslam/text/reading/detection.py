"""Scene text detection with DBNet (paper, III-B): a probability map, binarised, one rotated box a region."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from cv2.typing import MatLike
from numpy.typing import NDArray

from lpslam.config import SpottingConfig
from lpslam.text.reading.boxes import Boxes
from lpslam.text.reading.networks import Network

# A line on an arc: its least length, the least rise of its middle over its ends, and by how much that may stray from a
# bow, as multiples of its thickness. Lines on two drawn boards rise by 0.8 to 1.3 and stray by 0.03 to 0.06; of 54
# other regions of a café and two streets none is as long and bent.
_LEAST_ARC, _LEAST_RISE, _MOST_STRAYED = 5.0, 0.35, 0.15


class TextDetector:
    """Finds text boxes in an image."""

    def __init__(self, network: Network, config: SpottingConfig) -> None:
        self._network = network
        self._config = config

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """Find the text boxes of an image.

        Args:
            rgb: (h, w, 3).

        Returns:
            (n, 4, 2) raw pixels, each box ordered top left, top right, bottom right, bottom left, and (n,) scores:
            the mean text probability inside.
        """
        probability = self._network.infer(network_input(self._resized(rgb)))[0, 0]
        boxes, scores = boxes_from_probability(probability, self._config)
        height, width = rgb.shape[:2]
        scale = np.array([width / probability.shape[1], height / probability.shape[0]])
        # Pixel centres are at whole numbers: the resize maps edges, which lie half a pixel outside.
        boxes = (boxes + 0.5) * scale - 0.5
        return np.clip(boxes, 0.0, [width - 1.0, height - 1.0]), scores

    def _resized(self, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        height, width = rgb.shape[:2]
        ratio = min(1.0, self._config.detection_side / max(height, width))
        # The network halves its input five times.
        size = [max(32, round(side * ratio / 32) * 32) for side in (width, height)]
        if size == [width, height]:
            return rgb
        return np.asarray(cv2.resize(rgb, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def network_input(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Turn an (h, w, 3) RGB image into the (1, 3, h, w) blue-green-red batch in [-1, 1] that the models learnt on."""
    planes = np.ascontiguousarray(rgb[:, :, ::-1].transpose(2, 0, 1)[None], dtype=np.float32)
    planes *= 2.0 / 255.0
    planes -= 1.0
    return planes


def boxes_from_probability(
    probability: NDArray[np.float32], config: SpottingConfig
) -> tuple[Boxes, NDArray[np.float64]]:
    """Turn a text probability map (h, w) into boxes (n, 4, 2) in its pixels and their scores (n,).

    DBNet learns to mark text regions shrunk towards their middle; each region's smallest rectangle is grown back
    by area × ratio / perimeter.
    """
    mask = (probability > config.text_probability).astype(np.uint8)
    mask = np.asarray(cv2.dilate(mask, np.ones((2, 2), np.uint8)), dtype=np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    regions = [(contour, cv2.minAreaRect(contour)) for contour in contours]
    regions = [each for each in regions if min(each[1][1]) >= config.min_region_side]
    if len(regions) > config.max_boxes:
        # The largest are most likely to be read.
        regions = sorted(regions, key=lambda each: -each[1][1][0] * each[1][1][1])[: config.max_boxes]
    boxes, scores = [], []
    for contour, rectangle in regions:
        centre, (width, height), angle = rectangle
        score = _mean_inside(probability, _corners(centre, width, height, angle))
        if score < config.box_score and not _is_an_arc(probability, contour, rectangle, config):
            continue
        growth = 2.0 * (width * height * config.growth_ratio / (2.0 * (width + height)))
        grown = _ordered(_corners(centre, width + growth, height + growth, angle))
        boxes.append(_as_seen_aslant(contour, grown, config))
        scores.append(score)
    return np.array(boxes, dtype=np.float64).reshape(-1, 4, 2), np.array(scores, dtype=np.float64)


def _as_seen_aslant(contour: MatLike, rectangle: Boxes, config: SpottingConfig) -> Boxes:
    """The quadrilateral (4, 2) around a region where that is much smaller than its `rectangle`; else the rectangle.

    A line seen aslant is a trapezium or a slanted parallelogram: what a rectangle adds is not text.
    """
    shrunken = np.asarray(cv2.approxPolyN(contour, 4, ensure_convex=True), dtype=np.float64).reshape(-1, 2)
    if len(shrunken) != 4:
        return rectangle
    area = float(cv2.contourArea(shrunken.astype(np.float32)))
    perimeter = float(np.linalg.norm(shrunken - np.roll(shrunken, 1, axis=0), axis=1).sum())
    quadrilateral = _ordered(_grown(shrunken, area * config.growth_ratio / max(perimeter, 1e-6)))
    covered = float(cv2.contourArea(quadrilateral.astype(np.float32)))
    is_convex = cv2.isContourConvex(quadrilateral.astype(np.float32))
    whole = float(cv2.contourArea(rectangle.astype(np.float32)))
    return quadrilateral if is_convex and covered < config.slant_area * whole else rectangle


def _grown(polygon: Boxes, distance: float) -> Boxes:
    """Move every side of a convex polygon (n, 2) outwards by `distance`."""
    ahead = np.roll(polygon, -1, axis=0) - polygon
    normals = np.column_stack([ahead[:, 1], -ahead[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    # Outwards is away from the middle, whichever way the corners run.
    outwards = np.sign(np.einsum("ij,ij->i", normals, polygon - polygon.mean(axis=0)))
    normals *= outwards[:, None]
    offsets = np.einsum("ij,ij->i", normals, polygon) + distance
    before = np.roll(normals, 1, axis=0)
    systems = np.stack([before, normals], axis=1)
    if np.abs(np.linalg.det(systems)).min() < 1e-3:
        return polygon
    sides = np.column_stack([np.roll(offsets, 1), offsets])
    return np.asarray(np.linalg.solve(systems, sides[:, :, None])[:, :, 0], dtype=np.float64)


def _corners(centre: Sequence[float], width: float, height: float, angle: float) -> NDArray[np.float32]:
    return np.asarray(cv2.boxPoints((centre, (width, height), angle)), dtype=np.float32)


def _mean_inside(probability: NDArray[np.float32], corners: NDArray[np.float32]) -> float:
    low = np.clip(np.floor(corners.min(axis=0)), 0, None).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0)), None, np.array(probability.shape[::-1]) - 1).astype(int)
    window = probability[low[1] : high[1] + 1, low[0] : high[0] + 1]
    mask = np.zeros(window.shape, np.uint8)
    cv2.fillPoly(mask, [(corners - low).astype(np.int32)], 1)
    return float(cv2.mean(window, mask)[0])


def _is_an_arc(
    probability: NDArray[np.float32], contour: MatLike, rectangle: cv2.typing.RotatedRect, config: SpottingConfig
) -> bool:
    """Whether a region is a bent line of letters, which leaves most of its rectangle empty: its own pixels count."""
    left, top, width, height = cv2.boundingRect(contour)
    mask = np.zeros((height, width), np.uint8)
    cv2.drawContours(mask, [contour], -1, 1, cv2.FILLED, offset=(-left, -top))
    if cv2.mean(probability[top : top + height, left : left + width], mask)[0] < config.arc_score:
        return False
    length, thickness, middles = _middles(contour, rectangle)
    if length < _LEAST_ARC * thickness:
        return False
    places = np.linspace(-1.0, 1.0, len(middles))
    bend = np.polyfit(places, middles, 2)
    strayed = float(np.sqrt(np.mean((np.polyval(bend, places) - middles) ** 2)))
    return bool(abs(bend[0]) > _LEAST_RISE * thickness and strayed < _MOST_STRAYED * thickness)


def _middles(contour: MatLike, rectangle: cv2.typing.RotatedRect) -> tuple[float, float, NDArray[np.float64]]:
    """Length and usual thickness of a region along its smallest rectangle, and where its middle is at each pixel."""
    centre, (width, height), angle = rectangle
    turn = np.deg2rad(angle + (0.0 if width >= height else 90.0))
    along = np.array([np.cos(turn), np.sin(turn)])
    points = (contour.reshape(-1, 2) - np.array(centre)) @ np.column_stack([along, [-along[1], along[0]]])
    points -= points.min(axis=0)
    columns, rows = (int(each) + 1 for each in np.ceil(points.max(axis=0)))
    mask = np.zeros((rows, columns), np.uint8)
    cv2.fillPoly(mask, [np.round(points).astype(np.int32)], 1)
    thick = mask.sum(axis=0)
    middles = (np.arange(rows) @ mask)[thick > 0] / thick[thick > 0]
    return float(columns), float(np.median(thick[thick > 0])), np.asarray(middles, np.float64)


def _ordered(corners: NDArray[np.floating[Any]]) -> Boxes:
    """Order a rectangle's corners top left, top right, bottom right, bottom left."""
    by_x = corners[np.argsort(corners[:, 0], kind="stable")]
    left = by_x[:2][np.argsort(by_x[:2, 1], kind="stable")]
    right = by_x[2:][np.argsort(by_x[2:, 1], kind="stable")]
    return np.array([left[0], right[0], right[1], left[1]], dtype=np.float64)
