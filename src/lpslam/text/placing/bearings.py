"""Where texts stand by the directions in which they were seen: for those without depth, and those behind glass.

A box without depth still says in which direction its text stands. Seen from several keyframes the directions meet: the
text is triangulated, as surely as the boxes' noise and the way between the views allow. What depth was measured, be it
of the surface around a sign, enters with the weight of its own certainty. Nothing is kept but what each keyframe saw,
so a text moves with its keyframes when the map is corrected.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import InstanceConfig
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.triangulation import Triangulated, angles, meetings, middles, on_plane, triangulate
from lpslam.text.remembering.similarity import comparison_key
from lpslam.text.types import Bearing, Placement, TextObservation, Vector3

Array = NDArray[np.float64]
Rows = NDArray[np.intp]

_BOX_STRAY = 0.1
"""How far the middle of a detected box strays from that of the text, as a share of the box's height."""

_POSE_NOISE = 0.003
"""Radians by which the poses of keyframes that see one text disagree: two pixels of a usual camera."""

_SIGMAS = 3.0
"""Standard deviations within which a direction agrees with a position."""

_RANGE_SHARE = 1.0 / 9.0
"""Largest uncertainty as a share of the distance. What directions say is even in inverse distance: at three standard
deviations the text is then no farther than half as far again as it is held to be, and never out of all sight."""

_FEWEST_VIEWS = 3
"""Views that must agree where there is no depth: any two directions of one plane meet somewhere."""

_FACING_SPREAD = 0.6
"""Spread of the tangent of the angle at which texts are seen: what the corners must say more surely than."""

_TRIED = 48
"""Most views of which pairs are tried; of more, evenly chosen ones."""

_REFUTED = 16.3
"""Chi-square of three degrees of freedom that chance exceeds once in a thousand times."""

_MISFIT = 2.0
"""Largest chi-square a degree of freedom of directions that agree; beyond it their noise is not what it should be."""

_ASSUMED = 3.0
"""Degrees of freedom that the noise assumed counts for beside what views of one spelling show. With three, errors of
texts whose depth is left out are within 1.6 times what is stated in nine of ten."""

_PLANE_SPREAD = 0.1
"""Metres, standard deviation, within which depths measured through glass lie on one standing surface."""


def bearing_of(box: Array, camera: PinholeCamera, keyframe_from_camera: Array) -> Bearing:
    """The directions of a box's corners (4, 2), raw pixels, and where they were seen from, in the keyframe's frame."""
    rays = camera.back_project(camera.undistort(box), np.ones(4)) @ keyframe_from_camera[:3, :3].T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    first, second, third, fourth = (_vector(ray) for ray in rays)
    return Bearing(_vector(keyframe_from_camera[:3, 3]), (first, second, third, fourth))


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
        views = _views([observations[row] for row in with_bearing], world_from_keyframe, config)
        for view, placement in _by_directions(views, config).items():
            pose = world_from_keyframe(observations[with_bearing[view]].keyframe)
            assert pose is not None
            placements[with_bearing[view]] = _moved(placement, inverse_transform(pose))
    return [replace(observations[row], placement=placements[row]) for row in sorted(placements)]


def _lacking(observations: Sequence[TextObservation], corners: Array) -> Array:
    """How far, radians (n,), a box's middle may be from that of the text for what was not read of it, or of more.

    A reading without its first letters has its middle farther on; as far as it is shorter than most, none can tell
    whether its box is, too.
    """
    letters = np.array([len(comparison_key(each.text)) for each in observations], np.float64)
    usual = max(float(np.median(letters)), 1.0)
    length = np.maximum(
        np.linalg.norm(corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3], axis=1),
        np.linalg.norm(corners[:, 3] + corners[:, 2] - corners[:, 0] - corners[:, 1], axis=1),
    )
    return np.asarray(0.5 * np.abs(letters / usual - 1.0) * length / 2.0, np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """What n observations of a class say in the world.

    Attributes:
        origins: (n, 3) metres, of the camera.
        directions: (n, 3) unit, to the middle of the text.
        corners: (n, 4, 3) unit.
        noise: (n,) radians, standard deviation of the directions: as assumed of any box, and for what it lacks.
        lacking: (n,) radians, what the box may lack of its text, or have more than it.
        spellings: (n,) numbers, the same where the same was read.
        keyframes: (n,) on which they hang.
        placements: by depth, in the world; None without.
        sure: (n,) whether depth placed them surely.
    """

    origins: Array
    directions: Array
    corners: Array
    noise: Array
    lacking: Array
    spellings: Rows
    keyframes: NDArray[np.int64]
    placements: list[Placement | None]
    sure: NDArray[np.bool_]

    def shares(self, rows: Rows) -> Array:
        """What each of some views counts, so that each keyframe counts once: its views share the errors of its pose."""
        _, inverse, counts = np.unique(self.keyframes[rows], return_inverse=True, return_counts=True)
        return np.asarray(1.0 / counts[inverse], np.float64)

    def keyframes_of(self, rows: Rows) -> int:
        """From how many keyframes some views are."""
        return len(np.unique(self.keyframes[rows]))


def _views(
    observations: Sequence[TextObservation], world_from_keyframe: KeyframePoses, config: InstanceConfig
) -> Views:
    origins, corners, placements = [], [], []
    for each in observations:
        pose = world_from_keyframe(each.keyframe)
        if pose is None or each.bearing is None:
            raise ValueError(f"an observation of keyframe {each.keyframe} has no place or no bearing")
        origins.append(transform_points(pose, np.array([each.bearing.origin]))[0])
        corners.append(np.array(each.bearing.corners) @ pose[:3, :3].T)
        placements.append(_moved(each.placement, pose) if each.placement is not None else None)
    # The surface around a text is none to measure its middle on: it may not be the text's.
    sure = [each is not None and each.uncertainty <= config.doubtful_uncertainty for each in placements]
    towards = [
        np.array(each.position) - origin if each is not None and is_sure else None
        for each, origin, is_sure in zip(placements, origins, sure, strict=True)
    ]
    rays = np.array(corners)
    heights = np.linalg.norm(rays[:, 3] + rays[:, 2] - rays[:, 0] - rays[:, 1], axis=1) / 2.0
    widths = np.linalg.norm(rays[:, 1] + rays[:, 2] - rays[:, 0] - rays[:, 3], axis=1) / 2.0
    lacking = _lacking(observations, rays)
    _, spellings = np.unique([comparison_key(each.text) for each in observations], return_inverse=True)
    return Views(
        origins=np.array(origins),
        directions=middles(rays, towards),
        corners=rays,
        noise=np.hypot(np.hypot(_BOX_STRAY * np.minimum(heights, widths), _POSE_NOISE), lacking),
        lacking=lacking,
        spellings=spellings,
        keyframes=np.array([each.keyframe for each in observations], np.int64),
        placements=placements,
        sure=np.array(sure, np.bool_),
    )


def _by_directions(views: Views, config: InstanceConfig) -> dict[int, Placement]:
    """Placements in the world of the views that depth does not place surely, and of those whose depth is refuted."""
    found = _overruled(views)
    left = np.flatnonzero(~views.sure)
    # What depth places surely is no proof of itself, but others may be directed at it.
    sure = np.setdiff1d(np.flatnonzero(views.sure), list(found))
    while len(left):
        here, there = _best(views, left, sure)
        if not len(here):
            break
        place = _fused(views, here, there)
        if place is not None and _is_sure_enough(place, views.origins[here], config):
            found |= _placements(views, here, there, place)
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
    agree = angles(points, views.origins[left], views.directions[left]) < allowed
    scores = [(views.keyframes_of(left[row]), int(row.sum())) if row.any() else (0, 0) for row in agree]
    # Depth says more than that directions cross: of equals it comes first.
    best = max(range(len(points)), key=lambda row: (scores[row], -row))
    here = left[agree[best]]
    has_depth = best < len(standing)
    if not has_depth and (scores[best][0] < 2 or len(here) < _FEWEST_VIEWS):
        return empty, empty
    near = [
        row
        for row in sure.tolist()
        if (other := views.placements[row]) is not None
        and np.linalg.norm(np.array(other.position) - points[best])
        < _SIGMAS * np.hypot(strayed[best], other.uncertainty)
    ]
    return here, np.array(near, np.intp)


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
    # What the surface around a sign says errs alike from everywhere: all of it counts as one. Own depth: a keyframe.
    doubtful = [row for row in here.tolist() if views.placements[row] is not None]
    shares = dict(zip(there.tolist(), views.shares(there), strict=True)) if len(there) else {}
    shares |= dict.fromkeys(doubtful, 1.0 / max(len(doubtful), 1))
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
        agree = angles(points, views.origins[left], views.directions[left]) < _SIGMAS * views.noise[left]
        scores = [(views.keyframes_of(left[row]), int(row.sum())) if row.any() else (0, 0) for row in agree]
        best = max(range(len(points)), key=lambda row: (scores[row], -row), default=-1)
        if best < 0 or scores[best][0] < 2 or scores[best][1] < _FEWEST_VIEWS:
            break
        rows = left[agree[best]]
        seen = views.origins[rows], views.directions[rows], views.noise[rows], views.shares(rows)
        place = triangulate(*seen, start=points[best])
        if place is not None and place.misfit <= _MISFIT and _refutes(place, views, rows):
            found |= _placements(views, rows, np.zeros(0, np.intp), place, has_depth=False)
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
    normal = _unit(np.mean([each.normal for each in placements], axis=0))
    if np.std(measured @ normal) > _PLANE_SPREAD:
        return False
    offset = np.average(measured, axis=0, weights=views.shares(rows)) - place.position
    spread = place.covariance + np.eye(3) * float(np.median([each.uncertainty for each in placements])) ** 2
    if float(offset @ np.linalg.solve(spread, offset)) < _REFUTED:
        return False
    explained = angles(measured, views.origins[rows], views.directions[rows]) < _SIGMAS * views.noise[rows]
    return max(views.keyframes_of(rows[each]) for each in explained) <= views.keyframes_of(rows) / 2


def _placements(
    views: Views, here: Rows, there: Rows, place: Triangulated, has_depth: bool = True
) -> dict[int, Placement]:
    """Placements of the views `here` at a position; they face as depth says, or as the corners do."""
    known = [views.placements[row] for row in np.concatenate([there, here]).tolist() if has_depth]
    normals = [each.normal for each in known if each is not None]
    normal = _unit(np.mean(normals, axis=0)) if normals else _facing(views, here, place)
    found = {}
    for row in here.tolist():
        own = views.placements[row] if has_depth else None
        facing = np.array(own.normal) if own is not None else normal
        corners = on_plane(views.origins[row], views.corners[row], place.position, facing)
        along = (corners[1] + corners[2] - corners[0] - corners[3]) / 2.0
        across = (corners[2] + corners[3] - corners[0] - corners[1]) / 2.0
        found[row] = Placement(
            position=_vector(place.position),
            normal=_vector(facing),
            baseline=_vector(_unit(along)),
            width=float(np.linalg.norm(along)),
            height=float(np.linalg.norm(across)),
            uncertainty=place.uncertainty,
        )
    return found


def _facing(views: Views, rows: Rows, place: Triangulated) -> Array:
    """The normal (3,) as the corners tell it, each triangulated; as far as they do not, towards the viewers."""
    ahead = _unit((place.position - views.origins[rows]).mean(axis=0))
    seen = views.noise[rows] * np.sqrt(2.0), views.shares(rows)
    corners = [
        triangulate(views.origins[rows], views.corners[rows, corner], *seen, start=place.position)
        for corner in range(4)
    ]
    found = [each for each in corners if each is not None]
    if len(found) < 4 or views.keyframes_of(rows) < 2:
        return -ahead
    positions = np.array([each.position for each in found])
    variance = float(ahead @ sum(each.covariance for each in found) @ ahead) / 4.0
    sides = []
    for ends, starts in (((1, 2), (0, 3)), ((2, 3), (0, 1))):
        side = (positions[list(ends)] - positions[list(starts)]).sum(axis=0) / 2.0
        level = side - ahead * (side @ ahead)
        size = max(float(np.linalg.norm(level)), 1e-9)
        told = _FACING_SPREAD**2 / (_FACING_SPREAD**2 + variance / size**2)
        sides.append(level / size + ahead * (told * float(side @ ahead) / size))
    normal = _unit(np.cross(sides[1], sides[0]))
    return normal if normal @ ahead < 0.0 else -normal


def _moved(placement: Placement, target_from_source: Array) -> Placement:
    rotation = target_from_source[:3, :3]
    return replace(
        placement,
        position=_vector(transform_points(target_from_source, np.array([placement.position]))[0]),
        normal=_vector(rotation @ np.array(placement.normal)),
        baseline=_vector(rotation @ np.array(placement.baseline)),
    )


def _unit(vector: Array) -> Array:
    return np.asarray(vector / max(float(np.linalg.norm(vector)), 1e-12), np.float64)


def _vector(array: Array) -> Vector3:
    return float(array[0]), float(array[1]), float(array[2])
