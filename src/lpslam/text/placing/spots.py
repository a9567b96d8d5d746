"""Which classes have been read at a spot in the world.

The similarity of strings says which readings may be homologous; that they were read at the same spot is evidence of
another kind, and lets readings join a class that resemble it less.
"""

from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import ReadingConfig
from lpslam.text.reading.legibility import SeenSize
from lpslam.text.remembering.known_names import LINE_ENDS, WORD_ENDS
from lpslam.text.remembering.similarity import comparison_key, similarity
from lpslam.text.types import Placement

Array = NDArray[np.float64]

# Sightings remembered; the oldest go first. Positions are those of the time, so old ones may be out of place.
_CAPACITY = 16384

# Texts overlap when their middles are nearer than this share of the longer along the line, and of the higher across.
_ALONG_SHARE = 0.5
_ACROSS_SHARE = 0.6

# What has letters so many times as large is another text: two lines in one box, or small print below a column.
_ALIKE = 1.6

# Where readings go on differing, so many times the sightings settle a text all the same: more would say no more.
_PATIENCE = 2

# A class with this share of a spot's sightings is what stands there; the others are slips.
_LEADING_SHARE = 0.8

# Eq. 3 similarity from which two spellings are slips of each other.
_SLIPS = 0.75

# Letter heights, and shares of the length, by which boxes of one text end in different places.
_STRAY, _STRAY_SHARE = 0.25, 0.02


class Spots:
    """A table of sightings: class, position, facing and size in the world as it was known then."""

    def __init__(self) -> None:
        self._classes = np.zeros(0, np.int64)
        self._keys = np.zeros(0, object)
        self._positions = np.zeros((0, 3))
        self._normals = np.zeros((0, 3))
        self._baselines = np.zeros((0, 3))
        self._sizes = np.zeros((0, 2))
        self._seen = np.zeros((0, 2))
        self._rooms = np.zeros((0, 2))

    def classes_at(self, placement: Placement, world_from_keyframe: Array) -> set[int]:
        """The classes read before where this text stands."""
        return set(self._classes[self._here(placement, world_from_keyframe)].tolist())

    def spellings_at(self, placement: Placement, world_from_keyframe: Array) -> set[str]:
        """The comparison keys of what was read where this text stands."""
        return set(self._keys[self._here(placement, world_from_keyframe)].tolist())

    def is_as_long_at(self, text: str, placement: Placement, world_from_keyframe: Array) -> bool:
        """Whether a text begins and ends where one does that was read here as a whole with no more letters, much alike.

        Then all of it is in view, wherever the view ends.
        """
        whole = self._here(placement, world_from_keyframe) & (self._rooms >= LINE_ENDS).all(axis=1)
        key = comparison_key(text)
        alike = [len(each) <= len(key) and similarity(each, key) >= _SLIPS for each in self._keys[whole].tolist()]
        if not any(alike):
            return False
        position, baseline, normal = in_world(placement, world_from_keyframe)
        # A text that runs downwards ends below.
        axes = np.stack([baseline, np.cross(normal, baseline)], axis=1)
        sizes, own = self._sizes[whole][alike], np.array([placement.width, placement.height])
        offsets = np.abs((self._positions[whole][alike] - position) @ axes)
        apart = np.median(offsets + np.abs(sizes - own) / 2.0, axis=0)
        return bool(apart.max() <= _STRAY * own.min() + _STRAY_SHARE * own.max())

    def settled_at(
        self,
        placement: Placement,
        world_from_keyframe: Array,
        seen: SeenSize,
        is_sure: Callable[[int], bool],
        config: ReadingConfig,
        room: Callable[[], tuple[float, float]] = lambda: (0.0, 0.0),
    ) -> int | None:
        """The class read here again and again, and nearly as well as it is seen now; None where there is none.

        Args:
            placement, world_from_keyframe: of the text.
            seen: how large it is seen now.
            is_sure: whether the name of a class is sure already: half as many readings are enough then.
            config: how often a text must have been read alike; twice as often is enough where readings differ, and as
                often again where they are of several classes.
            room: gives how far the view goes on before and behind it now, in heights of its box; asked where an end
                was in no view yet.
        """
        here = self._here(placement, world_from_keyframe)
        classes, counts = np.unique(self._classes[here], return_counts=True)
        if not len(classes):
            return None
        leading = int(classes[counts.argmax()])
        # A piece of the text may have been read often from afar: how well others were seen does not settle it.
        own = here & (self._classes == leading)
        is_known = is_sure(leading)
        if self._is_better(own, placement, seen, config) or self._shows_an_end(own, room):
            return None
        fewer = -(-config.settled_sightings // _PATIENCE)
        sightings = fewer if is_known else config.settled_sightings
        if counts.max() < sightings:
            return None
        # Of a name that is not sure, what was read from afar says less than what would be read now.
        if not is_known and self._count_as_good(own, seen, config) < min(fewer, sightings):
            return None
        if counts.max() < _LEADING_SHARE * counts.sum():
            return leading if counts.max() >= _PATIENCE**2 * sightings else None
        alike = Counter(self._keys[here].tolist()).most_common(1)[0][1]
        return leading if alike >= sightings or counts.max() >= _PATIENCE * sightings else None

    def boxes(self, is_wanted: Callable[[int], bool]) -> Iterator[tuple[int, Array, Array]]:
        """Each class that is wanted, and its box where it was seen last: (4, 3) corners and (3,) normal, world."""
        whole = (self._rooms >= WORD_ENDS).all(axis=1)
        for identifier in filter(is_wanted, np.unique(self._classes[whole]).tolist()):
            own = np.flatnonzero(whole & (self._classes == identifier))
            apart = np.linalg.norm(self._positions[own] - self._positions[own[-1]], axis=1)
            own = own[apart <= _ALONG_SHARE * self._sizes[own[-1]].max()]
            position, normal, along = (
                np.median(each[own], axis=0) for each in (self._positions, self._normals, self._baselines)
            )
            right, down = (np.median(self._sizes[own], axis=0)[:, None] / 2.0) * (along, np.cross(along, normal))
            yield identifier, position + np.stack([-right - down, right - down, right + down, down - right]), normal

    def _is_better(self, here: NDArray[np.bool_], placement: Placement, seen: SeenSize, config: ReadingConfig) -> bool:
        """Whether a text is seen larger or longer than in any reading of it, so that another one may say more."""
        highest, best = self._seen[here].max(axis=0).tolist()
        is_larger = best < config.full_size and seen.effective >= min(config.better_size * best, config.full_size)
        is_larger |= highest < config.believed_height <= seen.height
        return is_larger or placement.width > config.longer * float(self._sizes[here, 0].max())

    def _count_as_good(self, here: NDArray[np.bool_], seen: SeenSize, config: ReadingConfig) -> int:
        """How many readings are of letters nearly as large as they are seen now, or as large as a reader can use."""
        return int((self._seen[here, 1] * config.unsure_better > min(seen.effective, config.full_size)).sum())

    def _shows_an_end(self, here: NDArray[np.bool_], room: Callable[[], tuple[float, float]]) -> bool:
        """Whether the view goes on now beyond an end where it did in no reading."""
        unseen = self._rooms[here].max(axis=0) < LINE_ENDS
        return bool(unseen.any() and (unseen & (np.array(room()) >= LINE_ENDS)).any())

    def _here(self, placement: Placement, world_from_keyframe: Array) -> NDArray[np.bool_]:
        position, baseline, normal = in_world(placement, world_from_keyframe)
        offsets = self._positions - position
        along = offsets @ baseline
        across = np.linalg.norm(offsets - along[:, None] * baseline, axis=1)
        lengths = np.maximum(self._sizes[:, 0], placement.width)
        heights = np.maximum(self._sizes[:, 1], placement.height)
        overlaps = (np.abs(along) < _ALONG_SHARE * lengths) & (across < _ACROSS_SHARE * heights)
        letters, own = self._sizes.min(axis=1), min(placement.width, placement.height)
        overlaps &= np.maximum(letters, own) <= _ALIKE * np.minimum(letters, own)
        # The back of a thin sign may say something else.
        here: NDArray[np.bool_] = overlaps & (self._normals @ normal > 0.0)
        return here

    def add(
        self,
        identifier: int,
        text: str,
        placement: Placement,
        world_from_keyframe: Array,
        seen: SeenSize,
        room: tuple[float, float] | None = None,
    ) -> None:
        """Note a sighting of a class, as what it was read, how large it was seen and how far the view went on."""
        position, baseline, normal = in_world(placement, world_from_keyframe)
        size = [placement.width, placement.height]
        self._classes = np.append(self._classes, identifier)[-_CAPACITY:]
        self._keys = np.append(self._keys, np.array([comparison_key(text)], object))[-_CAPACITY:]
        self._positions = np.vstack([self._positions, position])[-_CAPACITY:]
        self._normals = np.vstack([self._normals, normal])[-_CAPACITY:]
        self._baselines = np.vstack([self._baselines, baseline])[-_CAPACITY:]
        self._sizes = np.vstack([self._sizes, size])[-_CAPACITY:]
        self._seen = np.vstack([self._seen, [seen.height, seen.effective]])[-_CAPACITY:]
        # Where nobody knows, nothing is looked for.
        self._rooms = np.vstack([self._rooms, room or (LINE_ENDS, LINE_ENDS)])[-_CAPACITY:]


def in_world(placement: Placement, world_from_keyframe: Array) -> tuple[Array, Array, Array]:
    """Where a text stands, which way it runs and which way it faces, (3,) each, in the world."""
    position = transform_points(world_from_keyframe, np.array([placement.position]))[0]
    rotation = world_from_keyframe[:3, :3]
    return position, rotation @ np.array(placement.baseline), rotation @ np.array(placement.normal)
