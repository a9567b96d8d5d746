"""How well the place behind a sign serves what is wanted."""

from collections.abc import Sequence, Set
from dataclasses import dataclass

from lpslam.language.knowledge import Knowledge
from lpslam.language.question import Wish

Kinds = tuple[tuple[str, float], ...]

FITS = 0.45  # a landmark that serves the wish less than this is not offered
_REFUSED_KIND = 0.4  # a place is what is refused when its words say so at least this surely
_SIDE_OFFER = 0.7  # a place that sells what is refused this surely, beside other things
_SIDE_REFUSED = 0.5  # what such a place loses


@dataclass(frozen=True, slots=True)
class Served:
    """How well kinds of place serve a wish: the whole score, and the best match of what it must serve."""

    score: float
    best: float
    reasons: tuple[str, ...]


def likeness(concept: str, kinds: Kinds, knowledge: Knowledge) -> float:
    """How surely a place of these kinds is the concept itself or a kind of it."""
    return _any_of({concept}, kinds, knowledge)


def _any_of(concepts: Set[str], kinds: Kinds, knowledge: Knowledge) -> float:
    return max((weight for kind, weight in kinds if not concepts.isdisjoint(knowledge.above(kind))), default=0.0)


def match(concept: str, kinds: Kinds, knowledge: Knowledge) -> float:
    """How well a place of these kinds serves the concept: it is one, or it offers it."""
    return max((weight * knowledge.share(concept, kind) for kind, weight in kinds), default=0.0)


def serve(wish: Wish, kinds: Kinds, knowledge: Knowledge) -> Served:
    """Score a place of these kinds for a wish; zero where it is what the wish refuses."""
    matches = {concept: match(concept, kinds, knowledge) for concept, _ in wish.wanted}
    score = sum(weight * matches[concept] for concept, weight in wish.wanted)
    best = max((matches[concept] for concept in wish.main), default=0.0)
    for concept in wish.refused:
        # Ramen has noodles in it, and Thai food is hot.
        own = _any_of({concept, *knowledge.contained.get(concept, ())}, kinds, knowledge)
        if own >= _REFUSED_KIND and not _is_also_another(concept, own, kinds, wish, knowledge):
            return Served(0.0, 0.0, ())
        if own >= _REFUSED_KIND or match(concept, kinds, knowledge) >= _SIDE_OFFER:
            score *= _SIDE_REFUSED
    reasons = tuple(concept for concept, found in matches.items() if found >= FITS)
    return Served(score, best, reasons)


def _is_also_another(concept: str, weight: float, kinds: Kinds, wish: Wish, knowledge: Knowledge) -> bool:
    """Whether the place is as surely another kind beside the refused one (pizza and burgers), not refused itself."""
    top = concept.partition("/")[0]
    return any(
        other >= weight
        and kind.partition("/")[0] == top
        and not any(refused in knowledge.above(kind) for refused in wish.refused)
        for kind, other in kinds
    )


def merged(kinds: Sequence[Kinds]) -> Kinds:
    """All kinds of several signs, each at its surest."""
    found: dict[str, float] = {}
    for each in kinds:
        for kind, weight in each:
            found[kind] = max(weight, found.get(kind, 0.0))
    return tuple(found.items())
