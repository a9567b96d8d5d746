"""The map from above: sparse cloud, trajectory, landmarks in blue, other texts in pink (paper, Fig. 16)."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lpslam.ground.grid import Grid
from lpslam.ground.raster import room_image
from lpslam.views.figure import BLUE, GREEN, GREY, PINK, label, new_figure, save_figure, text_style
from lpslam.views.labels import place_labels

Array = NDArray[np.float64]

_LONG_SIDE = 12.0  # inches
_TITLE, _LEGEND = 0.45, 0.5  # inches above and below the map
_MARGIN = 0.06  # of the longer side around all that is drawn: room for the labels of its rim
_LEAST_MARGIN = 0.3  # metres
_TICK = 0.025  # of the longer side, length of the facing tick
_SIZE, _FEW_SIZE, _FEW = 9, 13, 12  # points of names; of few names, so many at most
_MOST_POINTS = 150_000  # more dots than these only cost time
_STRAY_SHARE = 0.5  # percent of the cloud at each side that may lie outside the picture
_KINDS = {True: (BLUE, "landmark"), False: (PINK, "other text"), None: (GREY, "text, not judged yet")}


class DrawnLandmark(Protocol):
    """What of a landmark is drawn: metres in the map frame; `is_landmark` None while nobody has judged."""

    @property
    def name(self) -> str:
        """The text it stands for; untrusted."""
        ...

    @property
    def position(self) -> Array:
        """(3,) metres."""
        ...

    @property
    def normal(self) -> Array:
        """(3,) unit, to where it is seen from."""
        ...

    @property
    def is_landmark(self) -> bool | None:
        """The judgement."""
        ...


def draw_map(
    out: Path,
    cloud: Array,
    trajectory: Array,
    landmarks: Sequence[DrawnLandmark],
    *,
    title: str = "",
    cloud_colours: NDArray[np.uint8] | None = None,
    ground: Grid | None = None,
) -> None:
    """Draw the map from above, x to the right and y up, as the suffix of `out` says (.png, .pdf, .svg).

    Args:
        out: the picture's file.
        cloud: (n, 3) metres, map frame.
        trajectory: (m, 3) metres, the camera's positions in order of time.
        landmarks: the texts.
        title: over the picture.
        cloud_colours: (n, 3) red, green, blue, of points lowest first; without, grey dots.
        ground: what is free and what is in the way, drawn below all else.

    Raises:
        UserError: the picture cannot be written.
    """
    cloud = np.asarray(cloud, dtype=np.float64).reshape(-1, 3)
    cloud, colours = _finite(cloud, cloud_colours)
    trajectory = np.asarray(trajectory, dtype=np.float64).reshape(-1, 3)
    shown = [mark for mark in landmarks if np.isfinite(mark.position).all()]
    # Landmarks first: they take the places nearest to their points.
    shown.sort(key=lambda mark: (mark.is_landmark is not True, mark.is_landmark is None))
    low, high = _extent(cloud, trajectory, np.array([mark.position for mark in shown]).reshape(-1, 3))
    figure, axes = _canvas(low, high)

    _draw_room(axes, cloud, colours, ground)
    axes.plot(trajectory[:, 0], trajectory[:, 1], color=GREEN, linewidth=1.4, alpha=0.9)
    tracked = trajectory[np.isfinite(trajectory).all(axis=1)]
    axes.plot(tracked[:1, 0], tracked[:1, 1], "o", color=GREEN, markersize=6)
    axes.plot(tracked[-1:, 0], tracked[-1:, 1], "s", color=GREEN, markersize=5)
    _draw_scale(figure, axes)
    _draw_legend(axes, shown)
    if title:
        axes.set_title(label(title), **text_style(13))
    _draw_landmarks(figure, axes, shown, tracked)
    save_figure(figure, out)


def _draw_room(axes: Axes, cloud: Array, colours: NDArray[np.uint8] | None, ground: Grid | None) -> None:
    """The room as it was seen from above; of a cloud without colours its points."""
    if colours is None:
        shown = cloud[:: max(1, -(-len(cloud) // _MOST_POINTS))]
        axes.scatter(shown[:, 0], shown[:, 1], s=0.6, c="#9aa3af", linewidths=0, rasterized=True)
        return
    image = room_image(cloud, colours, ground)
    if image is not None:
        limits = axes.get_xlim(), axes.get_ylim()
        axes.imshow(image.rgba, extent=image.extent, interpolation="nearest", zorder=0)
        axes.set_xlim(limits[0])
        axes.set_ylim(limits[1])


def _finite(cloud: Array, colours: NDArray[np.uint8] | None) -> tuple[Array, NDArray[np.uint8] | None]:
    finite = np.isfinite(cloud).all(axis=1)
    return cloud[finite], None if colours is None else np.asarray(colours, np.uint8).reshape(-1, 3)[finite]


def _extent(cloud: Array, trajectory: Array, places: Array) -> tuple[Array, Array]:
    """Lower left and upper right corner, metres; a few stray points of the cloud do not widen the picture."""
    corners = [points[np.isfinite(points).all(axis=1), :2] for points in (trajectory, places)]
    if len(cloud):
        corners.append(np.percentile(cloud[:, :2], [_STRAY_SHARE, 100 - _STRAY_SHARE], axis=0))
    points = np.concatenate(corners)
    if not len(points):
        points = np.zeros((1, 2))
    low, high = points.min(axis=0), points.max(axis=0)
    margin = max(_LEAST_MARGIN, _MARGIN * float((high - low).max()))
    return low - margin, high + margin


def _canvas(low: Array, high: Array) -> tuple[Figure, Axes]:
    size = high - low
    # A straight corridor would give a strip on which no label has room.
    width, height = (float(side) for side in np.maximum(size / size.max(), 0.3) * _LONG_SIDE)
    whole = height + _TITLE + _LEGEND
    figure = new_figure(width, whole)
    axes = figure.add_axes((0, _LEGEND / whole, 1, height / whole))
    inches = np.array([width, height])
    half = inches * float((size / inches).max()) / 2
    middle = (low + high) / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_axis_off()
    return figure, axes


def _draw_landmarks(figure: Figure, axes: Axes, shown: Sequence[DrawnLandmark], trajectory: Array) -> None:
    if not shown:
        return
    colours = [_KINDS[mark.is_landmark][0] for mark in shown]
    places = np.array([mark.position[:2] for mark in shown], dtype=np.float64)
    normals = np.array([mark.normal[:2] for mark in shown], dtype=np.float64)
    reach = _TICK * max(np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()))
    ticks = np.stack([places, places + reach * np.nan_to_num(normals)], axis=1)
    axes.add_collection(LineCollection(list(ticks), colors=colours, linewidths=1.6), autolim=False)
    axes.scatter(places[:, 0], places[:, 1], s=22, c=colours, edgecolors="white", linewidths=0.6, zorder=4)

    points = _FEW_SIZE if len(shown) <= _FEW else _SIZE
    halo = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0}
    texts = [
        axes.text(
            x, y, label(mark.name), **text_style(points, color=colour, ha="center", va="center", bbox=halo, zorder=5)
        )
        for mark, colour, (x, y) in zip(shown, colours, places, strict=True)
    ]
    figure.draw_without_rendering()
    extents = [text.get_window_extent() for text in texts]
    sizes = np.array([(extent.width, extent.height) for extent in extents])
    anchors = axes.transData.transform(places)
    obstacles = np.concatenate([ticks[:, 1], ticks.mean(axis=1), trajectory[:: max(1, len(trajectory) // 400), :2]])
    centres = place_labels(
        anchors, sizes, (figure.bbox.width, figure.bbox.height), obstacles=axes.transData.transform(obstacles)
    )
    to_metres = axes.transData.inverted()
    for text, anchor, size, centre, colour in zip(texts, anchors, sizes, centres, colours, strict=True):
        text.set_position(tuple(to_metres.transform(centre)))
        gap = np.maximum(np.abs(centre - anchor) - size / 2, 0)
        if np.hypot(*gap) > 12:
            leader = to_metres.transform([anchor, np.clip(anchor, centre - size / 2, centre + size / 2)])
            axes.plot(leader[:, 0], leader[:, 1], color=colour, linewidth=0.6, alpha=0.7, zorder=3)


def _draw_scale(figure: Figure, axes: Axes) -> None:
    """A length, and which way the map's axes point, in the strip below the map."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    height = axes.get_position().height * figure.get_figheight()
    inch = (top - bottom) / height
    wanted = (right - left) / 6
    power = 10.0 ** np.floor(np.log10(wanted))
    length = power * max((step for step in (2, 5) if step * power <= wanted), default=1)
    x, y = left + 0.15 * inch, bottom - 0.28 * inch
    plain: dict[str, Any] = {"clip_on": False, "zorder": 6}
    axes.plot([x, x + length], [y, y], color="black", linewidth=3, solid_capstyle="butt", **plain)
    place: dict[str, Any] = {"textcoords": "offset points", "annotation_clip": False}
    axes.annotate(f"{length:g} m", (x + length / 2, y), (0, 3), **place, **text_style(9, ha="center"))
    corner = np.array([right - 0.55 * inch, bottom - 0.30 * inch])
    for name, way, ha, va in (("x", (0.26, 0.0), "left", "center"), ("y", (0.0, 0.26), "center", "bottom")):
        tip = corner + np.array(way) * inch
        arrow: dict[str, Any] = {"arrowstyle": "-|>", "color": "black", "linewidth": 1, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tuple(tip), tuple(corner), arrowprops=arrow, annotation_clip=False)
        axes.annotate(name, tuple(tip), (0, 0), **place, **text_style(9, ha=ha, va=va))


def _draw_legend(axes: Axes, shown: Sequence[DrawnLandmark]) -> None:
    present = {mark.is_landmark for mark in shown}
    handles = [
        Line2D([], [], color=colour, marker="o", linestyle="none", markersize=5, label=name)
        for kind, (colour, name) in _KINDS.items()
        if kind in present
    ]
    handles.append(Line2D([], [], color=GREEN, marker="o", markersize=5, label="camera, from ● to ■"))
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.01), ncols=4, frameon=False, fontsize=9)
