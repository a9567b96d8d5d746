"""Knowing again a place that was mapped before (ORB-SLAM, VII; ORB-SLAM3, VI): to close loops and to merge sub-maps.

A wrong loop ruins a map. So a place is believed only when several keyframes, each by its own keypoints, are located in
the old part of the map at poses that ask for the same correction, when the old part is found from the new one as well,
when no other place explains the view, and when the correction is no more than the way since may have drifted.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.config import SlamConfig
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor, Recalled
from lpslam.slam.map import SlamMap
from lpslam.slam.places.drift import Drift
from lpslam.slam.places.index import PlaceIndex, group_candidates
from lpslam.slam.places.located import Located
from lpslam.slam.places.locating import Locator
from lpslam.slam.places.loop_correction import LoopCorrector
from lpslam.slam.places.voting import Hypothesis, Voting, apart
from lpslam.slam.sensor import SensorModel
from lpslam.slam.state import EventKind

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LoopEvent:
    """A loop that was closed, or two sub-maps that became one.

    Attributes:
        kind: `LOOP` or `MERGE`.
        keyframe, candidate: ids of the new keyframe and of the old one that shows the same place.
        inliers: map points of the old part that the new keyframe sees.
        metres, degrees: by how much the new keyframe was off, as the old part has the world.
        reason: all that in a few words.
    """

    kind: EventKind
    keyframe: int
    candidate: int
    inliers: int
    metres: float
    degrees: float
    reason: str


@dataclass(slots=True)
class LoopCounts:
    """What became of keyframes: how many were looked at, loops and merges, and why candidates were rejected."""

    keyframes: int = 0
    closed: int = 0
    merged: int = 0
    rejected: Counter[str] = field(default_factory=Counter)


class LoopCloser:
    """Looks at each new keyframe for a place that was mapped before, and corrects the map.

    The map's lock is held for a few milliseconds at a time.

    Args:
        slam_map: is changed.
        sensor: of the camera.
        places: every keyframe that is processed is added to it.
        locator: verifies candidates.
        config: all thresholds.
        advisor: proposes and vetoes candidates by other means.
    """

    def __init__(
        self,
        slam_map: SlamMap,
        sensor: SensorModel,
        places: PlaceIndex,
        locator: Locator,
        config: SlamConfig,
        advisor: LoopAdvisor = NO_ADVICE,
    ) -> None:
        self._map = slam_map
        self._places = places
        self._locator = locator
        self._config = config.loops
        self._advisor = advisor
        self._drift = Drift(slam_map, config.loops)
        self._corrector = LoopCorrector(slam_map, sensor, config.loops, config.mapping)
        self._voting = Voting(slam_map, locator, config.loops, self._locate, self._reject)
        self._stop = np.zeros(1, np.bool_)
        self._hypothesis: Hypothesis | None = None
        self._last_closed = -config.loops.pause
        self._indexed = slam_map.living_keyframes()
        self.counts = LoopCounts()

    def process(self, keyframe: int) -> LoopEvent | None:
        """Look for the place of a keyframe in older parts of the map; correct the map if it is found."""
        with self._map.lock:
            if not self._map.is_alive(keyframe):
                return None
            self._index(keyframe)
        self.counts.keyframes += 1
        if keyframe - self._last_closed < self._config.pause:
            return None
        hypothesis = self._detect(keyframe)
        if hypothesis is None:
            return None
        self._hypothesis = None
        event = self._correct(hypothesis)
        if event is not None:
            self._last_closed = keyframe
        return event

    def join_parts(self) -> list[LoopEvent]:
        """Look from the smaller sub-maps for the rest once more, when the recording ends: now all of it is known.

        Each keyframe was compared with what was mapped when it was new; what came later saw other sides of the place.
        """
        events: list[LoopEvent] = []
        while (event := self._join_one()) is not None:
            events.append(event)
        return events

    def _join_one(self) -> LoopEvent | None:
        living, submaps = self._map.living_keyframes(), self._map.submaps()
        smaller = living[submaps[living] != np.bincount(submaps[living]).argmax()] if len(living) else living
        spread = np.linspace(0, len(smaller) - 1, min(len(smaller), self._config.last_views)).astype(int)
        for keyframe in smaller[spread].tolist():
            if self._stop[0]:
                break
            hypothesis = self._detect(keyframe)
            if self._hypothesis is not None:
                # Views that saw the place need not follow each other.
                self._hypothesis.missed = 0
            event = None if hypothesis is None else self._correct(hypothesis)
            if event is not None:
                return event
        return None

    def interrupt(self) -> None:
        """End a running correction early. May be called from any thread; no loop is closed afterwards."""
        self._stop[0] = True

    def _index(self, keyframe: int) -> None:
        """Add a keyframe to the index, and take those out that were removed from the map."""
        alive = self._map.columns.keyframe_slot[self._indexed] >= 0
        for removed in self._indexed[~alive].tolist():
            self._places.remove(removed)
        self._indexed = self._indexed[alive]
        if keyframe not in self._places:
            self._places.add(keyframe, self._map.features(keyframe).descriptor)
            self._indexed = np.append(self._indexed, np.int32(keyframe))

    # Finding -----------------------------------------------------------------------------------------------------

    def _detect(self, keyframe: int) -> Hypothesis | None:
        """A place that enough keyframes agree on; else what was found waits for the next keyframes."""
        with self._map.lock:
            version = self._map.version
            candidates = self._candidates(keyframe)
        found = self._find(keyframe, candidates)
        if found is None:
            self._miss()
            return None
        with self._map.lock:
            hypothesis = self._hypothesis = self._voting.joined(self._hypothesis, keyframe, found, version)
        self._voting.ask_neighbours(hypothesis)
        if len(hypothesis.ties) < self._config.votes:
            return None
        if not any(self._voting.is_mutual(tie, hypothesis.is_told) for tie in hypothesis.ties[: self._config.votes]):
            self._reject("not found from the other side")
            return None
        return hypothesis

    def _old_part(self, keyframe: int) -> NDArray[np.bool_]:
        """(K,) keyframes in which a place found again would be news."""
        slam_map, count = self._map, self._map.keyframe_count
        old = slam_map.columns.keyframe_slot[:count] >= 0
        near = np.arange(count) > keyframe - self._config.min_keyframes_apart
        old[near & (slam_map.submaps() == slam_map.submaps()[keyframe])] = False
        old[slam_map.covisible(keyframe, 1)] = False
        old[keyframe] = False
        return old

    def _candidates(self, keyframe: int) -> list[Recalled]:
        """What is proposed, and old keyframes that look more like this one than its covisible ones at worst do."""
        slam_map, config = self._map, self._config
        if not slam_map.is_alive(keyframe):
            return []
        old = self._old_part(keyframe)
        proposed = [
            each
            for each in self._advisor.propose(slam_map, keyframe)
            if 0 <= each.keyframe < len(old) and old[each.keyframe]
        ]
        scores = self._places.query_keyframe(keyframe)
        covisible = slam_map.covisible(keyframe, config.covisible_points)
        covisible = covisible[covisible < len(scores)]
        indexed = covisible[scores[covisible] > 0]
        floor = float(scores[indexed].min()) if len(indexed) else 0.0
        count = min(len(scores), len(old))
        scores[:count][~old[:count]] = 0
        scores[count:] = 0
        likely = group_candidates(scores, slam_map.covisible, config.candidates, floor=floor)
        alike = dict.fromkeys([*likely, *self._elsewhere(keyframe, scores, old)])
        return [*proposed[: config.candidates], *map(Recalled, alike)]

    def _elsewhere(self, keyframe: int, scores: NDArray[np.float32], old: NDArray[np.bool_]) -> list[int]:
        """Keyframes of other sub-maps: the last one before this sub-map began, and those that look most alike.

        Between sub-maps a place is worth more tries: what is not joined is lost to whoever asks the map.
        """
        slam_map, count = self._map, self._config.merge_candidates
        submaps = slam_map.submaps()
        others = np.flatnonzero(old & (submaps != submaps[keyframe]))
        if not len(others) or not count:
            return []
        root = int(np.flatnonzero(submaps == submaps[keyframe])[0])
        before = others[others < root]
        known = others[others < len(scores)]
        alike = known[np.argsort(-scores[known], kind="stable")][:count]
        return [int(k) for k in (*before[-1:], *alike)]

    def _locate(self, view: int, candidate: Recalled, keyframe: int) -> Located | None:
        """Locate the keypoints of one keyframe around another, in what is old for a third."""
        with self._map.lock:
            if not (self._map.is_alive(view) and self._map.is_alive(candidate.keyframe)):
                return None
            # Within a sub-map drift tells places apart that look the same.
            submaps = self._map.submaps()
            is_anywhere = bool(submaps[view] != submaps[candidate.keyframe])
            return self._locator.locate(
                self._map.features(view),
                candidate.keyframe,
                self._old_part(keyframe),
                guess=candidate.camera_from_world,
                anchor=candidate.anchor,
                is_anywhere=is_anywhere,
            )

    def _find(self, keyframe: int, candidates: Sequence[Recalled]) -> Located | None:
        """The one place of the old part that explains the keyframe and may be true."""
        found: list[Located] = []
        for candidate in candidates:
            located = self._locate(keyframe, candidate, keyframe)
            if located is None:
                self._reject("does not fit")
            elif not self._drift.allows(keyframe, located):
                self._reject("more than drift")
            elif (reason := self._objection(keyframe, located)) is not None:
                self._reject(reason)
            else:
                found.append(located)
        if not found:
            return None
        best = max(found, key=lambda located: located.inliers)
        submaps = self._map.submaps()
        for other in found:
            same_world = submaps[other.keyframe] == submaps[best.keyframe]
            if same_world and not self._voting.agree(best.camera_from_world, other.camera_from_world):
                self._reject("ambiguous")
                return None
        return best

    def _objection(self, keyframe: int, located: Located) -> str | None:
        with self._map.lock:
            if not self._map.is_alive(keyframe):
                return "removed"
            return self._advisor.vetoes(self._map, keyframe, located.keyframe, located.camera_from_world)

    def _miss(self) -> None:
        if self._hypothesis is not None:
            self._hypothesis.missed += 1
            if self._hypothesis.missed > self._config.patience:
                self._hypothesis = None

    def _reject(self, reason: str) -> None:
        self.counts.rejected[reason] += 1

    # Correcting --------------------------------------------------------------------------------------------------

    def _correct(self, hypothesis: Hypothesis) -> LoopEvent | None:
        slam_map, tie = self._map, hypothesis.ties[0]
        with slam_map.lock:
            metres, degrees = apart(slam_map.camera_from_world(tie.keyframe), tie.camera_from_world)
            is_merge = bool(slam_map.submaps()[tie.keyframe] != slam_map.submaps()[tie.candidate])
        correct = self._corrector.merge if is_merge else self._corrector.close
        if not correct(hypothesis.ties, hypothesis.version, self._stop):
            return None
        self._corrector.adjust_fully(tie.keyframe, self._stop)
        self.counts.merged += int(is_merge)
        self.counts.closed += int(not is_merge)
        where = f"keyframe {tie.candidate} seen again from {tie.keyframe}: {hypothesis.inliers} map points"
        return LoopEvent(
            EventKind.MERGE if is_merge else EventKind.LOOP,
            tie.keyframe,
            tie.candidate,
            hypothesis.inliers,
            metres,
            degrees,
            where if is_merge else f"{where}, {metres:.3f} m and {degrees:.2f} degrees off",
        )
