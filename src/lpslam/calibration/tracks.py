"""Which keypoints of the chosen views see the same, and first poses and points that explain them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from lpslam.calibration.adjustment import Observations, State
from lpslam.calibration.lens import lens_of
from lpslam.calibration.views import View
from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import CalibratingConfig, SensorNoiseConfig
from lpslam.slam.consensus import largest_consensus
from lpslam.slam.kernels.matching import keep_consistent_rotations, match_brute_force

Array = NDArray[np.float64]
Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """Two views that see the same: rows of their keypoints (n,) each, and other_from_view, 4×4."""

    view: int
    other: int
    rows: Rows
    other_rows: Rows
    other_from_view: Array


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """Two views with keypoints that look alike: rows (n,) of each; those of the first have a depth."""

    view: int
    other: int
    rows: Rows
    other_rows: Rows


def likenesses(views: Sequence[View], config: CalibratingConfig) -> list[Likeness]:
    """All pairs of views with enough keypoints that look alike."""
    found = []
    for other in range(1, len(views)):
        for view in range(other):
            a, b = views[view].features, views[other].features
            row_of = match_brute_force(a.descriptor, b.descriptor, config.match_bits, config.match_ratio)
            keep_consistent_rotations(row_of, a.angle, b.angle)
            other_rows = np.flatnonzero(row_of >= 0)
            rows = row_of[other_rows].astype(np.int64)
            has_depth = a.has_depth[rows]
            if has_depth.sum() >= config.min_matches:
                found.append(Likeness(view, other, rows[has_depth], other_rows[has_depth]))
    return found


def rigid_matches(
    views: Sequence[View],
    alike: Sequence[Likeness],
    camera: PinholeCamera,
    tolerance: float,
    config: CalibratingConfig,
) -> list[Match]:
    """Those that one rigid motion explains, within `tolerance` pixels of what the present guess of the camera says."""
    straight = [camera.undistort(view.features.pixels.astype(np.float64)) for view in views]
    intrinsics = np.array([camera.fx, camera.fy, camera.cx, camera.cy])
    found = []
    for pair in alike:
        depth = views[pair.view].features.depth[pair.rows].astype(np.float64)
        positions = camera.back_project(straight[pair.view][pair.rows], depth)
        pixels = straight[pair.other][pair.other_rows].astype(np.float32)
        agreed = largest_consensus(positions, pixels, intrinsics, config.trials, tolerance)
        if agreed is not None and len(agreed.rows) >= config.min_matches:
            rows, other_rows = pair.rows[agreed.rows], pair.other_rows[agreed.rows]
            found.append(Match(pair.view, pair.other, rows, other_rows, agreed.camera_from_world))
    return found


def first_poses(matches: Sequence[Match], count: int) -> tuple[Rows, Array]:
    """Views that hang together (v,), rising, and their camera_from_world (v, 4, 4) in the frame of the first of them.

    Poses are chained along the matches with most keypoints.
    """
    views = np.array([[match.view, match.other] for match in matches], np.int64).reshape(-1, 2)
    weights = np.array([1.0 / len(match.rows) for match in matches])
    links = coo_array((weights, (views[:, 0], views[:, 1])), shape=(count, count)).tocsr()
    _, part = connected_components(links, directed=False)
    together = np.flatnonzero(part == np.bincount(part).argmax())
    tree = minimum_spanning_tree(links)
    order, before = breadth_first_order(tree, int(together[0]), directed=False)
    motions = {(match.view, match.other): match.other_from_view for match in matches}
    poses = np.tile(np.eye(4), (count, 1, 1))
    for view in order[1:]:
        parent = int(before[view])
        forward = motions.get((parent, int(view)))
        step = forward if forward is not None else inverse_transform(motions[int(view), parent])
        poses[view] = step @ poses[parent]
    return together, poses[together]


def observe(
    views: Sequence[View],
    matches: Sequence[Match],
    together: Rows,
    camera: PinholeCamera,
    poses: Array,
    noise: SensorNoiseConfig,
    config: CalibratingConfig,
) -> tuple[Observations, State]:
    """Points that are seen in two views or more, as the first view with a depth places them.

    Args:
        views, matches: all of them.
        together: (v,) the views to use.
        camera: with the first guess of the lens.
        poses: (v, 4, 4) camera_from_world of these views.
        noise: how far keypoints and depths stray.
        config: how many points, and on which pyramid keypoints are found.
    """
    sizes = np.array([view.features.rows for view in views])
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    place = np.full(len(views), -1)
    place[together] = np.arange(len(together))
    view_of = np.repeat(place, sizes)
    track = _tracks(matches, offsets)
    track[view_of < 0] = -1
    track = _sound(track, view_of, len(together), config.points)
    seen = np.flatnonzero(track >= 0)
    drag = np.concatenate([view.drag for view in views])[seen]
    pixels, depth, octave = (
        np.concatenate([getattr(view.features, name) for view in views])[seen].astype(np.float64)
        for name in ("pixels", "depth", "octave")
    )
    view, point = view_of[seen], track[seen]
    with_depth = np.flatnonzero(depth > 0)
    local = camera.back_project(camera.undistort(pixels[with_depth]), depth[with_depth])
    points = np.full((int(track.max(initial=-1)) + 1, 3), np.nan)
    for k in range(len(together)):
        rows = view[with_depth] == k
        points_here = transform_points(inverse_transform(poses[k]), local[rows])
        fresh = np.isnan(points[point[with_depth][rows], 0])
        points[point[with_depth][rows][fresh]] = points_here[fresh]
    scales = config.scale_factor**octave
    safe = np.where(depth > 0, depth, 1.0)
    sigma = (noise.depth_sigma + noise.depth_sigma_quadratic * safe**2) / safe**2
    observations = Observations(
        view,
        point,
        pixels,
        drag,
        np.where(depth > 0, 1.0 / safe, 0.0),
        np.sqrt(noise.pixel_sigma**2 + (noise.level_pixel_sigma * scales) ** 2),
        np.where(depth > 0, sigma, 1.0),
    )
    return observations, State(lens_of(camera), poses, points)


def _tracks(matches: Sequence[Match], offsets: Rows) -> Rows:
    """A number for each keypoint (all views' in a row): equal for those that are matched, however indirectly."""
    total = int(offsets[-1])
    if not matches:
        return np.full(total, -1)
    a = np.concatenate([offsets[match.view] + match.rows for match in matches])
    b = np.concatenate([offsets[match.other] + match.other_rows for match in matches])
    links = coo_array((np.ones(len(a)), (a, b)), shape=(total, total))
    return np.asarray(connected_components(links, directed=False)[1], np.int64)


def _sound(track: Rows, view_of: Rows, views: int, most: int) -> Rows:
    """Numbers from 0 for tracks that each view sees once at most and two at least; -1 for all others.

    Of too many, those stay that most views see.
    """
    used = np.flatnonzero(track >= 0)
    cells, counts = np.unique(track[used] * views + view_of[used], return_counts=True)
    tracks, seen = np.unique(cells // views, return_counts=True)
    torn = np.unique(cells[counts > 1] // views)
    good = tracks[(seen > 1) & ~np.isin(tracks, torn)]
    if len(good) > most:
        seen_good = seen[np.isin(tracks, good)]
        good = np.sort(good[np.argsort(-seen_good, kind="stable")[:most]])
    number = np.full(int(track.max(initial=0)) + 1, -1, np.int64)
    number[good] = np.arange(len(good))
    return np.where(track >= 0, number[np.maximum(track, 0)], -1)
