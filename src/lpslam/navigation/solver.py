"""One solver: which places serve, then what must hold, then relations and order by geometry."""

import heapq
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.config import NavigationConfig
from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.wishes.form import PREVIOUS, Counting, Relation, Stop, Which, Wish
from lpslam.language.wishes.served import Scorer, Served, Way
from lpslam.language.wishes.sorts import others_alike
from lpslam.navigation.columns import Near, Serving, apart_from, detours
from lpslam.navigation.pairs import likely_places, meant_pair
from lpslam.navigation.places import Distances, Here, Place, Point, Straight
from lpslam.navigation.relations import PAIRED, Judged, Scene, between, on_the_way
from lpslam.navigation.sites import Sites
from lpslam.navigation.solution import Solution, Solved

_OUTWARDS = frozenset({Relation.NEXT_TO, Relation.NEAR, Relation.OPPOSITE, Relation.LEFT_OF, Relation.RIGHT_OF})
"""Relations that cost at least the straight way to the anchor, ..."""
_BY_DETOUR = frozenset({Relation.BEFORE, Relation.BEHIND, Relation.THIS_SIDE})
"""... and those that do where a detour is never negative, as along straight ways."""
_WEAK = frozenset({Relation.NEAR, Relation.BEFORE, Relation.BEHIND})  # said of times and manners as well


def solve(
    wish: Wish,
    places: Sequence[Place] | Sites,
    scorer: Scorer,
    here: Here | None = None,
    ways: Distances | None = None,
    config: NavigationConfig | None = None,
) -> Solution:
    """Answer a wish.

    Args:
        wish: what is meant.
        places: all landmarks, where they stand; `Sites` of them, where many wishes are answered.
        scorer: says which landmarks serve a stop's words.
        here: where the asker stands; unknown without.
        ways: distances between points; straight without.
        config: thresholds; the defaults without.
    """
    sites = places if isinstance(places, Sites) else Sites(places)
    solver = _Solver(Scene(sites, here or Here(), ways or Straight(), config or NavigationConfig()), scorer)
    solved = _in_order(solver, wish)
    return Solution(replace(wish, stops=tuple(each.stop for each in solved)), tuple(solved))


def _in_order(solver: "_Solver", wish: Wish) -> list[Solved]:
    """The stops of a wish answered; where that may be read otherwise, only if each has a place of its own."""
    config, solved = solver.config, list[Solved]()
    # A plan with a gap serves nobody, so the likeliest is told.
    least = config.least_sure_in_plan if wish.instead is None else config.least_sure_apart
    for stop in wish.stops:
        sure = LEAST_SURE if len(wish.stops) == 1 else least
        solved.append(solver.stop(stop, solved[-1].place if solved else None, bool(solved), sure))
    is_apart = len({each.place.id for each in solved if each.place is not None}) == len(solved)
    if is_apart:
        return solved
    if wish.instead is None:
        # “To the optician's, and fetch my glasses”: one place is gone to once.
        before = (None, *(each.place and each.place.id for each in solved))
        return [each for each, last in zip(solved, before, strict=False) if each.place is None or each.place.id != last]
    otherwise = _in_order(solver, wish.instead)
    # Where neither reading finds a place, the first says what is missing: “KFC beside the station”, of no station.
    return otherwise if len(solved) > 1 or any(each.place is not None for each in otherwise) else solved


@dataclass(frozen=True, slots=True, eq=False)
class _Ranked:
    """A place with the cost by which it is ordered, lower first, and what is not sure of that."""

    cost: float
    place: Place
    score: float
    doubt: str = ""


class _Solver:
    def __init__(self, scene: Scene, scorer: Scorer) -> None:
        self._scene = scene
        self._scorer = scorer
        self.config = scene.config

    def stop(self, stop: Stop, previous: Place | None, is_later: bool, least: float = LEAST_SURE) -> Solved:
        """Answer one stop, if it is sure enough; `previous` is the place of the stop before."""
        if stop.among:
            return self._one_of(stop, previous)
        ignored = self._idle_relation(stop)
        if ignored:
            stop = replace(stop, what=stop.whole or stop.what, relation=None, anchor=())
        stop, within, note = self._on_its_floor(stop)
        served = self._scorer.serve(stop)
        if within is not None:
            served = self._within(served, within)
        left_out = {id_ for each in stop.without for id_ in self._left_out(each, served, previous)}
        if left_out:
            served = self._left(served, left_out)
        notes = [f"not heeded: {each}" for each in (*ignored, *served.ignored)]
        notes += [note] if note else []
        stop = served.stop
        if stop.contradiction:
            said = f"{stop.contradiction} at once: one place cannot be both, ask for one of them"
            return self._none(served, (said, *notes), self._listed(served))
        if not served.scores:
            return self._none(served, (served.evidence, *notes))
        if served.sure < least * served.strictness:
            unsure = self._listed(served)[: self.config.alternatives]
            return self._none(served, (served.doubt, *notes), unsure)
        if stop.relation is None:
            start = previous.position if is_later and previous is not None else self._scene.here.position
            return self._ordered(served, start, notes)
        anchors = [self._anchors(each, previous) for each in stop.anchor]
        if stop.relation is Relation.BETWEEN and not stop.what and len(anchors) > 1:
            likely = [
                [*found, *likely_places(self._scorer.serve(each), self._scene)]
                for each, found in zip(stop.anchor, anchors, strict=True)
            ]
            anchors = meant_pair(anchors, likely, self._scene)
        missing = [each.what for each, found in zip(stop.anchor, anchors, strict=True) if not found]
        if missing:
            notes.append(f"{' and '.join(missing)}: not on this map, so “{stop.relation.value}” cannot be decided")
            # That any place would do says nothing of what is missing.
            served = served if stop.what else replace(served, evidence="")
            return self._none(served, notes, self._listed(served))
        return self._related(served, anchors, previous, notes)

    def _one_of(self, stop: Stop, previous: Place | None) -> Solved:
        """The alternative that comes first by the order; none where one of them is not on the map."""
        anchors = [self._anchors(each, previous) for each in stop.anchor]
        found = [self._anchors(each, previous) for each in stop.among]
        looked_for = zip((*stop.anchor, *stop.among), (*anchors, *found), strict=True)
        missing = [each.what for each, places in looked_for if not places]
        scores = {place.id: 1.0 for places in found for place in places}
        served = Served(stop, scores, "one of those that are named", 0.9)
        if missing:
            said = f"{' and '.join(missing)}: not on this map, so “{stop.which.value}” cannot be decided"
            return self._none(served, [said], self._listed(served))
        if not anchors:
            return self._ordered(served, self._scene.here.position, [])
        sign = -1.0 if stop.which is Which.FARTHEST else 1.0
        serving = Serving(self._scene, scores)
        apart = np.min([self._from(each.position, serving) for each in anchors[0]], axis=0)
        metres = dict(zip(serving.ids.tolist(), apart.tolist(), strict=True))
        nearest = [min(places, key=lambda place: (metres[place.id], place.id)) for places in found]
        ranked = [_Ranked(sign * metres[place.id], place, 1.0) for place in dict.fromkeys(nearest)]
        ranked.sort(key=lambda each: (each.cost, each.place.id))
        return self._picked(served, ranked, [])

    def _on_its_floor(self, stop: Stop) -> tuple[Stop, set[int] | None, str]:
        """Where a floor is named: the stop without it, the places of that floor, and what is not sure of it.

        A map of which no floors are known has the floor's words only.
        """
        if stop.floor is None:
            return stop, None, ""
        floors = self._scene.floors
        if len(floors) < 2:
            is_here = stop.floor.counting is Counting.FROM_HERE and not stop.floor.number
            return (stop if is_here else replace(stop, what=stop.unplaced)), None, ""
        numbered = tuple(each for each in stop.identity if "floor" not in each.of)
        ids, note = floors.named(stop.floor, self._scene.here.position)
        if not ids and self._is_borne(stop):
            # “The lift to the 22nd floor”, of which the map has none, is the one that says so.
            return replace(stop, what=stop.unplaced), None, ""
        return replace(stop, identity=numbered), ids, note

    def _is_borne(self, stop: Stop) -> bool:
        """Whether a board bears the very floor that a stop names."""
        served = self._scorer.serve(replace(stop, what=stop.unplaced)) if stop.identity else None
        return served is not None and served.way is Way.IDENTITY and bool(served.scores)

    def _within(self, served: Served, within: set[int]) -> Served:
        """Of what serves, the places of a floor."""
        scores = {id_: score for id_, score in served.scores.items() if id_ in within}
        if within and not scores:
            # Who wants a lift to a floor may stand on another.
            scores = {id_: score for id_, score in served.scores.items() if id_ in served.on_any_floor}
        served = replace(served, exact=served.exact & scores.keys())
        if scores or not served.scores:
            return replace(served, scores=scores)
        others = tuple(sorted(served.scores, key=lambda id_: (-served.scores[id_], id_))[: self.config.alternatives])
        return replace(served, scores={}, evidence=f"nothing that serves is on {served.stop.floor}", others=others)

    def _left(self, served: Served, out: set[int]) -> Served:
        """What serves without what is left out; of its sort where there are others: a room, not room 201."""
        left = {id_: score for id_, score in served.scores.items() if id_ not in out}
        best = max(served.scores.values(), default=0.0)
        near = {id_ for id_, score in served.scores.items() if score >= self.config.equal_share * best}
        if near & out and near - out:
            # “A classroom, not Nordkette”: what is left out is of what is wanted, so that was understood.
            served = served.confirmed(LEAST_SURE * served.strictness)
        names = self._scene.sites.by_id
        alike = others_alike((names[id_].name for id_ in out), {id_: names[id_].name for id_ in left})
        return replace(served, scores={id_: left[id_] for id_ in alike} or left)

    def _left_out(self, stop: Stop, served: Served, previous: Place | None) -> set[int]:
        """The places that are left out; where they would be all that serve, those whose boards say just that."""
        if stop.which is not Which.ANY or stop.relation is not None:
            solved = self.stop(stop, previous, False)
            return {solved.place.id} if solved.place is not None else set()
        stop, within, _ = self._on_its_floor(stop)
        out = self._scorer.serve(stop)
        if within is not None:
            out = self._within(out, within)
        best = max(out.scores.values(), default=0.0)
        ids = {id_ for id_, score in out.scores.items() if score >= self.config.equal_share * best}
        return ids if served.scores.keys() - ids else set(out.exact)

    def _idle_relation(self, stop: Stop) -> tuple[str, ...]:
        """A relation to what is no place: “near at hand”, “before the flight”; it says when or how, not where."""
        if stop.relation not in _WEAK or stop.which is not Which.ANY or any(each == PREVIOUS for each in stop.anchor):
            return ()
        missing = [each for each in stop.anchor if each.what and not self._scorer.serve(each).as_anchor().scores]
        is_near = stop.relation is Relation.NEAR
        idle = [each for each in missing if not (is_near and self._scorer.is_understood(each))]
        return tuple(f"{stop.relation.value} {each.what}" for each in idle if stop.relation is not None)

    def _none(self, served: Served, notes: Sequence[str], others: Sequence[Place] = ()) -> Solved:
        next_best = tuple(others) or tuple(
            self._scene.sites.by_id[id_] for id_ in served.others if id_ in self._scene.sites.by_id
        )
        return Solved(
            served.stop, None, next_best, served.confidence, served.evidence, tuple(dict.fromkeys(notes)), served.model
        )

    def _listed(self, served: Served) -> list[Place]:
        serving = Serving(self._scene, served.scores)
        return [serving.place(at) for at in serving.first(self.config.listed, -serving.scores)]

    def _anchors(self, anchor: Stop, previous: Place | None) -> list[Place]:
        if anchor == PREVIOUS:
            return [previous] if previous is not None else []
        anchor, within, _ = self._on_its_floor(anchor)
        served = self._scorer.serve(anchor).as_anchor()
        if within is not None:
            served = self._within(served, within)
        if anchor.relation is not None or anchor.which is not Which.ANY:
            solved = self.stop(anchor, previous, False)
            return [solved.place] if solved.place is not None else []
        # “Next to Customs” means the board that says so, not all that deals with customs.
        scores = {id_: served.scores[id_] for id_ in served.exact} or served.scores
        serving = Serving(self._scene, scores, self.config.equal_share)
        return [serving.place(at) for at in range(len(serving))]

    def _from(self, start: Point | None, serving: Serving) -> NDArray[np.float64]:
        """Metres from a point to each place; zeros where it is not known."""
        ways = self._scene.ways
        if start is None or not len(serving):
            return np.zeros(len(serving))
        if isinstance(ways, Straight):
            return ways.distances(start, serving.positions)
        return np.array([ways.distance(start, position) for position in serving.positions])

    def _ordered(self, served: Served, start: Point | None, notes: list[str]) -> Solved:
        """Places that serve, in the order that is asked for."""
        stop, config = served.stop, self.config
        least = {Which.ANY: config.equal_share, Which.ALL: config.serves_share}.get(stop.which, config.nearly_share)
        serving = Serving(self._scene, served.scores, least)
        if start is None and stop.which in (Which.NEAREST, Which.FARTHEST):
            notes.append(f"where you stand is not known, so “{stop.which.value}” cannot be decided")
        cost = self._from(start, serving) * (-1.0 if stop.which is Which.FARTHEST else 1.0)
        if stop.which is Which.LARGEST:
            cost = np.array([-serving.place(at).size for at in range(len(serving))])
        by_score = start is None and stop.which is not Which.LARGEST
        keys = (-serving.scores,) if by_score else (cost, -serving.scores)
        ranked = [
            _Ranked(float(cost[at]), serving.place(at), float(serving.scores[at]))
            for at in serving.first(stop.rank + config.listed, *keys)
        ]
        if stop.which is Which.LARGEST and not any(each.place.size for each in ranked):
            notes.append("how large the places are is not known")
        return self._picked(served, ranked, notes)

    def _related(
        self, served: Served, anchors: Sequence[Sequence[Place]], previous: Place | None, notes: list[str]
    ) -> Solved:
        """Places that serve, by how they stand to the anchors."""
        stop = served.stop
        assert stop.relation is not None
        serving = Serving(self._scene, served.scores, self.config.nearly_share)
        start, note = self._start(stop, previous)
        notes += [note] if note else []
        ranked, doubts = self._in_relation(stop, serving, anchors, start)
        if not ranked and stop.relation is Relation.NEXT_TO and self._are_alike(served, anchors):
            # Of gates around a stadium the next one is a neighbour, however far.
            ranked, doubts = self._in_relation(replace(stop, relation=Relation.NEAR), serving, anchors, start)
        if not ranked:
            said = " and ".join(place.name for found in anchors for place in found[:1])
            notes += list(doubts) or [f"nothing that serves stands {stop.relation.value} {said}"]
            nearest = serving.first(self.config.alternatives, apart_from(serving, anchors))
            return self._none(served, notes, [serving.place(at) for at in nearest])
        ranked.sort(key=lambda each: (each.cost, -each.score, each.place.id))
        notes += [ranked[0].doubt] if ranked[0].doubt else []
        return self._picked(served, ranked, notes)

    def _are_alike(self, served: Served, anchors: Sequence[Sequence[Place]]) -> bool:
        """Whether the anchor is itself one of what is wanted beside it."""
        return all(place.id in served.scores for found in anchors for place in found)

    def _start(self, stop: Stop, previous: Place | None) -> tuple[Point | None, str]:
        if stop.start is None:
            return self._scene.here.position, ""
        found = self._anchors(stop.start, previous)
        if not found:
            return self._scene.here.position, f"{stop.start.what}: not on this map, the way is taken from here"
        return found[0].position, ""

    def _in_relation(
        self, stop: Stop, serving: Serving, anchors: Sequence[Sequence[Place]], start: Point | None
    ) -> tuple[list[_Ranked], dict[str, None]]:
        """The places that stand in the relation, and what is not sure of any.

        Places are judged from the anchors outwards, and no further than a better one may stand.
        """
        near = [Near(found) for found in anchors]
        is_by_detour = stop.relation is Relation.ON_THE_WAY and start is not None
        apart = (
            detours(serving, anchors[0], start) if is_by_detour and start is not None else apart_from(serving, anchors)
        )
        is_farthest = stop.which is Which.FARTHEST
        wanted = stop.rank + self.config.alternatives
        ranked: list[_Ranked] = []
        least: list[float] = []  # the costs of the best so far, negated: the worst of them is first
        doubts: dict[str, None] = {}
        for at in serving.first(len(serving), -apart if is_farthest else apart):
            if len(ranked) >= wanted and self._is_decided(stop, -least[0], float(apart[at])):
                break
            judged = self._judged(stop, serving.place(at), near, start)
            if judged.doubt:
                doubts.setdefault(judged.doubt)
            if math.isfinite(judged.cost):
                cost = -judged.cost if is_farthest else judged.cost
                ranked.append(_Ranked(cost, serving.place(at), float(serving.scores[at]), judged.doubt))
                (heapq.heappush if len(least) < wanted else heapq.heappushpop)(least, -cost)
        return ranked, doubts

    def _is_decided(self, stop: Stop, worst: float, apart: float) -> bool:
        """Whether no place that stands so far from the anchors, or farther, costs less than the worst of the first."""
        if stop.which is Which.FARTHEST or stop.relation is Relation.ON_THE_WAY:
            is_exact = stop.relation in (Relation.NEAR, Relation.ON_THE_WAY)
            return is_exact and isinstance(self._scene.ways, Straight)
        is_outwards = stop.relation in _OUTWARDS
        if stop.relation in _BY_DETOUR:
            is_outwards = isinstance(self._scene.ways, Straight)
        return is_outwards and apart > worst

    def _judged(self, stop: Stop, place: Place, anchors: Sequence[Near], start: Point | None) -> Judged:
        """The cheapest of all anchors that may be meant; no place is its own anchor."""
        others = [near.to(place) for near in anchors]
        if not all(others):
            return Judged(math.inf)
        if stop.relation is Relation.BETWEEN:
            if len(others) < 2:
                return PAIRED[Relation.NEAR](place, others[0][0], self._scene)
            pairs = [between(place, one, two, self._scene) for one in others[0] for two in others[1] if one is not two]
            return min(pairs, key=lambda each: each.cost, default=Judged(math.inf))
        if stop.relation is Relation.ON_THE_WAY:
            return min((on_the_way(place, each, start, self._scene) for each in others[0]), key=lambda each: each.cost)
        assert stop.relation is not None
        judge = PAIRED[stop.relation]
        if stop.same_side:
            others[0] = [each for each in others[0] if self._scene.is_same_side(place, each)]
        judged = (judge(place, each, self._scene) for each in others[0])
        return min(judged, key=lambda each: each.cost, default=Judged(math.inf))

    def _picked(self, served: Served, ranked: Sequence[_Ranked], notes: list[str]) -> Solved:
        stop = served.stop
        at = stop.rank - 1
        if at >= len(ranked):
            notes.append(f"there are only {len(ranked)} that serve")
            return self._none(served, notes, [each.place for each in ranked])
        chosen = ranked[at]
        sure = served.certainty
        rival = ranked[at + 1] if at + 1 < len(ranked) else None
        is_ordered = stop.which in (Which.NEAREST, Which.FARTHEST) or stop.relation is not None
        if rival is not None and is_ordered:
            spread = math.hypot(chosen.place.uncertainty, rival.place.uncertainty)
            if spread > 0.0 and abs(rival.cost - chosen.cost) < self.config.decided_sigmas * spread:
                notes.append(f"{rival.place.name} may be as near: the difference is within what the map knows")
                sure *= self.config.undecided_share
        others = [each.place for each in ranked if each.place is not chosen.place]
        others += [place for place in self._listed(served)[: self.config.alternatives] if place is not chosen.place]
        others += [self._scene.sites.by_id[id_] for id_ in served.others if id_ in self._scene.sites.by_id]
        return Solved(
            stop,
            chosen.place,
            tuple(dict.fromkeys(others))[: self.config.listed if stop.which is Which.ALL else self.config.alternatives],
            round(min(sure, 0.99), 3),
            served.reason(chosen.place.id),
            tuple(dict.fromkeys(notes)),
            served.model,
        )
