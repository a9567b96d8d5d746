"""The places of long-term texts: where each class stands (III-H), and what it says there."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import exp

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.language.model import Reading
from lpslam.language.naming.channel import evidence_of, log_likelihood, paint_key
from lpslam.language.naming.voting import vote
from lpslam.text.placing.bearings import placed
from lpslam.text.placing.columns import WorldSightings
from lpslam.text.placing.instances import KeyframePoses, split_places, trimmed_position
from lpslam.text.placing.seen_through import without_seen_through
from lpslam.text.placing.views import unit
from lpslam.text.remembering.ends import is_lone_character, is_of_rings, says_a_word, says_little
from lpslam.text.remembering.evidence import looks_of, readings_of, wholes_of
from lpslam.text.remembering.known_names import is_spelt_as_names
from lpslam.text.remembering.memory import TextClass
from lpslam.text.remembering.similarity import IDEOGRAPHS
from lpslam.text.types import TextObservation

Array = NDArray[np.float64]

# Ids of places are their class's times this, plus their number.
PLACES_OF_A_CLASS = 1000
# A text that is short, or neither says a word nor is spelt as names are, is only believed if some reading of it is
# likelier right than wrong, any other if one may be right at all: ornaments, goods and lamps are read badly each time.
_LIKELY, _POSSIBLE = 0.5, 0.2
# A short name that is less sure is one of an ornament: of 21 such names of drawn lettering none was right.
_UNSURE = 0.35
# Readings of a name that are independent of each other, at most.
_INDEPENDENT = 2.0
# Share of its letters, each in its place, that a slip of a name has at least.
_SAME_LETTERS = 0.75
# Fewest letters of a piece that tells of an end.
_FEWEST = 2
# Letter heights by which the middle of a part may lie beside that of the whole: boxes are drawn as loosely.
_SAME_MIDDLE = 0.5
# Most log odds by which one name is ahead of another that are believed.
_SUREST = 7.0


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """One class at one place.

    Attributes:
        id: class id times 1000 plus the place's number among those of its class.
        name: the class's name, or what is read here if that is something else.
        variants: spellings read here and how often.
        position: (3,) metres, world.
        normal, baseline: (3,) unit, world.
        spread: metres, root mean square distance of kept observations.
        width, height: metres.
        positions_by_frame, normals_by_frame: for each frame that saw it, the (3,) world position and normal seen then.
        grounds_by_frame: for each frame, the (red, green, blue) of the surface around it, where it is known.
        observations: number of sightings.
        evidence: sum of their confidences.
        confidence: 0 to 1, how surely the name is exactly what is painted.
        inks_by_frame, bare_by_frame: for each frame, the (red, green, blue) of its letters, and of its ground where it
            is least like them, where they are known.
        sizes_by_frame: for each frame, metres of width and height.
        clear: how far its ground goes on above, right of, below and left of it, in letter heights; None where unknown.
        is_text: whether it is likelier a whole text than a piece of one, or than none.
        seen: the sightings.
        uncertainty: metres, standard deviation of the position: the median of the sightings'.
    """

    id: int
    name: str
    variants: dict[str, int]
    position: Array
    normal: Array
    baseline: Array
    spread: float
    width: float
    height: float
    positions_by_frame: dict[int, Array]
    normals_by_frame: dict[int, Array]
    grounds_by_frame: dict[int, tuple[int, int, int]]
    observations: int
    evidence: float
    confidence: float
    inks_by_frame: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    bare_by_frame: dict[int, tuple[int, int, int]] = field(default_factory=dict)
    sizes_by_frame: dict[int, tuple[float, float]] = field(default_factory=dict)
    clear: Array | None = None
    is_text: bool = True
    seen: tuple[TextObservation, ...] = ()
    uncertainty: float = 0.0

    @property
    def letter(self) -> float:
        """Metres: a line is as high as its letters, one that runs downwards as wide."""
        return min(self.width, self.height)

    @property
    def down(self) -> Array:
        """(3,) unit, across the direction of reading, along the surface."""
        # Written out: numpy.cross takes twenty times as long for one vector.
        (x, y, z), (u, v, w) = self.normal.tolist(), self.baseline.tolist()
        return np.array([z * v - y * w, x * w - z * u, y * u - x * v])


def places_of_class(
    text_class: TextClass, world_from_keyframe: KeyframePoses, config: InstanceConfig, memory: MemoryConfig
) -> list[Place]:
    """Find the places of one class at which there is a whole text; none when it was never placed."""
    return [each for each in read_places(text_class, world_from_keyframe, config, memory) if each.is_text]


def read_places(
    text_class: TextClass, world_from_keyframe: KeyframePoses, config: InstanceConfig, memory: MemoryConfig
) -> list[Place]:
    """The same with those at which what is read is no text, or a piece: pieces of patterns tell of each other.

    A place seen but once is a slip of depth or of reading, unless the class has no other.
    """
    known = [each for each in text_class.observations if world_from_keyframe(each.keyframe) is not None]
    sightings = WorldSightings.of(placed(known, world_from_keyframe, config), world_from_keyframe)
    for leave_out in (_doubtful, _carried):
        sightings = sightings[~leave_out(sightings, config)]
    if not len(sightings):
        return []
    groups = split_places(sightings.positions, sightings.normals, sightings.frames, config)
    seen_at = without_seen_through([sightings[rows] for rows in groups], world_from_keyframe)
    enough = min(config.min_observations, max(map(len, seen_at)))

    places = []
    for number, seen in enumerate(seen_at):
        if len(seen) < enough or not _is_large_enough(seen, config):
            continue
        name, sure = _name_here(text_class, seen, len(seen_at) > 1, memory)
        sure, whole = min(sure, _most_sure(name, text_class)), _probability_whole(name, seen)
        place = _place(text_class.id * PLACES_OF_A_CLASS + number, name, sure * whole, seen, config)
        is_text = whole >= config.least_whole and not _is_hardly_text(name, sure, seen, text_class)
        places.append(replace(place, is_text=is_text))
    return places


def _place(key: int, name: str, sure: float, seen: WorldSightings, config: InstanceConfig) -> Place:
    """The place that some sightings of a class are, by an id and the name that stands there."""
    whole = seen[_show_all_of(name, seen)]
    position, kept = trimmed_position(whole.positions, config.rounds, config.drop_share)
    whole = whole[kept]
    trusted = whole[_on_the_side_seen_most(whole.normals)]
    normal = unit(trusted.normals.mean(axis=0))
    baseline = unit(trusted.baselines.mean(axis=0))
    width, height = np.median(trusted.sizes, axis=0).tolist()
    frames = seen.frames.tolist()
    return Place(
        id=key,
        name=name,
        variants=seen.variants,
        position=position,
        normal=normal,
        baseline=unit(baseline - normal * (baseline @ normal)),
        spread=float(np.sqrt(np.mean(np.sum((whole.positions - position) ** 2, axis=1)))),
        width=width,
        height=height,
        positions_by_frame=dict(zip(frames, seen.positions, strict=True)),
        normals_by_frame=dict(zip(frames, seen.normals, strict=True)),
        grounds_by_frame={each.frame: each.ground for each in seen.observations if each.ground is not None},
        observations=len(seen),
        evidence=sum(each.confidence for each in seen.observations),
        confidence=sure,
        inks_by_frame={each.frame: each.ink for each in seen.observations if each.ink is not None},
        bare_by_frame={each.frame: each.bare for each in seen.observations if each.bare is not None},
        sizes_by_frame={frame: (size[0], size[1]) for frame, size in zip(frames, seen.sizes.tolist(), strict=True)},
        clear=_clear(seen.observations),
        seen=tuple(seen.observations),
        uncertainty=float(np.median([each.place.uncertainty for each in trusted.observations])),
    )


def _show_all_of(name: str, sightings: WorldSightings) -> NDArray[np.bool_]:
    """Which sightings (n,) show the whole name: those that read it, and others whose middle is its middle too.

    The middle of a part lies off that of the whole by half of what is missing.
    """
    key = paint_key(name)
    reads = np.array([paint_key(each.text) == key for each in sightings.observations], np.bool_)
    if reads.all() or not reads.any():
        return np.ones(len(sightings), np.bool_)
    width, height = np.median(sightings.sizes[reads], axis=0)
    missing = np.abs(sightings.sizes[:, 0] - width)
    return np.asarray(reads | (0.5 * missing <= _SAME_MIDDLE * min(width, height)), np.bool_)


def _most_sure(name: str, text_class: TextClass) -> float:
    """How sure a name may be at most: its readings, however many, are worth no more than so many that are independent.

    What is no text, or is half hidden, is read alike again and again, and poorly each time. Of a name that was put
    together from readings the best of them counts.
    """
    key = paint_key(name)
    own = [each.best for each in text_class.looks if paint_key(each.text) == key]
    best = max(own or [each.best for each in text_class.looks], default=_SUREST)
    return float(1.0 - (1.0 + exp(min(best, _SUREST))) ** -_INDEPENDENT)


def _probability_whole(name: str, sightings: WorldSightings) -> float:
    """The probability, 0 to 1, that nothing more is painted before or behind a name, by the readings that say it.

    So do slips of it with as many letters, and pieces of it of the end that they have. Where an older map does not
    tell, or nothing that was read is just as long, nothing is held against it.
    """
    key = paint_key(name)
    told = [(paint_key(each.text), each.whole) for each in sightings.observations]
    known = [whole for read, whole in told if _is_as_long(read, key)]
    if not known or None in known:
        return 1.0
    pieces = [(read, whole) for read, whole in told if whole is not None and _FEWEST <= len(read) < len(key)]
    before = [whole[0] for read, whole in pieces if key.startswith(read)]
    behind = [whole[1] for read, whole in pieces if key.endswith(read)]
    first, last = zip(*(each for each in known if each is not None), strict=True)
    return float(max([*first, *before]) * max([*last, *behind]))


def _is_as_long(key: str, name: str) -> bool:
    """Whether a reading is a name, or one with as many letters of which at least three in four are the same."""
    return len(key) == len(name) and sum(a == b for a, b in zip(key, name, strict=True)) >= _SAME_LETTERS * len(name)


def _clear(observations: Sequence[TextObservation]) -> Array | None:
    known = [each.clear for each in observations if each.clear is not None]
    return np.asarray(np.median(known, axis=0), np.float64) if known else None


def _is_large_enough(sightings: WorldSightings, config: InstanceConfig) -> bool:
    """Whether a text was once seen as large as it takes to be read right."""
    latin = sum(any(ch.isalpha() and ch < IDEOGRAPHS for ch in each.text) for each in sightings.observations)
    is_latin = 2 * latin >= len(sightings)
    needed = config.min_landmark_height if is_latin else config.min_landmark_height_ideographs
    return bool(max(each.letter_height for each in sightings.observations) >= needed)


def _is_hardly_text(name: str, sure: float, sightings: WorldSightings, text_class: TextClass) -> bool:
    """Whether a text was read so badly or so differently, for its length, that it is likelier no text at all."""
    right = [each.right for each in sightings.observations if each.right is not None]
    best = max(right, default=1.0)
    if (sure < _UNSURE and best < _POSSIBLE) or is_lone_character(name) or is_of_rings(name):
        return True
    # Where nothing is unsure, nobody asks the tables of words, which take a second to read.
    if sure >= _UNSURE and best >= _LIKELY:
        return False
    # What was read well elsewhere is a name.
    own = [each.right or 0.0 for each in text_class.observations if each.text == name]
    if max([best, *own]) < _LIKELY and not says_a_word(name) and not is_spelt_as_names(name):
        return True
    return says_little(name) or says_little(next(iter(sightings.variants)))


def _doubtful(sightings: WorldSightings, config: InstanceConfig) -> NDArray[np.bool_]:
    """Which sightings (n,) are much less certain than others near: those say where the text stands."""
    uncertain = np.array([each.place.uncertainty for each in sightings.observations]) > config.doubtful_uncertainty
    if uncertain.all() or not uncertain.any():
        return np.zeros(len(sightings), np.bool_)
    distances, _ = KDTree(sightings.positions[~uncertain]).query(sightings.positions)
    return np.asarray(uncertain & (distances < config.doubtful_distance), np.bool_)


def _carried(sightings: WorldSightings, config: InstanceConfig) -> NDArray[np.bool_]:
    """Which sightings (n,) move along; visit by visit, since someone may walk by again later.

    Before they are split into places: where few are read, a walker's fall into several.
    """
    times = np.array([each.timestamp for each in sightings.observations])
    # Of a text that comes into view bit by bit the middle moves, and one end stays.
    halves = sightings.baselines * sightings.sizes[:, :1] / 2.0
    tracks = [sightings.positions + side * halves for side in (0.0, -1.0, 1.0)]
    ordered = np.argsort(times, kind="stable")
    visits = np.split(ordered, np.flatnonzero(np.diff(times[ordered]) > config.visit_pause) + 1)
    carried = np.zeros(len(sightings), np.bool_)
    for visit in visits:
        carried[visit] = all(_is_carried(each[visit], times[visit], config) for each in tracks)
    return carried


def _is_carried(positions: Array, timestamps: Array, config: InstanceConfig) -> bool:
    """Whether positions (n, 3) move steadily on with rising time (n,) seconds: a text on someone who walks by.

    Drift moves a text too, but slowly; noise moves it fast, but not far and not steadily; and of equal signs in a row
    one is read after the other, but each stands while it is read.
    """
    if len(positions) < 2 or timestamps[-1] == timestamps[0]:
        return False
    elapsed = timestamps - timestamps.mean()
    velocity = elapsed @ (positions - positions.mean(axis=0)) / float(elapsed @ elapsed)
    speed = float(np.linalg.norm(velocity))
    distance = speed * float(np.ptp(timestamps))
    if speed <= config.carried_speed or distance <= config.carried_distance:
        return False
    strayed = np.linalg.norm(positions - positions.mean(axis=0) - elapsed[:, None] * velocity, axis=1)
    moments = np.flatnonzero(np.diff(timestamps) > 0.0)
    steps = np.diff(positions, axis=0)[moments] @ (velocity / speed) / np.diff(timestamps)[moments]
    return bool(np.sqrt(np.mean(strayed**2)) < 0.25 * distance and np.median(steps) > 0.5 * speed)


def _on_the_side_seen_most(normals: Array) -> NDArray[np.bool_]:
    """Of a sign that was seen from both sides, which sightings (n,) are of the side that was seen more often."""
    same_side = normals @ normals.T > 0.0
    return np.asarray(same_side[int(same_side.sum(axis=1).argmax())], np.bool_)


def _name_here(
    text_class: TextClass, sightings: WorldSightings, stands_elsewhere: bool, config: MemoryConfig
) -> tuple[str, float]:
    """The class's name, unless it stands elsewhere too and another one explains what was read here; and how sure it is.

    All places vote for the name together, each for what hangs there: WASHROOM and BATHROOM, MEETING ROOM 1 and 2 may
    share a class, never a door.
    """
    naming = text_class.naming
    name, sure = (naming.name, naming.confidence) if naming is not None else (text_class.name, 0.5)
    return _held_to(sightings.observations, name, sure, config) if stands_elsewhere else (name, sure)


def named_together(place: Place, others: Sequence[Place], config: MemoryConfig) -> Place:
    """A place of which some readings are of other classes: it has the surest of their names that all readings bear."""
    surest = max((place, *others), key=lambda each: each.confidence)
    if surest is place:
        return place
    seen = sorted((each for some in (place, *others) for each in some.seen), key=lambda each: each.timestamp)
    name, sure = _held_to(seen, surest.name, surest.confidence, config)
    return replace(place, name=name, confidence=sure)


def _held_to(seen: Sequence[TextObservation], name: str, sure: float, config: MemoryConfig) -> tuple[str, float]:
    """A name that was found elsewhere, or another that explains some sightings better; and how sure it is."""
    key = paint_key(name)
    here = evidence_of(readings_of(looks_of(seen), config, wholes_of(seen)))
    if not here or not key:
        return name, sure
    by_class = log_likelihood(key, here, _looks)
    # That another name is just this one is as improbable as a slip of an unsure reader would be. Which of them it is,
    # what was read here says alone: pieces of it are likelier to be like any name than the whole is.
    own = {each: log_likelihood(each.key, here, _looks) for each in here}
    ahead = {
        each: score + log_likelihood(key, [replace(each, right=0.5, weight=1.0)], _looks) - by_class
        for each, score in own.items()
        # Where a mark was read for a letter, there was one.
        if _looks(each.key) != _looks(key) and not (each.marks and each.key in key)
    }
    best = max(ahead, key=lambda each: own[each], default=None)
    most = max(ahead.values(), default=-_SUREST)
    if best is None or most <= 0.0:
        # What other places say is of other doors: if they contradict the name, what was read here does not.
        said = next((each.right for each in here if each.key == key), 0.0)
        return name, max(sure, said / (1.0 + exp(max(most, -_SUREST))))
    same = [Reading(each.text, 1, each.confidence) for each in seen if paint_key(each.text) == best.key]
    return vote(same).text, best.right / (1.0 + exp(-min(most, _SUREST)))


def _looks(text: str) -> str:
    return text.translate(_ALIKE)


_ALIKE = str.maketrans("015826!|", "olsbzgll")
"""Digits and strokes as which letters are read, and the other way round."""
