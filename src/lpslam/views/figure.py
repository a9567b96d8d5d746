"""What all pictures share: a figure without global state, the carried font, and saving with clear errors."""

from functools import cache
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, get_font

from lpslam.assets import font_path
from lpslam.errors import UserError
from lpslam.views.drawable import printable, with_known_glyphs
from lpslam.whole_files import written_whole

BLUE, PINK, GREY, GREEN = "#1f4fd8", "#e0479e", "#6b7280", "#12813d"
DOTS_PER_INCH = 150


def new_figure(width: float, height: float) -> Figure:
    """A figure of so many inches that draws by itself, outside pyplot's registry."""
    figure = Figure(figsize=(width, height), dpi=DOTS_PER_INCH, facecolor="white")
    FigureCanvasAgg(figure)
    return figure


def font(size: float) -> FontProperties:
    """The carried font (Latin, kana, Chinese) in points."""
    return FontProperties(fname=str(font_path("map")), size=size)


def label(text: str) -> str:
    """A text from the world as it is drawn."""
    return with_known_glyphs(printable(text), _known_glyphs())


def text_style(size: float, **style: Any) -> dict[str, Any]:
    """Keywords for a text from the world: the carried font, and no mathematics however many `$` it has."""
    return {"fontproperties": font(size), "parse_math": False, **style}


def plain_axes(axes: Axes) -> None:
    """Take away the frame's upper and right side and soften the rest."""
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_color(GREY)
    axes.tick_params(colors=GREY, labelsize=8)
    axes.grid(color="#e5e7eb", linewidth=0.6)
    axes.set_axisbelow(True)


def save_figure(figure: Figure, out: Path) -> None:
    """Write the picture in the format of its suffix.

    Raises:
        UserError: the place cannot be written, or the suffix names no picture format.
    """
    known = figure.canvas.get_supported_filetypes()
    suffix = out.suffix.lower().removeprefix(".")
    if suffix not in known:
        raise UserError(
            f"picture {out}: {out.suffix or 'no suffix'} is no picture format; end its name in .png or .pdf"
        )
    with written_whole(out, "picture") as part:
        figure.savefig(part, format=suffix, metadata={"Software": None} if suffix == "png" else None)


@cache
def _known_glyphs() -> frozenset[int]:
    return frozenset(get_font(str(font_path("map"))).get_charmap())
