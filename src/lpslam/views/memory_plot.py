"""How the memory scores of classes rise and fade, with the threshold of long-term memory (paper, Fig. 13)."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lpslam.text.remembering.histories import ScoreHistory
from lpslam.views.figure import GREY, label, new_figure, plain_axes, save_figure, text_style
from lpslam.views.labels import place_labels

_DASHES = ("-", "--", ":", "-.")
_HALO = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.5}


def draw_memory(out: Path, histories: Sequence[ScoreHistory], promotion: float, *, title: str = "") -> None:
    """Draw the score histories: promoted classes in colour with their names, forgotten ones in grey.

    Args:
        out: the picture's file.
        histories: of all classes.
        promotion: the score at which a class moves to long-term memory.
        title: over the picture.

    Raises:
        UserError: the picture cannot be written.
    """
    figure = new_figure(10, 5.5)
    axes = figure.add_axes((0.07, 0.1, 0.9, 0.82))
    plain_axes(axes)
    palette = matplotlib.colormaps["tab10"].colors  # type: ignore[attr-defined]
    peaks: list[_Peak] = []
    promoted = 0
    for history in sorted(histories, key=lambda history: history.is_long_term):
        if not history.samples:
            continue
        seconds, scores = np.array(history.samples, dtype=np.float64).T
        if not history.is_long_term:
            axes.plot(seconds, scores, color=GREY, linewidth=0.8, alpha=0.5)
            continue
        colour, dashes = palette[promoted % 10], _DASHES[promoted // 10 % len(_DASHES)]
        promoted += 1
        axes.plot(seconds, scores, color=colour, linewidth=1.4, linestyle=dashes)
        peak = int(np.argmax(scores))
        peaks.append((seconds[peak], scores[peak], label(history.name), colour))
    axes.axhline(promotion, color="black", linewidth=1, linestyle="--")
    axes.set_ylim(bottom=0)
    axes.margins(y=0.25)
    axes.annotate(
        "long-term memory", (0, promotion), (4, 3), xycoords=("axes fraction", "data"), textcoords="offset points",
        **text_style(8),
    )  # fmt: skip
    axes.set_xlabel("seconds", **text_style(9))
    axes.set_ylabel("memory score", **text_style(9))
    if title:
        axes.set_title(label(title), **text_style(12))
    if peaks:
        _name_peaks(figure, axes, peaks)
    save_figure(figure, out)


_Peak = tuple[float, float, str, tuple[float, float, float]]
"""Seconds and score of a class's highest point, its name as it is drawn, and its colour."""


def _name_peaks(figure: Figure, axes: Axes, peaks: Sequence[_Peak]) -> None:
    texts = [
        axes.text(x, y, name, **text_style(8, color=colour, ha="center", va="center", bbox=_HALO))
        for x, y, name, colour in peaks
    ]
    figure.draw_without_rendering()
    extents = [text.get_window_extent() for text in texts]
    anchors = axes.transData.transform(np.array([(x, y) for x, y, _, _ in peaks]))
    sizes = np.array([(extent.width, extent.height) for extent in extents])
    centres = place_labels(anchors, sizes, (figure.bbox.width, figure.bbox.height), gap=4)
    for text, centre in zip(texts, axes.transData.inverted().transform(centres), strict=True):
        text.set_position(tuple(centre))
