"""Where texts stand by the directions in which they were seen: for those without depth, and those behind glass.

A box without depth still says in which direction its text stands. Seen from several keyframes the directions meet: the
text is triangulated, as surely as the boxes' noise and the way between the views allow. What depth was measured, be it
of the surface around a sign, enters with the weight of its own certainty. Nothing is kept but what each keyframe saw,
so a text moves with its keyframes when the map is corrected.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import InstanceConfig
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.standing import placements_at
from lpslam.text.placing.triangulation import Triangulated, angles, meetings, triangulate
from lpslam.text.placing.views import Array, Rows, Views, moved, unit, views_of
from lpslam.text.types import Placement, TextObservation

_SIGMAS = 3.0
"""Standard deviations within which a direction agrees with a position."""

_RANGE_SHARE = 1.0 / 9.0
"""Largest uncertainty as a share of the distance. What directions say is even in inverse distance: at three standard
deviations the text is then no farther than half as far again as it is held to be, and never out of all sight."""

_FEWEST_VIEWS = 3
"""Views that must agree where there is no depth: any two directions of one plane meet somewhere."""

_TRIED = 48
"""Most views of which pairs are tried; of more, evenly chosen ones."""

_REFUTED = 16.3
"""Chi-square of three degrees of freedom that chance exceeds once in a thousand times."""

_FEW = 0.25
"""Share of the views of a text without depth below which what they see around it is not its surface, but nearer."""

_MISFIT = 2.0
"""Largest chi-square a degree of freedom of directions that agree; beyond it their noise is not what it should be."""

_ASSUMED = 3.0
"""Degrees of freedom that the noise assumed counts for beside what views of one spelling show. With three, errors of
texts whose depth is left out are within 1.6 times what is stated in nine of ten."""

_PLANE_SPREAD = 0.1
"""Metres, standard deviation, within which depths measured through glass lie on one standing surface."""


def placed(
    observations: Sequence[TextObservation], world_from_keyframe: KeyframePoses, config: InstanceConfig
) -> list[TextObservation]:
    """Place the observations of one class by all that is known of it.

    Args:
        observations: whose keyframes all have a place.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose.
        config: what counts as sure.

    Returns:
        Those that have a placement, be it their own or by the directions of others; in order.
    """
    with_bearing = [row for row, each in enumerate(observations) if each.bearing is not None]
    placements = {row: each.placement for row, each in enumerate(observations) if each.placement is not None}
    if with_bearing:
        views = views_of([observations[row] for row in with_bearing], world_from_keyframe, config)
        for view, placement in _by_directions(views, config).items():
            if placement is None:
                del placements[with_bearing[view]]
                continue
            pose = world_from_keyframe(observations[with_bearing[view]].keyframe)
            assert pose is not None
            placements[with_bearing[view]] = moved(placement, inverse_transform(pose))
    return [replace(observations[row], placement=placements[row]) for row in sorted(placements)]


def _by_directions(views: Views, config: InstanceConfig) -> dict[int, Placement | None]:
    """Placements in the world of the views that depth does not place surely, and of those whose depth is refuted.

    None for those that stand nowhere: what few views saw around a text that directions do not place either.
    """
    found: dict[int, Placement | None] = dict(_overruled(views))
    left = np.flatnonzero(~views.sure)
    # What depth places surely is no proof of itself, but others may be directed at it.
    sure = np.setdiff1d(np.flatnonzero(views.sure), list(found))
    while len(left):
        here, there = _best(views, left, sure)
        if not len(here):
            break
        place = _fused(views, here, there)
        if place is not None and _is_sure_enough(place, views.origins[here], config):
            found |= placements_at(views, here, there, place)
        elif len(few := here[[views.placements[row] is not None for row in here]]) <= _FEW * len(here):
            found |= dict.fromkeys(few.tolist())
        left = np.setdiff1d(left, here)
    return found


def _is_sure_enough(place: Triangulated, origins: Array, config: InstanceConfig) -> bool:
    """Whether a position is certain against its distance, and against what sets two places of a text apart."""
    distance = float(np.linalg.norm(origins - place.position, axis=1).min())
    return place.uncertainty <= min(_RANGE_SHARE * distance, 0.5 * config.place_distance)


def _best(views: Views, left: Rows, sure: Rows) -> tuple[Rows, Rows]:
    """The views of `left` that agree on the position of most keyframes, and those of `sure` that stand there."""
    empty = np.zeros(0, np.intp)
    by_depth = [row for row in [*left.tolist(), *sure.tolist()] if views.placements[row] is not None]
    placements = [views.placements[row] for row in by_depth]
    standing = np.array([each.position for each in placements if each is not None]).reshape(-1, 3)
    strayed = np.array([each.uncertainty for each in placements if each is not None])
    meeting = _meetings(views, left)
    points = np.vstack([standing, meeting])
    if not len(points):
        return empty, empty
    strayed = np.concatenate([strayed, np.zeros(len(meeting))])
    distances = np.linalg.norm(points[:, None] - views.origins[left], axis=2)
    allowed = _SIGMAS * np.hypot(views.noise[left], np.minimum(strayed[:, None] / np.maximum(distances, 1e-6), 0.1))
    agree, scores = _agreement(views, left, angles(points, views.origins[left], views.directions[left]) / allowed)
    near = _near(views, sure, points, strayed)
    # What stands there by depth is seen there too: a point between two texts has views of both, and depth of neither.
    scores = [
        (views.keyframes_of(np.concatenate([left[own], sure[there]])), int(own.sum()), nearness)
        for own, there, (_, _, nearness) in zip(agree, near, scores, strict=True)
    ]
    # Depth says more than that directions cross: of equals it comes first. A point between two texts has as many views
    # as either, but none of them nearly.
    best = max(range(len(points)), key=lambda row: (scores[row][:2], row < len(standing), scores[row][2]))
    here = left[agree[best]]
    has_depth = best < len(standing)
    if not has_depth and (views.keyframes_of(here) < 2 or len(here) < _FEWEST_VIEWS):
        return empty, empty
    return here, sure[near[best]]


def _near(views: Views, sure: Rows, points: Array, strayed: Array) -> NDArray[np.bool_]:
    """Which views that depth places surely stand at each of m points, (m, n), as far as both are certain."""
    placements = [each for row in sure.tolist() if (each := views.placements[row]) is not None]
    positions = np.array([each.position for each in placements]).reshape(-1, 3)
    uncertainties = np.array([each.uncertainty for each in placements])
    apart = np.linalg.norm(points[:, None] - positions, axis=2)
    return np.asarray(apart < _SIGMAS * np.hypot(strayed[:, None], uncertainties), np.bool_)


def _agreement(views: Views, rows: Rows, misses: Array) -> tuple[NDArray[np.bool_], list[tuple[int, int, float]]]:
    """Which of some views agree with each of m points; from how many keyframes, how many, and how nearly.

    What one frame saw twice is two texts, be they entries of one list: the nearer one agrees.

    Args:
        views: all of a class.
        rows: of those asked.
        misses: (m, n) by how much they miss the points, as shares of what is allowed.
    """
    agree = misses < 1.0
    _, frame_of, times = np.unique(views.frames[rows], return_inverse=True, return_counts=True)
    for frame in np.flatnonzero(times > 1):
        twice = np.flatnonzero(frame_of == frame)
        nearest = twice[misses[:, twice].argmin(axis=1)]
        agree[:, twice] &= twice == nearest[:, None]
    nearness = np.where(agree, 1.0 - misses**2, 0.0).sum(axis=1).tolist()
    counts = [(views.keyframes_of(rows[own]), int(own.sum())) for own in agree]
    return agree, [(*count, near) for count, near in zip(counts, nearness, strict=True)]


def _meetings(views: Views, rows: Rows) -> Array:
    """Points (m, 3) at which the directions of some views meet in pairs."""
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _TRIED)).astype(int))]
    first, second = np.triu_indices(len(rows), 1)
    apart = views.keyframes[rows[first]] != views.keyframes[rows[second]]
    pairs = rows[first[apart]], rows[second[apart]]
    return meetings(views.origins, views.directions, views.noise, *pairs)


def _fused(views: Views, here: Rows, there: Rows) -> Triangulated | None:
    """The position by the directions `here` and `there` and by the depths measured, each as sure as it is."""
    rows = np.concatenate([here, there])
    matrix, vector = np.zeros((3, 3)), np.zeros(3)
    # What the surface around a sign says errs alike from everywhere: all of it counts as one, and as little of one as
    # few views have it: where most see nothing around, what is there is nearer than the sign. Own depth: a keyframe.
    doubtful = [row for row in here.tolist() if views.placements[row] is not None]
    shares = dict(zip(there.tolist(), views.shares(there), strict=True)) if len(there) else {}
    shares |= dict.fromkeys(doubtful, 1.0 / len(here))
    start = None
    for row, share in shares.items():
        placement = views.placements[row]
        if placement is None:
            continue
        ray = views.directions[row]
        information = share / placement.uncertainty**2 * np.outer(ray, ray)
        matrix, vector = matrix + information, vector + information @ np.array(placement.position)
        start = np.array(placement.position)
    if start is None and views.keyframes_of(rows) < 2:
        return None
    seen, known = (views.origins[rows], views.directions[rows]), (matrix, vector)
    place = triangulate(*seen, views.noise[rows], views.shares(rows), known, start)
    if place is None or place.misfit > _MISFIT:
        return None
    return triangulate(*seen, _noise_shown(views, rows, place.position), views.shares(rows), known, place.position)


def _noise_shown(views: Views, rows: Rows, position: Array) -> Array:
    """Standard deviations, radians (m,), of the directions of some views, by how well those of one spelling agree.

    Boxes of large clear letters stray less than those of others: what is assumed of all is too much for them.
    """
    alike = rows[views.spellings[rows] == np.bincount(views.spellings[rows]).argmax()]
    assumed = np.sqrt(views.noise**2 - views.lacking**2)
    misses = angles(position, views.origins[alike], views.directions[alike]) / assumed[alike]
    freedom = max(2.0 * len(alike) - 3.0, 0.0)
    share = min((_ASSUMED + float(misses @ misses)) / (_ASSUMED + freedom), 1.0)
    return np.asarray(np.hypot(np.sqrt(share) * assumed[rows], views.lacking[rows]), np.float64)


def _overruled(views: Views) -> dict[int, Placement]:
    """Placements of views whose depth the parallax of the text itself refutes: it is of what is seen through glass."""
    found: dict[int, Placement] = {}
    left = np.flatnonzero(views.sure)
    while len(left) >= _FEWEST_VIEWS and views.keyframes_of(left) >= 2 and _wander(views, left):
        points = _meetings(views, left)
        allowed = _SIGMAS * views.noise[left]
        agree, scores = _agreement(views, left, angles(points, views.origins[left], views.directions[left]) / allowed)
        best = max(range(len(points)), key=lambda row: (scores[row], -row), default=-1)
        rows = left[agree[best]] if best >= 0 else left[:0]
        if len(rows) < _FEWEST_VIEWS or scores[best][0] < 2:
            break
        seen = views.origins[rows], views.directions[rows], views.noise[rows], views.shares(rows)
        place = triangulate(*seen, start=points[best])
        if place is not None and place.misfit <= _MISFIT and _refutes(place, views, rows):
            found |= placements_at(views, rows, np.zeros(0, np.intp), place, has_depth=False)
        left = np.setdiff1d(left, rows)
    return found


def _wander(views: Views, rows: Rows) -> bool:
    """Whether measured positions are farther apart than they are uncertain."""
    placements = [each for row in rows.tolist() if (each := views.placements[row]) is not None]
    apart = np.ptp(np.array([each.position for each in placements]), axis=0)
    return bool(np.linalg.norm(apart) > max(each.uncertainty for each in placements))


def _refutes(place: Triangulated, views: Views, rows: Rows) -> bool:
    """Whether a triangulated position refutes the depths of the views that agree on it.

    The middle of what was measured is too far off, and no one place of it explains what half of the keyframes saw. And
    it lies on one standing surface, along which it wanders as the camera moves: what is carried by someone wanders too,
    but its surface with it.
    """
    placements = [each for each in (views.placements[row] for row in rows.tolist()) if each is not None]
    measured = np.array([each.position for each in placements])
    normal = unit(np.mean([each.normal for each in placements], axis=0))
    if np.std(measured @ normal) > _PLANE_SPREAD:
        return False
    offset = np.average(measured, axis=0, weights=views.shares(rows)) - place.position
    spread = place.covariance + np.eye(3) * float(np.median([each.uncertainty for each in placements])) ** 2
    if float(offset @ np.linalg.solve(spread, offset)) < _REFUTED:
        return False
    explained = angles(measured, views.origins[rows], views.directions[rows]) < _SIGMAS * views.noise[rows]
    return max(views.keyframes_of(rows[each]) for each in explained) <= views.keyframes_of(rows) / 2
