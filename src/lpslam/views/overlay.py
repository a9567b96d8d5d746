"""Text boxes over the image: those kept in green, those dropped in yellow (paper, Fig. 11)."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_path
from lpslam.text.types import BoxFate, FrameReading
from lpslam.views.drawable import printable

_KEPT, _DROPPED = (40, 200, 80), (250, 205, 30)
_FONT_PIXELS = 16


def draw_reading(rgb: NDArray[np.uint8], reading: FrameReading) -> NDArray[np.uint8]:
    """Draw what reading made of a frame: its texts with their confidence in green, dropped boxes with the reason.

    Args:
        rgb: (height, width, 3), the frame's image.
        reading: of this frame.
    """
    texts = iter(reading.texts.spotted)
    kept = [fate == BoxFate.KEPT for fate in reading.fates]
    labels: list[str] = []
    for is_kept, fate in zip(kept, reading.fates, strict=True):
        text = next(texts, None) if is_kept else None
        labels.append(f"{text.text} {text.confidence:.2f}" if text is not None else str(fate))
    return draw_boxes(rgb, reading.boxes, kept, labels)


def draw_boxes(
    rgb: NDArray[np.uint8],
    boxes: NDArray[np.float64],
    kept: Sequence[bool],
    labels: Sequence[str],
) -> NDArray[np.uint8]:
    """Draw boxes and what was read in them over a copy of the image.

    Args:
        rgb: (height, width, 3).
        boxes: (n, 4, 2) pixels, corner by corner.
        kept: one a box.
        labels: one a box, empty where nothing was read; untrusted.

    Returns:
        (height, width, 3), like the image.
    """
    picture = Image.fromarray(rgb)
    pen = ImageDraw.Draw(picture)
    font = ImageFont.truetype(str(font_path("map")), _FONT_PIXELS)
    height, width = rgb.shape[:2]
    for box, is_kept, text in zip(np.asarray(boxes, dtype=np.float64).reshape(-1, 4, 2), kept, labels, strict=True):
        colour = _KEPT if is_kept else _DROPPED
        if not np.isfinite(box).all():
            continue
        corners = [(float(x), float(y)) for x, y in box]
        pen.line([*corners, corners[0]], fill=colour, width=2, joint="curve")
        words = printable(text)
        if not words:
            continue
        left, top, right, bottom = pen.textbbox((0, 0), words, font=font)
        x = float(np.clip(box[:, 0].min(), 0, max(0, width - (right - left) - 4)))
        above = box[:, 1].min() - (bottom - top) - 6
        y = float(above if above >= 0 else min(box[:, 1].max() + 2, height - (bottom - top) - 4))
        pen.rectangle((x, y, x + right - left + 4, y + bottom - top + 4), fill=colour)
        pen.text((x + 2 - left, y + 2 - top), words, font=font, fill=(0, 0, 0))
    return np.array(picture, dtype=np.uint8)
