"""Texts as they stand to one another: how a place is known again by its signs, and how it is told from its like."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import AdviceConfig
from lpslam.text.placing.columns import WorldSightings
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.views import unit
from lpslam.text.remembering.similarity import comparison_key, is_fragment, similarity
from lpslam.text.types import TextObservation

Array = NDArray[np.float64]

# Readings of one text that differ by no more than one letter in five say nearly the same.
NEARLY_THE_SAME = 0.8

# Spellings of a text that are compared with another's.
_SPELLINGS = 3

# Most pairs of a new text and an old one that are tried together, the rarest texts first; work grows with the square.
_PAIRS = 48

# Texts fill the same spot when their middles are nearer than this share of the larger, along the line and across.
_SPOT_SHARE = 0.5
# Metres by which they may stand before one another, and ...
_SPOT_DEPTH = 0.15
# ... the factor by which their heights may differ: else they are not one board.
_SIZE_RATIO = 2.0

# Metres that a radian counts as, when the nearest of several views is wanted.
_LEVER = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A text at its place, from all that was read of it there.

    Attributes:
        text_class: id of its class.
        spellings: most frequent first.
        sightings: how often it was read.
        confidence: mean of the readings.
        unanimity: 0 to 1, share of the readings that are nearly the commonest one.
        position: (3,) metres, world of its sub-map.
        normal, baseline: (3,) unit.
        width, height: metres.
    """

    text_class: int
    spellings: tuple[str, ...]
    sightings: int
    confidence: float
    unanimity: float
    position: Array
    normal: Array
    baseline: Array
    width: float
    height: float

    def moved(self, transform: Array) -> "Seen":
        """The same text in another frame, by a rigid 4×4."""
        return Seen(
            self.text_class,
            self.spellings,
            self.sightings,
            self.confidence,
            self.unanimity,
            transform_points(transform, self.position[None])[0],
            transform[:3, :3] @ self.normal,
            transform[:3, :3] @ self.baseline,
            self.width,
            self.height,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Constellation:
    """Texts that stand to one another as texts read before do.

    Attributes:
        rarity: sum over the texts of one over the number of places where each stands.
        old_from_new_world: 4×4, rigid, from the world in which they stand now to the one where they were read before.
    """

    rarity: float
    old_from_new_world: Array


def said_most_alike(text: str, signs: Sequence[Seen]) -> list[Seen]:
    """Of the signs that a text may be, those whose commonest spelling is most like it; all that say the same.

    Coach 21 and Coach 22, or a row of numbered pillars, are of one class, since they differ by a letter, as slips do.
    """
    key = comparison_key(text)
    alike = [similarity(key, comparison_key(sign.spellings[0])) for sign in signs]
    most = max(alike, default=0.0)
    return [sign for sign, each in zip(signs, alike, strict=True) if each == most]


def seen_texts(
    sightings: Sequence[tuple[int, TextObservation]], world_from_keyframe: KeyframePoses, config: AdviceConfig
) -> list[Seen]:
    """Gather sightings of texts, all in one world, into texts at their places.

    Args:
        sightings: (class, observation).
        world_from_keyframe: by the keyframe's id.
        config: how far sightings of one text may be apart.
    """
    if not sightings:
        return []
    classes = np.array([text_class for text_class, _ in sightings])
    placed = WorldSightings.of([observation for _, observation in sightings], world_from_keyframe)
    positions, normals = placed.positions, placed.normals
    texts = []
    left = np.arange(len(sightings))
    while len(left):
        first = left[0]
        here = (
            (classes[left] == classes[first])
            & (np.linalg.norm(positions[left] - positions[first], axis=1) < config.same_place)
            & (normals[left] @ normals[first] > 0.0)
        )
        rows, left = left[here], left[~here]
        texts.append(_text(int(classes[first]), placed[rows]))
    return texts


def _text(text_class: int, seen: WorldSightings) -> Seen:
    counts = seen.variants
    spellings = sorted(counts, key=lambda text: (-counts[text], text))
    key = comparison_key(spellings[0])
    same = [count for text, count in counts.items() if similarity(comparison_key(text), key) >= NEARLY_THE_SAME]
    width, height = np.median(seen.sizes, axis=0).tolist()
    return Seen(
        text_class,
        tuple(spellings[:_SPELLINGS]),
        len(seen),
        float(np.mean([each.confidence for each in seen.observations])),
        sum(same) / len(seen),
        np.median(seen.positions, axis=0),
        unit(seen.normals.mean(axis=0)),
        unit(seen.baselines.mean(axis=0)),
        width,
        height,
    )


def likeness(one: Seen, other: Seen) -> float:
    """The greatest Eq. 3 similarity among the spellings of two texts; 1 when one is a fragment of the other."""
    return max(
        1.0 if is_fragment(a, b) or is_fragment(b, a) else similarity(comparison_key(a), comparison_key(b))
        for a in one.spellings
        for b in other.spellings
    )


# Knowing again -----------------------------------------------------------------------------------------------------


def constellations(new: Sequence[Seen], old: Sequence[Seen], config: AdviceConfig) -> Iterator[Constellation]:
    """Find texts that were read before in the same arrangement: two boards or more that say different things.

    Args:
        new: read lately, in one world.
        old: read before, in one world.
        config: tolerances, and how rare the texts must be.

    Yields:
        Arrangements that no text is shared between, the rarest texts first.
    """
    places = {text.text_class: 0 for text in old}
    for text in old:
        places[text.text_class] += 1
    pairs = [(a, b) for a in new for b in old if a.text_class == b.text_class]
    pairs = sorted(pairs, key=lambda pair: places[pair[0].text_class])[:_PAIRS]
    if len(pairs) < 2:
        return
    weights = np.array([1.0 / places[a.text_class] for a, _ in pairs])
    agree = _agreeing(pairs, config) & _different([a for a, _ in pairs], config)
    while True:
        groups = [_group(row, pairs, weights, agree) for row in range(len(pairs))]
        rarity = [float(weights[group].sum()) if len(group) > 1 else 0.0 for group in groups]
        best = int(np.argmax(rarity))
        if rarity[best] < config.min_rarity:
            return
        group = groups[best]
        transform = _alignment([pairs[row] for row in group])
        off = transform_points(transform, np.array([pairs[row][0].position for row in group]))
        off -= np.array([pairs[row][1].position for row in group])
        if np.linalg.norm(off, axis=1).max() <= config.distance_tolerance:
            yield Constellation(rarity[best], transform)
        agree[group] = False
        agree[:, group] = False


def _agreeing(pairs: Sequence[tuple[Seen, Seen]], config: AdviceConfig) -> NDArray[np.bool_]:
    """(n, n) whether two pairs of new and old text stand to one another alike: apart, facing and across."""
    aspects = []
    for side in (0, 1):
        positions = np.array([pair[side].position for pair in pairs])
        normals = np.array([pair[side].normal for pair in pairs])
        way = positions[None] - positions[:, None]
        distance = np.linalg.norm(way, axis=2)
        way /= np.maximum(distance, 1e-9)[..., None]
        aspects.append((distance, normals @ normals.T, np.einsum("ijk,ik->ij", way, normals)))
    (distance, facing, across), (old_distance, old_facing, old_across) = aspects
    similar = np.abs(distance - old_distance) <= config.distance_tolerance
    for one, other in ((facing, old_facing), (across, old_across)):
        difference = np.arccos(np.clip(one, -1, 1)) - np.arccos(np.clip(other, -1, 1))
        similar &= np.abs(difference) <= np.radians(config.facing_tolerance)
    return np.asarray(similar & similar.T & (distance >= config.board_size))


def _different(texts: Sequence[Seen], config: AdviceConfig) -> NDArray[np.bool_]:
    """(n, n) whether two texts say different things, so that neither may be a reading of the other."""
    by_class: dict[int, list[int]] = {}
    for row, text in enumerate(texts):
        by_class.setdefault(text.text_class, []).append(row)
    result = np.zeros((len(texts), len(texts)), np.bool_)
    for (_, rows), (_, others) in combinations(by_class.items(), 2):
        if likeness(texts[rows[0]], texts[others[0]]) < config.alike:
            result[np.ix_(rows, others)] = True
            result[np.ix_(others, rows)] = True
    return result


def _group(row: int, pairs: Sequence[tuple[Seen, Seen]], weights: Array, agree: NDArray[np.bool_]) -> NDArray[np.intp]:
    """A pair and those that agree with it and with one another, one a class, the rarest first."""
    group = [row]
    for other in np.argsort(-weights, kind="stable").tolist():
        if agree[group, other].all() and all(pairs[other][0].text_class != pairs[k][0].text_class for k in group):
            group.append(other)
    return np.array(group, np.intp)


def _alignment(pairs: Sequence[tuple[Seen, Seen]]) -> Array:
    """4×4, rigid, that lays new texts over old ones best (Kabsch), with a point before and beside each for facing."""
    new, old = (
        np.concatenate([[text.position, text.position + text.normal, text.position + text.baseline] for text in side])
        for side in zip(*pairs, strict=True)
    )
    new_middle, old_middle = new.mean(axis=0), old.mean(axis=0)
    u, _, vt = np.linalg.svd((old - old_middle).T @ (new - new_middle))
    turn = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
    transform = np.eye(4)
    transform[:3, :3], transform[:3, 3] = turn, old_middle - turn @ new_middle
    return transform


def nearest_views(world_from_camera: Array, world_from_keyframes: Array, config: AdviceConfig) -> NDArray[np.intp]:
    """Rows of the keyframes (n, 4, 4) that look about where a camera (4×4) does, nearest first."""
    metres = np.linalg.norm(world_from_keyframes[:, :3, 3] - world_from_camera[:3, 3], axis=1)
    cosine = world_from_keyframes[:, :3, 2] @ world_from_camera[:3, 2]
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    near = np.flatnonzero((metres <= config.view_distance) & (turn <= np.radians(config.view_turn)))
    return near[np.argsort((metres + _LEVER * turn)[near], kind="stable")]


# Telling apart -----------------------------------------------------------------------------------------------------


def contradict(new: Sequence[Seen], old: Sequence[Seen], config: AdviceConfig) -> bool:
    """Whether texts, both sides in one world, cannot be of one place: what fills the same spots says other things.

    One text that agrees outweighs all others, and where one side was not read nothing is said. Signs get repainted and
    readers slip, so several boards must contradict.
    """
    new, old = ([text for text in side if _is_sure(text, config)] for side in (new, old))
    contradicting: list[Seen] = []
    for text in new:
        around = [each for each in old if _is_near(text, each, config)]
        likest = max((likeness(text, each) for each in around), default=0.0)
        if likest >= config.alike:
            return False
        is_another_board = all(
            np.linalg.norm(text.position - each.position) >= config.board_size for each in contradicting
        )
        if likest < config.unlike and is_another_board and any(_fill_one_spot(text, each) for each in around):
            contradicting.append(text)
    return len(contradicting) >= config.contradictions


def agree(new: Sequence[Seen], old: Sequence[Seen], config: AdviceConfig) -> bool:
    """Whether one of some texts, read often enough, says what stood there before."""
    return any(
        _is_near(text, other, config) and likeness(text, other) >= config.alike
        for text in new
        if text.sightings >= config.min_sightings
        for other in old
    )


def _is_sure(text: Seen, config: AdviceConfig) -> bool:
    return (
        text.sightings >= config.veto_sightings
        and text.confidence >= config.veto_confidence
        and text.unanimity >= config.veto_unanimity
    )


def _is_near(one: Seen, other: Seen, config: AdviceConfig) -> bool:
    return float(np.linalg.norm(one.position - other.position)) <= config.same_place + max(one.width, other.width) / 2


def _fill_one_spot(one: Seen, other: Seen) -> bool:
    """Whether two texts would be painted over one another; the lines of a bilingual board are not."""
    across = other.position - one.position
    if one.normal @ other.normal < 0.7 or not 1 / _SIZE_RATIO <= one.height / max(other.height, 1e-6) <= _SIZE_RATIO:
        return False
    down = np.cross(-one.normal, one.baseline)
    height, width = max(one.height, other.height), max(one.width, other.width)
    return bool(
        abs(across @ down) <= _SPOT_SHARE * height
        and abs(across @ one.baseline) <= _SPOT_SHARE * width
        and abs(across @ one.normal) <= _SPOT_DEPTH
    )
