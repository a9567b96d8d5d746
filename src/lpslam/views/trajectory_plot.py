"""An estimated trajectory over the true one, and its error over time."""

from pathlib import Path

import numpy as np

from lpslam.camera import transform_points
from lpslam.evaluation.trajectory import AteResult
from lpslam.poses import StampedPoses
from lpslam.views.figure import BLUE, GREY, label, new_figure, plain_axes, save_figure, text_style


def draw_trajectories(
    out: Path, truth: StampedPoses, estimate: StampedPoses, result: AteResult, *, title: str = ""
) -> None:
    """Draw both trajectories in the plane of the largest motion, and the error of each compared pose.

    Args:
        out: the picture's file.
        truth: the true trajectory.
        estimate: the estimated one, in a frame of its own.
        result: their comparison, which aligns the estimate.
        title: over the picture.

    Raises:
        UserError: the picture cannot be written.
    """
    aligned = transform_points(result.truth_from_estimate, estimate.positions)
    # Recordings do not agree on which axis is up; the two along which the camera moved most show the path.
    across, along = sorted(np.argsort(-np.ptp(truth.positions, axis=0), kind="stable")[:2].tolist())
    figure = new_figure(12, 5.5)
    path_axes = figure.add_axes((0.06, 0.1, 0.4, 0.8))
    error_axes = figure.add_axes((0.54, 0.1, 0.43, 0.8))
    for axes in (path_axes, error_axes):
        plain_axes(axes)

    path_axes.plot(
        truth.positions[:, across], truth.positions[:, along], color=GREY, linewidth=2.4, alpha=0.6, label="truth"
    )
    path_axes.plot(aligned[:, across], aligned[:, along], color=BLUE, linewidth=1.1, label="estimate")
    path_axes.set_aspect("equal", adjustable="datalim")
    path_axes.set_xlabel(f"{'xyz'[across]} [m]", **text_style(9))
    path_axes.set_ylabel(f"{'xyz'[along]} [m]", **text_style(9))
    path_axes.legend(frameon=False, fontsize=9)

    error_axes.plot(result.timestamps - result.timestamps[0], 1000 * result.errors, color=BLUE, linewidth=1.0)
    error_axes.axhline(1000 * result.rmse, color="black", linewidth=1, linestyle="--")
    error_axes.set_ylim(bottom=0)
    error_axes.set_xlabel("seconds", **text_style(9))
    error_axes.set_ylabel("position error [mm]", **text_style(9))
    error_axes.set_title(
        f"RMSE {1000 * result.rmse:.1f} mm, median {1000 * result.median:.1f} mm, "
        f"largest {1000 * result.max:.1f} mm, {result.count} poses",
        **text_style(10),
    )
    if title:
        path_axes.set_title(label(title), **text_style(12))
    save_figure(figure, out)
