"""How well the place behind a sign serves what is wanted."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

from lpslam.language.questions.wanted import Wish, is_eaten
from lpslam.language.tables.knowledge import Knowledge

Kinds = tuple[tuple[str, float], ...]

FITS = 0.45  # a landmark that serves the wish less than this is not offered
FITS_INSTEAD = 0.34  # where what fits better is refused
_REFUSED_KIND = 0.4  # a place is what is refused when its words say so at least this surely
_SIDE_OFFER = 0.7  # a place that sells what is refused this surely, beside other things
_CLEARLY = 0.03  # by which a place must be better at what is refused than at what is wanted
_SIDE_REFUSED = 0.5  # what such a place loses
_LIGHT_MEAL = 0.7  # of a place that sells cake or coffee first of all
_SERVES_MEALS = frozenset({"amenity/restaurant", "facility/canteen"})  # also where it is a café as well
_APART = 0.5  # of a kind that is not meant by the one above it: bubble tea, for a café
_FOR_SOME = 0.8  # of a place whose goods are for women, men or children alone, where nobody is named
_SURE = 0.9  # a kind of this weight is what the place is


Matches = Mapping[str, Mapping[int, float]]
"""How well groups of places serve concepts, by concept and by group; those that do."""


@dataclass(frozen=True, slots=True)
class Served:
    """How well a group of places serves a wish: the whole score, and the best match of what it must serve."""

    group: int
    score: float
    best: float


def best_of(scores: Mapping[int, float]) -> int:
    """The landmark of the highest score, of equals the one of the lowest id."""
    top = max(scores.values())
    return min([id_ for id_, score in scores.items() if score == top])


def likeness(concept: str, kinds: Kinds, knowledge: Knowledge) -> float:
    """How surely a place of these kinds is the concept itself or a kind of it."""
    return _any_of({concept}, kinds, knowledge)


def _any_of(concepts: Set[str], kinds: Kinds, knowledge: Knowledge) -> float:
    # A bubble tea shop, though a kind of café, is not meant by one.
    return max(
        (
            weight
            for kind, weight in kinds
            if any(each in concepts and kind not in knowledge.apart.get(each, ()) for each in knowledge.above(kind))
        ),
        default=0.0,
    )


def match(concept: str, kinds: Kinds, knowledge: Knowledge) -> float:
    """How well a place of these kinds serves the concept: it is one, or it offers it."""
    apart = knowledge.apart.get(concept, frozenset())
    best = max(
        (weight * min(knowledge.share(concept, kind), _APART if kind in apart else 1.0) for kind, weight in kinds),
        default=0.0,
    )
    sure = {kind for kind, weight in kinds if weight >= _SURE}
    is_light = not sure.isdisjoint(knowledge.light_food) and sure.isdisjoint(_SERVES_MEALS)
    return min(best, _LIGHT_MEAL) if concept == "food" and is_light else best


def whom_for(kinds: Kinds, knowledge: Knowledge) -> frozenset[str]:
    """Whom alone the goods of a place are for: women, men or children."""
    return knowledge.people.intersection(kind.removeprefix("trait/") for kind, _ in kinds)


def serve(
    wish: Wish, matches: Matches, kinds: Sequence[Kinds], people: Mapping[int, frozenset[str]], knowledge: Knowledge
) -> list[Served]:
    """Score groups of places of some kinds for a wish, without those that are what the wish refuses.

    `people` says for whom alone the goods of a group are, where they are not for everybody.
    """
    scores: dict[int, float] = {}
    for concept, weight in wish.wanted:
        for group, share in matches[concept].items():
            scores[group] = scores.get(group, 0.0) + weight * share
    asked_for = knowledge.people.intersection(dict(wish.wanted))
    vague = (knowledge.modifiers | knowledge.general).issuperset(wish.main)
    main = [matches[concept] for concept in wish.main]
    found: list[Served] = []
    for group, score in scores.items():
        if group in people:
            if asked_for and people[group].isdisjoint(asked_for):
                # Whoever wants clothes for men is not sent to a women's shop.
                continue
            score *= 1.0 if asked_for else _FOR_SOME
        best = max((each.get(group, 0.0) for each in main), default=0.0)
        if wish.refused:
            score *= _unrefused(wish, best, vague, kinds[group], knowledge)
        if score > 0.0:
            found.append(Served(group, score, best))
    return found


def _unrefused(wish: Wish, best: float, vague: bool, kinds: Kinds, knowledge: Knowledge) -> float:
    """What a place keeps of its score beside what is refused: 0 where it is that."""
    share = 1.0
    for concept in wish.refused:
        # Ramen has noodles in it, and Thai food is hot.
        own = _any_of({concept, *knowledge.contained.get(concept, ())}, kinds, knowledge)
        is_spared = concept == "coffee" or (concept == "tea" and own < _REFUSED_KIND)
        if own >= _REFUSED_KIND and not is_spared:
            return 0.0
        ware = match(concept, kinds, knowledge) if "/" not in concept else 0.0
        is_meant = ware > best + _CLEARLY and ware >= _SIDE_OFFER and not is_eaten(concept, knowledge)
        if (ware >= _SURE and vague) or is_meant:
            # “A present, but no toys”: a toy shop has presents, and is not meant; nor Decathlon for what is not sporty.
            return 0.0
        if own < _REFUSED_KIND and is_spared:
            continue
        if own >= _REFUSED_KIND or ware >= _SIDE_OFFER:
            share *= _SIDE_REFUSED
    return share
