"""Finding a lost view in the whole map (ORB-SLAM, V-B)."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import centre_distance, inverse_transform
from lpslam.config import LocatingConfig, TrackingConfig
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor, Recalled
from lpslam.slam.features import Features
from lpslam.slam.map import SlamMap
from lpslam.slam.places.index import PlaceIndex, group_candidates
from lpslam.slam.places.located import Fit, Located, Look
from lpslam.slam.places.locating import Locator


@dataclass(frozen=True, slots=True, eq=False)
class LastSeen:
    """Where the camera was last.

    Attributes:
        keyframe, camera_from_keyframe: its pose (4×4), which follows every correction of the map.
        timestamp: in seconds.
        is_told: something else than appearance said where that is.
    """

    keyframe: int
    camera_from_keyframe: NDArray[np.float64]
    timestamp: float
    is_told: bool = False


class Relocaliser:
    """Believes one place that holds, unless another holds as well elsewhere, or a part of the view fits elsewhere.

    A place that few points tell, or that some of what looks alike contradicts, is believed when the next frames find it
    too; one fewer where the camera was near it.
    Candidates are the last keyframe, those that an advisor recalls, those that look alike by their words, and, a few a
    frame, all others in turn: words are learned on some pictures of the world, and a view of another may have none.
    """

    def __init__(
        self,
        slam_map: SlamMap,
        places: PlaceIndex,
        locator: Locator,
        tracking: TrackingConfig,
        locating: LocatingConfig,
        advisor: LoopAdvisor = NO_ADVICE,
    ) -> None:
        self._map = slam_map
        self._places = places
        self._locator = locator
        self._candidates = tracking.recovery_candidates
        self._config = locating
        self._advisor = advisor
        self._sweep = tracking.recovery_sweep
        self._swept = -1
        self._disowned: list[tuple[int, NDArray[np.float64]]] = []
        self._carried_speed, self._moment = tracking.carried_speed, tracking.coast_seconds
        self._unconfirmed: LastSeen | None = None
        self._found_in_a_row = 0
        self._compared: Sequence[Recalled] = ()

    def confirm(
        self,
        features: Features,
        last_reference: int,
        last_seen: LastSeen | None,
        timestamp: float,
        look: Look | None = None,
        fit: Fit | None = None,
    ) -> Located | None:
        """The place of a view: one that little tells only if the camera can have come there since it was last seen.

        That is: before it was lost, or by the same place found in the frames before. What fits by chance fits
        elsewhere in the next frames, as the view changes; a place that is right is found again.

        Args:
            features: the view's keypoints.
            last_reference: the keyframe by which the camera was last seen, tried first.
            last_seen: where it was then, if that is known.
            timestamp: of the view, in seconds.
            look: what the picture shows of a place; without, only corners tell.
            fit: as `Locator.locate` takes it.
        """
        config = self._config
        before, self._unconfirmed = self._unconfirmed, None
        likely = () if before is None else (self._again(before),)
        is_recent = last_seen is not None and abs(timestamp - last_seen.timestamp) <= self._moment

        def may_be_at(other: Located) -> bool:
            return not is_recent or self._is_within_reach(other, last_seen, timestamp)

        located = self.find(features, last_reference, likely, may_be_at, look, fit)
        if located is not None and not located.is_told and look is not None:
            came = is_recent and self._is_within_reach(located, last_seen, timestamp)
            # Something was moved where the camera was a moment ago; elsewhere it is another place that looks alike.
            located = None if not came and look.contradicts(located) else located
        is_sure = located is not None and (
            located.inliers >= config.sure_inliers and located.alike_agreement >= config.sure_alike_agreement
        )
        if located is None or is_sure:
            return located
        if self._is_within_reach(located, before, timestamp):
            self._found_in_a_row += 1
        else:
            self._found_in_a_row = 2 if self._is_within_reach(located, last_seen, timestamp) else 1
        if self._found_in_a_row >= config.sure_views:
            return located
        camera_from_keyframe = located.camera_from_world @ self._map.world_from_keyframe(located.keyframe)
        self._unconfirmed = LastSeen(located.keyframe, camera_from_keyframe, timestamp, located.is_told)
        return None

    def _again(self, seen: LastSeen) -> Recalled:
        """Where to look for what was found in the last frame: what told it then need not be in view or read again."""
        if not seen.is_told:
            return Recalled(seen.keyframe)
        return Recalled(seen.keyframe, seen.camera_from_keyframe @ self._map.camera_from_world(seen.keyframe))

    def find(
        self,
        features: Features,
        last_reference: int,
        likely: Sequence[Recalled] = (),
        may_be_at: Callable[[Located], bool] = lambda located: True,
        look: Look | None = None,
        fit: Fit | None = None,
    ) -> Located | None:
        """The place of a view, or None; the caller holds the map's lock.

        Args:
            features: the view's keypoints.
            last_reference: the keyframe by which the camera was last seen, tried first.
            likely: keyframes tried next.
            may_be_at: where the camera cannot be is no rival of where it can.
            look, fit: as `confirm` takes them.
        """
        found = [
            located
            for candidate in self._likely(features, last_reference, likely)
            if (located := self._locate(features, candidate, look is not None, fit)) is not None
            and not self._is_disowned(located)
        ]
        if look is not None:
            found = self._shown(found, look)
        if not found:
            return None
        best = max(found, key=lambda located: located.inliers)
        told = [located for located in found if located.is_told and self._is_like(best, located)]
        if told:
            # Of places that look alike, a sign tells which it is.
            best, found = max(told, key=lambda located: located.inliers), told
        if any(self._is_rival(best, other) and may_be_at(other) for other in found):
            return None
        # That no other place holds does not make it right: the right one need not be mapped.
        return best if best.is_told or self._repeats_nowhere(features, best, may_be_at) else None

    def _is_rival(self, best: Located, other: Located) -> bool:
        """Whether another place holds nearly as well as the best, and contradicts it."""
        return self._is_like(best, other) and self._is_elsewhere(best, other)

    def _repeats_nowhere(self, features: Features, best: Located, may_be_at: Callable[[Located], bool]) -> bool:
        """Whether what a view shows of a place is nowhere else in the map, or only where the camera cannot be."""
        elsewhere = self._locator.fit_elsewhere(features, best)
        if elsewhere is not None and may_be_at(elsewhere) and not self._is_disowned(elsewhere):
            return False
        return self._locator.is_unique(features, best)

    def _shown(self, found: Sequence[Located], look: Look) -> list[Located]:
        """Places of which the picture shows most, and of no other place much more.

        Of a place seen from another side hardly anything looks as it did. So it cannot be believed, but speaks against
        one where what looks alike is by chance, or by a pattern.
        """
        config, shown = self._config, list[tuple[float, Located]]()
        for located in sorted(found, key=lambda each: (self._looks_alike(each), each.inliers), reverse=True):
            if located.is_told or not any(self._is_beside(other, located) for _, other in shown):
                shown.append((1.0 if located.is_told else look.share(located), located))
        most = max((share for share, located in shown if not located.is_told), default=0.0)
        least = max(config.min_there_share, most - config.there_lead)
        return [
            located for share, located in shown if located.is_told or (self._looks_alike(located) and share >= least)
        ]

    def _looks_alike(self, located: Located) -> bool:
        return located.alike_agreement >= self._config.min_alike_agreement

    def is_told_elsewhere(self, features: Features, reference: int, camera_from_world: NDArray[np.float64]) -> bool:
        """Whether a sign in view tells a place that holds as well as the one in which the camera was found.

        Asked again only when something else is in view.

        Args:
            features: the view's keypoints.
            reference: the keyframe by which the camera was found.
            camera_from_world: its 4×4 pose there.
        """
        recalled = self._advisor.recalls(self._map)
        if recalled is self._compared:
            return False
        self._compared = recalled
        told = [each for each in (self._locate(features, one) for one in recalled) if each is not None and each.is_told]
        told = [each for each in told if not self._is_disowned(each)]
        if not told:
            return False
        if any(not self._are_apart(each, reference, camera_from_world) for each in told):
            return False
        best = max(told, key=lambda located: located.inliers)
        here = self._locate(features, Recalled(reference, camera_from_world))
        if here is None:
            return True
        return self._is_like(here, best) and here.parts.speak_for(best.parts) < self._config.rival_evidence

    def disown(self, keyframe: int, camera_from_world: NDArray[np.float64]) -> None:
        """Believe no place around a pose any more, given in the world of a keyframe's sub-map, until `forget`."""
        self._disowned.append((keyframe, inverse_transform(camera_from_world)[:3, 3]))

    def forget(self) -> None:
        """Believe every place again."""
        self._disowned.clear()

    def _is_within_reach(self, located: Located, seen: LastSeen | None, timestamp: float) -> bool:
        """Whether the camera can have come to a place since it was seen, if it was."""
        submaps = self._map.submaps()
        if seen is None or submaps[seen.keyframe] != submaps[located.keyframe]:
            return False
        camera_from_world = seen.camera_from_keyframe @ self._map.camera_from_world(seen.keyframe)
        reach = self._config.agreement_distance + self._carried_speed * abs(timestamp - seen.timestamp)
        return centre_distance(camera_from_world, located.camera_from_world) <= reach

    def _is_disowned(self, located: Located) -> bool:
        submaps = self._map.submaps()
        centre = inverse_transform(located.camera_from_world)[:3, 3]
        return any(
            submaps[keyframe] == submaps[located.keyframe]
            and float(np.linalg.norm(centre - other)) <= self._config.disowned_radius
            for keyframe, other in self._disowned
        )

    def _locate(
        self, features: Features, candidate: Recalled, will_look: bool = False, fit: Fit | None = None
    ) -> Located | None:
        guess, anchor = candidate.camera_from_world, candidate.anchor
        return self._locator.locate(
            features, candidate.keyframe, guess=guess, anchor=anchor, is_anywhere=False, will_look=will_look, fit=fit
        )

    def _likely(self, features: Features, last_reference: int, likely: Sequence[Recalled]) -> Iterator[Recalled]:
        """Keyframes to try, with what is known of the pose from elsewhere."""
        tried = {last_reference}
        if last_reference >= 0 and self._map.is_alive(last_reference):
            yield Recalled(last_reference)
        for recalled in (*likely, *self._advisor.recalls(self._map)):
            is_told = recalled.camera_from_world is not None or recalled.anchor is not None
            if self._map.is_alive(recalled.keyframe) and (is_told or recalled.keyframe not in tried):
                tried |= set() if is_told else {recalled.keyframe}
                yield recalled
        scores = self._places.query(features.descriptor)
        for candidate in group_candidates(scores, self._map.covisible, self._candidates):
            if candidate not in tried and self._map.is_alive(candidate):
                tried.add(candidate)
                yield Recalled(candidate)
        for candidate in self._next_in_turn():
            if candidate not in tried:
                yield Recalled(candidate)

    def _next_in_turn(self) -> list[int]:
        """The next few living keyframes after those of the frame before, the newest first, around and around."""
        living = self._map.living_keyframes()
        if not len(living) or not self._sweep:
            return []
        first = int(np.searchsorted(living, self._swept)) - 1
        chosen = living[np.arange(first, first - min(self._sweep, len(living)), -1) % len(living)]
        self._swept = int(chosen[-1])
        return [int(keyframe) for keyframe in chosen]

    def _is_like(self, best: Located, other: Located) -> bool:
        """Whether another place holds nearly as well as the best."""
        return other.inliers > self._config.rival_share * best.inliers

    def _is_elsewhere(self, one: Located, other: Located) -> bool:
        """Whether two places contradict each other; in different sub-maps both may be the same place."""
        return self._are_apart(one, other.keyframe, other.camera_from_world)

    def _is_beside(self, one: Located, other: Located) -> bool:
        """Whether two places are one, in the same sub-map."""
        submaps = self._map.submaps()
        return bool(submaps[one.keyframe] == submaps[other.keyframe]) and not self._is_elsewhere(one, other)

    def _are_apart(self, one: Located, keyframe: int, camera_from_world: NDArray[np.float64]) -> bool:
        """The same of a place and a pose (4×4) in the world of a keyframe's sub-map."""
        submaps = self._map.submaps()
        if submaps[one.keyframe] != submaps[keyframe]:
            return False
        return centre_distance(one.camera_from_world, camera_from_world) > self._config.rival_distance
