"""What sort of thing a phrase of a question names: a dish, a ware, a place, or nothing in particular (III-I)."""

from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span

# Asked for by its kind, a restaurant is refused by what it serves.
_PLAIN_KINDS = frozenset({"amenity/restaurant"})


def is_eaten(concept: str, knowledge: Knowledge) -> bool:
    """Whether a concept is food or drink of some sort."""
    return any(knowledge.instead.get(above) in ("food", "drink", "sweets") for above in knowledge.above(concept))


def is_meal(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase names food or drink."""
    return span.value.role == "means" and any(is_eaten(concept, knowledge) for concept, _ in span.value.concepts)


def is_drink_of_cafes(span: Span[Meaning]) -> bool:
    """Whether a phrase is the place and the drink in one, as Spanish “café” is."""
    return span.value.role == "means" and all(concept == "amenity/cafe" for concept, _ in span.value.concepts)


def is_general(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase says no more than “eat”, “buy” or “a place”."""
    return span.value.role == "means" and all(concept in knowledge.general for concept, _ in span.value.concepts)


def is_plain(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase says no more than “eat” or “a restaurant”."""
    return is_general(span, knowledge) or (
        span.value.role == "means" and all(concept in _PLAIN_KINDS for concept, _ in span.value.concepts)
    )


def is_modifier(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase says for whom or for what: “for a present, but no flowers” refuses flowers."""
    return span.value.role == "means" and all(concept in knowledge.modifiers for concept, _ in span.value.concepts)


def is_vague(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase alone hardly says where to go: “eat”, “for a child”, “help”."""
    return is_plain(span, knowledge) or (
        span.value.role == "means"
        and all(concept in knowledge.modifiers or concept in knowledge.auxiliary for concept, _ in span.value.concepts)
    )


def is_place(span: Span[Meaning]) -> bool:
    """Whether a phrase names a kind of place to go to, not a thing."""
    return span.value.role == "means" and all(
        "/" in concept and not concept.startswith(("cuisine/", "facility/toilets"))
        for concept, _ in span.value.concepts
    )


def is_ware(span: Span[Meaning], knowledge: Knowledge) -> bool:
    """Whether a phrase names what is eaten or bought; who tells of being hurt or lost wants help with that."""
    firsts = [next(iter(knowledge.offers.get(concept, ())), "") for concept, _ in span.value.concepts]
    is_done = any(concept in knowledge.treatments for concept, _ in span.value.concepts)
    return is_meal(span, knowledge) or (not is_done and all(first.startswith("shop/") for first in firsts))
