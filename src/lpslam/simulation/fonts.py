"""The fonts that signs are painted with."""

import logging
from functools import cache, lru_cache

from PIL import ImageFont, features

from lpslam.assets import font_path

logger = logging.getLogger(__name__)


@lru_cache(256)
def sign_font(name: str, size: float) -> ImageFont.FreeTypeFont:
    """A font of the package at a size in pixels; the first one warns where letters are set otherwise than usual."""
    _warn_of_other_widths()
    return ImageFont.truetype(str(font_path(name)), size)


@cache
def _warn_of_other_widths() -> None:
    # Pillow brings Raqm and looks for FriBiDi in the system; without, it knows no kerning.
    if not features.check("raqm"):
        logger.warning(
            "letters are set without kerning, so that a seed is another world than elsewhere: "
            "install FriBiDi (apt install libfribidi0)"
        )
