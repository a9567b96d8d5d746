"""Words help geometry: what was read says where loops may close, and where they must not.

A place whose pictures look different, or like others, has its own signs. Several of them, standing to one another as
they did before, propose keyframes to loop closing, which verifies these like any others. And where a keyframe was
located among signs that say something else than those it sees, loop closing is told not to believe it.
"""

import threading
from collections import defaultdict, deque
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import inverse_transform
from lpslam.config import AdviceConfig
from lpslam.slam.advice import KeyframeMap, Recalled
from lpslam.text.advice.constellations import (
    NEARLY_THE_SAME,
    Constellation,
    Seen,
    agree,
    constellations,
    contradict,
    likeness,
    nearest_views,
    said_most_alike,
    seen_texts,
)
from lpslam.text.advice.sightlines import Sightline, anchor_of, is_ahead, standpoints
from lpslam.text.remembering.memory import TextClass
from lpslam.text.remembering.similarity import comparison_key, similarity
from lpslam.text.types import Bearing, TextObservation

Sighting = tuple[int, TextObservation]
Array = NDArray[np.float64]

# Sightings kept of one class from one keyframe: more say the same again.
_KEPT = 8

# Most sightings of one class that are looked at, the newest: a word that is everywhere says little.
_LOOKED_AT = 160

# Keyframes up to the newest of which one has the last frame that was read: what it shows is still in view.
_VIEWS = 4

# Views of which it is kept which sign alone told their place: while one is doubted, others follow.
_VIEWS_TOLD = 100

SIGNS_DIFFER = "signs differ"


class TextAdvisor:
    """A `LoopAdvisor` that knows what was read from every keyframe.

    Texts are noted in the thread that reads, and asked for in the thread that closes loops; neither waits for the other
    longer than it takes to copy a few lists. Nothing that was read is more than compared.

    Args:
        config: thresholds.
        classes: what was read before, of a map that is continued.

    Attributes:
        proposed, vetoed: how many keyframes were named and refused so far.
    """

    def __init__(self, config: AdviceConfig, classes: Iterable[TextClass] = ()) -> None:
        self._config = config
        self._lock = threading.Lock()
        self._by_keyframe: dict[int, list[Sighting]] = defaultdict(list)
        self._by_class: dict[int, list[TextObservation]] = defaultdict(list)
        self._keys: dict[int, set[str]] = defaultdict(set)
        self._doubtful: list[Sighting] = []
        self._doubtful_classes = count(1)
        self._views: dict[int, list[TextObservation]] = {}
        self._lost: list[TextObservation] = []
        self._recalled: list[Recalled] | None = None
        self._told: deque[tuple[float, Seen | None]] = deque(maxlen=_VIEWS_TOLD)
        self._has_news = False
        self.proposed = 0
        self.vetoed = 0
        for text_class in classes:
            for observation in text_class.observations:
                if observation.placement is not None:
                    self.note(text_class.id, observation)

    def note(self, text_class: int, observation: TextObservation) -> None:
        """Take a sighting of a class of texts."""
        with self._lock:
            here = self._by_keyframe[observation.keyframe]
            if sum(other == text_class for other, _ in here) < _KEPT:
                here.append((text_class, observation))
                self._by_class[text_class].append(observation)
                self._keys[text_class].add(comparison_key(observation.text))

    def note_doubtful(self, observation: TextObservation) -> None:
        """Take a sighting from where the camera was found again: `judges` compares it with what was read there."""
        key = comparison_key(observation.text)
        with self._lock:
            alike = (
                text_class
                for text_class, other in self._doubtful
                if similarity(comparison_key(other.text), key) >= NEARLY_THE_SAME
            )
            known = next(alike, None)
            # Below zero: no class of the memory.
            text_class = -next(self._doubtful_classes) if known is None else known
            self._doubtful.append((text_class, observation))
            del self._doubtful[:-_LOOKED_AT]
            self._has_news = True

    def note_view(self, keyframe: int, observations: Sequence[TextObservation]) -> None:
        """Take all that one frame shows, with or without a place; the newest of a keyframe counts.

        Below zero is no keyframe: the camera is lost, or its place is doubted, and the texts are in its own frame.
        """
        with self._lock:
            if keyframe < 0:
                self._lost, self._recalled = list(observations), None
            elif observations:
                self._views[keyframe] = list(observations)

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        """Places where texts were read in the arrangement in which they were seen lately from around `keyframe`."""
        proposals = [*self._proposed_by_arrangement(keyframes, keyframe), *self._proposed_by_sight(keyframes, keyframe)]
        proposals = proposals[: self._config.proposals]
        self.proposed += len(proposals)
        return proposals

    def _proposed_by_arrangement(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        lately = self._lately(keyframes, keyframe)
        if len({text.text_class for text in lately}) < 2:
            return []
        before = self._before(keyframes, keyframe, {text.text_class for text in lately})
        found = self._found_again(lately, before, keyframes)
        views: dict[int, Recalled] = {}
        for each in found:
            if (view := self._view(keyframes, keyframe, *each)) is not None:
                views.setdefault(view.keyframe, view)
        return list(views.values())

    def _proposed_by_sight(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        """By the last frame that was read, as this keyframe would have seen it."""
        recent = self._recent(keyframes, keyframe)[-_VIEWS:]
        with self._lock:
            last = next((k for k in reversed(recent) if k in self._views), None)
            seen = [] if last is None else self._views[last]
        if last is None:
            return []
        camera_from_last = keyframes.camera_from_world(keyframe) @ keyframes.world_from_keyframe(last)
        classes = self._classes_like(seen)
        before = self._before(keyframes, keyframe, {key for each in classes for key in each})
        return self._recall(seen, classes, camera_from_last, before, keyframes)[0]

    def recalls(self, keyframes: KeyframeMap) -> list[Recalled]:
        """Where texts would be seen as a lost camera sees them: two or more, or one that stands nowhere else."""
        with self._lock:
            lost, recalled = self._lost, self._recalled
        if recalled is None:
            # Asked at every frame that is lost, and most bring no text.
            recalled = self._recall_lost(lost, keyframes)
            with self._lock:
                if self._lost is lost:
                    self._recalled = recalled
        return recalled

    def _recall_lost(self, lost: list[TextObservation], keyframes: KeyframeMap) -> list[Recalled]:
        # One frame reads a text once: it may be of every class that has a spelling like it.
        classes = self._classes_like(lost)
        before = self._newest({key for each in classes for key in each}, len(keyframes.submaps()))
        recalled, sign = self._recall(lost, classes, np.eye(4), before, keyframes)
        if lost:
            self._told.append((lost[0].timestamp, sign))
        return recalled

    def _recall(
        self,
        texts: list[TextObservation],
        classes: list[set[int]],
        camera_from_keyframe: Array,
        before: list[Sighting],
        keyframes: KeyframeMap,
    ) -> tuple[list[Recalled], Seen | None]:
        """Where a camera is that has these texts in view, each of some classes; and the sign, if one alone says it."""
        seen = [
            (each, each.bearing, keys)
            for each, keys in zip(texts, classes, strict=True)
            if each.bearing is not None and any(key in keys for key, _ in before)
        ]
        submaps, old, found = keyframes.submaps(), keyframes.living_keyframes(), []
        for submap in sorted({int(submaps[observation.keyframe]) for _, observation in before}):
            here = self._often_read([each for each in before if submaps[each[1].keyframe] == submap], keyframes)
            sightlines = [
                Sightline(
                    bearing,
                    camera_from_keyframe,
                    said_most_alike(text.text, [sign for sign in here if sign.text_class in keys]),
                )
                for text, bearing, keys in seen
            ]
            for place in standpoints(sightlines, self._config):
                view = self._nearest(keyframes, old[submaps[old] == submap], inverse_transform(place.camera_from_world))
                if view is not None:
                    anchor = replace(place.anchor, timestamp=texts[0].timestamp)
                    found.append((place.rarity, Recalled(view, place.camera_from_world, anchor)))
        if not found and len(seen) == 1:
            # Of two that do not stand to one another as before, neither is believed.
            text, bearing, keys = seen[0]
            own = [each for each in before if each[0] in keys]
            return self._anchored(text, bearing, camera_from_keyframe, own, keyframes)
        found.sort(key=lambda each: -each[0])
        return [each for _, each in found[: self._config.proposals]], None

    def _anchored(
        self,
        text: TextObservation,
        bearing: Bearing,
        camera_from_keyframe: Array,
        before: list[Sighting],
        keyframes: KeyframeMap,
    ) -> tuple[list[Recalled], Seen | None]:
        """Where a text stands that stands at one place of the map alone, by the keyframe that saw it most alike."""
        submaps, alive = keyframes.submaps(), set(keyframes.living_keyframes().tolist())
        worlds = {int(submaps[observation.keyframe]) for _, observation in before}
        signs = self._often_read(before, keyframes) if len(worlds) == 1 else []
        likest = said_most_alike(text.text, signs)
        if len(likest) != 1:
            return [], None
        if len(signs) > 1:
            spelt = {comparison_key(each) for each in likest[0].spellings}
            before = [each for each in before if comparison_key(each[1].text) in spelt]
        corners = Sightline(bearing, camera_from_keyframe, likest).corners_if(likest[0])
        alike = [
            (abs(observation.letter_height - text.letter_height), observation.keyframe)
            for _, observation in before
            if observation.keyframe in alive
        ]
        if not alike or not is_ahead(corners):
            return [], None
        return [Recalled(min(alike)[1], anchor=anchor_of([(corners, likest[0])], text.timestamp))], likest[0]

    def vetoes(self, keyframes: KeyframeMap, keyframe: int, candidate: int, camera_from_world: Array) -> str | None:
        """Refuse a pose among signs that say something else than those that were read lately."""
        old_from_new_world = np.linalg.inv(camera_from_world) @ keyframes.camera_from_world(keyframe)
        lately = [text.moved(old_from_new_world) for text in self._lately(keyframes, keyframe)]
        if len(lately) < self._config.contradictions:
            return None
        around = self._around(keyframes, candidate, set(self._recent(keyframes, keyframe)))
        if not contradict(lately, around, self._config):
            return None
        self.vetoed += 1
        return SIGNS_DIFFER

    def knows(self, keyframes: KeyframeMap, keyframe: int) -> bool:
        """Whether anything was read: around the keyframe, or elsewhere, from where it may speak against it."""
        with self._lock:
            return bool(self._by_class)

    def judges(self, keyframes: KeyframeMap, keyframe: int, since: float) -> bool | None:
        """Compare the doubtful sightings with what was read around a keyframe before; None while they say nothing."""
        with self._lock:
            # Asked at every frame, and most bring no text.
            if not self._has_news:
                return None
            self._has_news = False
            self._doubtful = [each for each in self._doubtful if each[1].timestamp >= since]
            doubtful = list(self._doubtful)
        if not doubtful:
            return None
        new = seen_texts(doubtful, keyframes.world_from_keyframe, self._config)
        told_by = next((sign for timestamp, sign in reversed(self._told) if timestamp < since), None)
        if told_by is not None:
            # A sign that alone told the place, as another shop of its name may, is no witness of it.
            new = [text for text in new if likeness(text, told_by) < self._config.alike]
        around = self._around(keyframes, keyframe, ())
        if contradict(new, around, self._config):
            self.vetoed += 1
            return False
        return True if agree(new, around, self._config) else None

    # What was read --------------------------------------------------------------------------------------------------

    def _recent(self, keyframes: KeyframeMap, keyframe: int) -> list[int]:
        """The keyframe and the few before it, of the same sub-map."""
        submaps = keyframes.submaps()
        first = max(0, keyframe + 1 - self._config.recent_keyframes)
        return [k for k in range(first, keyframe + 1) if submaps[k] == submaps[keyframe]]

    def _lately(self, keyframes: KeyframeMap, keyframe: int) -> list[Seen]:
        """The texts read from the last keyframes, as far as they are near."""
        recent = self._recent(keyframes, keyframe)
        with self._lock:
            sightings = [each for k in recent if k in self._by_keyframe for each in self._by_keyframe[k]]
        centre = keyframes.world_from_keyframe(keyframe)[:3, 3]
        texts = self._often_read(sightings, keyframes)
        return [text for text in texts if np.linalg.norm(text.position - centre) <= self._config.reach]

    def _before(self, keyframes: KeyframeMap, keyframe: int, classes: Collection[int]) -> list[Sighting]:
        """Sightings of some classes from other sub-maps and from long before."""
        submaps = keyframes.submaps()
        return [
            (key, each)
            for key, each in self._newest(classes, len(submaps))
            if each.keyframe <= keyframe - self._config.apart_keyframes or submaps[each.keyframe] != submaps[keyframe]
        ]

    def _newest(self, classes: Collection[int], keyframes: int) -> list[Sighting]:
        """The newest sightings of some classes, from the first so many keyframes."""
        with self._lock:
            newest = [
                (key, observation) for key in sorted(classes) for observation in self._by_class[key][-_LOOKED_AT:]
            ]
        return [(key, each) for key, each in newest if each.keyframe < keyframes]

    def _around(self, keyframes: KeyframeMap, candidate: int, without: Collection[int]) -> list[Seen]:
        """The texts read from keyframes around an old one."""
        submaps = keyframes.submaps()
        with self._lock:
            read = np.array([k for k in sorted(self._by_keyframe) if k < len(submaps) and k not in without], np.int64)
        read = read[submaps[read] == submaps[candidate]]
        centre = keyframes.world_from_keyframe(candidate)[:3, 3]
        away = np.array([np.linalg.norm(keyframes.world_from_keyframe(k)[:3, 3] - centre) for k in read.tolist()])
        near = read[away <= self._config.reach].tolist()
        with self._lock:
            sightings = [each for k in near for each in self._by_keyframe[k]]
        return self._often_read(sightings, keyframes)

    def _often_read(self, sightings: list[Sighting], keyframes: KeyframeMap) -> list[Seen]:
        texts = seen_texts(sightings, keyframes.world_from_keyframe, self._config)
        return [text for text in texts if text.sightings >= self._config.min_sightings]

    def _classes_like(self, observations: Sequence[TextObservation]) -> list[set[int]]:
        """For each text, the classes that have a sighting which says nearly the same."""
        with self._lock:
            keys = {text_class: tuple(known) for text_class, known in sorted(self._keys.items())}
        return [
            {
                text_class
                for text_class, known in keys.items()
                if any(similarity(other, own) >= NEARLY_THE_SAME for other in known)
            }
            for own in (comparison_key(each.text) for each in observations)
        ]

    # Where that is --------------------------------------------------------------------------------------------------

    def _found_again(
        self, new: list[Seen], before: list[Sighting], keyframes: KeyframeMap
    ) -> list[tuple[Constellation, int]]:
        """Arrangements of texts that were read before, with the sub-map where that was, the rarest texts first."""
        submaps = keyframes.submaps()
        found = [
            (constellation, submap)
            for submap in sorted({int(submaps[observation.keyframe]) for _, observation in before})
            for constellation in constellations(
                new,
                self._often_read([each for each in before if submaps[each[1].keyframe] == submap], keyframes),
                self._config,
            )
        ]
        return sorted(found, key=lambda each: -each[0].rarity)

    def _view(
        self, keyframes: KeyframeMap, keyframe: int, constellation: Constellation, submap: int
    ) -> Recalled | None:
        """The old keyframe that looks most as this one would, if its texts are those of the constellation."""
        submaps = keyframes.submaps()
        old = keyframes.living_keyframes()
        old = old[submaps[old] == submap]
        if submap == submaps[keyframe]:
            old = old[old <= keyframe - self._config.apart_keyframes]
        expected = constellation.old_from_new_world @ keyframes.world_from_keyframe(keyframe)
        nearest = self._nearest(keyframes, old, expected)
        return None if nearest is None else Recalled(nearest, inverse_transform(expected))

    def _nearest(self, keyframes: KeyframeMap, old: NDArray[np.int32], world_from_camera: Array) -> int | None:
        if not len(old):
            return None
        poses = np.array([keyframes.world_from_keyframe(k) for k in old.tolist()])
        rows = nearest_views(world_from_camera, poses, self._config)
        return int(old[rows[0]]) if len(rows) else None
