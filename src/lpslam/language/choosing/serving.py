"""How well the place behind a sign serves what is wanted."""

from collections.abc import Mapping, Set
from dataclasses import dataclass
from functools import lru_cache

from lpslam.language.questions.sorts import is_eaten
from lpslam.language.questions.wanted import Wish
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


@dataclass(frozen=True, slots=True)
class Served:
    """How well kinds of place serve a wish: the whole score, and the best match of what it must serve."""

    score: float
    best: float
    reasons: tuple[str, ...]


def best_of(scores: Mapping[int, float]) -> int:
    """The landmark of the highest score, of equals the one of the lowest id."""
    top = max(scores.values())
    return min(id_ for id_, score in scores.items() if score == top)


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


@lru_cache(maxsize=1 << 14)
def _whom_for(kinds: Kinds, people: frozenset[str]) -> frozenset[str]:
    """Whom alone the goods of a place are for: women, men or children."""
    return people.intersection(kind.removeprefix("trait/") for kind, _ in kinds)


def serve(wish: Wish, kinds: Kinds, knowledge: Knowledge, matches: Mapping[str, float]) -> Served:
    """Score a place of these kinds for a wish; zero where it is what the wish refuses.

    `matches` says how well the kinds serve each concept that is wanted (`match`).
    """
    score = sum(weight * matches[concept] for concept, weight in wish.wanted)
    if not score:
        return Served(0.0, 0.0, ())
    whom_for, asked_for = _whom_for(kinds, knowledge.people), knowledge.people.intersection(dict(wish.wanted))
    if whom_for and asked_for and whom_for.isdisjoint(asked_for):
        # Whoever wants clothes for men is not sent to a women's shop.
        return Served(0.0, 0.0, ())
    if whom_for and not asked_for:
        score *= _FOR_SOME
    best = max((matches[concept] for concept in wish.main), default=0.0)
    vague = (knowledge.modifiers | knowledge.general).issuperset(wish.main)
    for concept in wish.refused:
        # Ramen has noodles in it, and Thai food is hot.
        own = _any_of({concept, *knowledge.contained.get(concept, ())}, kinds, knowledge)
        is_spared = concept == "coffee" or (concept == "tea" and own < _REFUSED_KIND)
        if own >= _REFUSED_KIND and not is_spared:
            return Served(0.0, 0.0, ())
        ware = match(concept, kinds, knowledge) if "/" not in concept else 0.0
        is_meant = ware > best + _CLEARLY and ware >= _SIDE_OFFER and not is_eaten(concept, knowledge)
        if (ware >= _SURE and vague) or is_meant:
            # “A present, but no toys”: a toy shop has presents, and is not meant; nor Decathlon for what is not sporty.
            return Served(0.0, 0.0, ())
        if own < _REFUSED_KIND and is_spared:
            continue
        if own >= _REFUSED_KIND or ware >= _SIDE_OFFER:
            score *= _SIDE_REFUSED
    reasons = tuple(concept for concept, found in matches.items() if found >= FITS)
    return Served(score, best, reasons)
