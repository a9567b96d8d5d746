"""What a question wants and refuses: what sort of thing each phrase names, and what weighs how much (III-I)."""

from dataclasses import dataclass, field
from functools import lru_cache

from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span

_KEPT = 64  # what one question wants, and its parts
THING = 0.7  # a wanted concept of this weight is a thing of its own
# Asked for by its kind, a restaurant is refused by what it serves.
_PLAIN_KINDS = frozenset({"amenity/restaurant"})
MAIN, MODIFIER, GENERAL, ASIDE, HINT = 1.0, 0.6, 0.3, 0.2, 0.05
"""Weights of a thing that is wanted, of what it is for, of “eat” or “buy”, of what is by the way, of nearly nothing."""
GIFTS = frozenset({"gift", "souvenir"})
"""What is wanted of a shop for somebody else."""
_TREATING = (
    *("amenity/dentist", "amenity/doctors", "amenity/clinic", "amenity/hospital", "amenity/pharmacy", "healthcare"),
    *("facility/xray", "facility/blood_test", "facility/emergency_room", "facility/vaccination"),
)
_TASTES = frozenset({"spicy", "mild_food"})
_OF_ANY_NATION = frozenset({"sweets", "cake", "bread", "ice_cream", "snack", "cuisine/barbecue", "breakfast", "tea"})
_TO_GO = frozenset({"coffee", "tea", "bubble_tea", "juice", "drink", "cake", "bread", "breakfast", "ice_cream"})


@dataclass(frozen=True, slots=True)
class Wish:
    """Concepts wanted and refused, by weight; `language` is None where the question could not be read.

    `wanted_names`, `refused_names` and `near_names` hold the values of the names that were passed in and mentioned;
    `contradicted` are phrases that are wanted and refused in one breath; `rest` is the question
    without what is refused, `left_out` that alone: both are empty where nothing is; `turned` says that turns of phrase
    of other buildings than malls were read in it, so that it may say something else without them.
    """

    wanted: tuple[tuple[str, float], ...]
    refused: tuple[str, ...]
    wanted_names: tuple[str, ...]
    refused_names: tuple[str, ...]
    language: str | None
    near_names: tuple[str, ...] = ()
    contradicted: tuple[str, ...] = ()
    rest: str = ""
    left_out: str = ""
    turned: bool = field(default=False, compare=False)

    @property
    def main(self) -> tuple[str, ...]:
        """The concepts that a place must serve: the weightiest sort of those that are wanted."""
        return _weightiest(self.wanted)


@lru_cache(maxsize=_KEPT)
def _weightiest(wanted: tuple[tuple[str, float], ...]) -> tuple[str, ...]:
    # Every kind of place is held against the same wish.
    things = tuple(concept for concept, weight in wanted if weight >= THING)
    meals = tuple(concept for concept, _ in wanted if concept in ("food", "drink"))
    if things or meals:
        return things or meals
    heaviest = max((weight for _, weight in wanted), default=0.0)
    return tuple(concept for concept, weight in wanted if weight >= 0.9 * heaviest)


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


def as_treated(wanted: dict[str, float], knowledge: Knowledge) -> dict[str, float]:
    """Who wants a suit cleaned wants no suit: beside what is done to a thing, the thing is said by the way."""
    treatments = {concept for concept, weight in wanted.items() if weight >= MAIN and concept in knowledge.treatments}
    if not treatments or "shop" in wanted:
        return wanted
    return {
        concept: weight if concept in treatments or "/" in concept else min(weight, ASIDE)
        for concept, weight in wanted.items()
    }


def without_symptoms(wanted: dict[str, float], knowledge: Knowledge) -> dict[str, float]:
    """Leave out what only says why: pains beside a dentist, rain beside a museum, tired feet beside a meal."""
    services = {concept for concept in wanted if wanted[concept] > MODIFIER and _is_service(concept, knowledge)}
    is_ill = any(concept.startswith(_TREATING) for concept in services)
    meals = any(concept in ("food", "drink") or is_eaten(concept, knowledge) for concept in wanted)
    is_gift = not GIFTS.isdisjoint(wanted)
    vague = set(knowledge.symptoms) if is_ill or is_gift else set()
    if not knowledge.weather.isdisjoint(wanted):
        # “It is so hot outside.”
        wanted = {concept: weight for concept, weight in wanted.items() if concept != "leave"}
    others = {concept for concept in wanted if wanted[concept] > MODIFIER} - set(knowledge.weather)
    vague |= set(knowledge.weather) if others or meals else set()
    # “Is there a florist in this hospital?”, “a present, but she has hay fever”.
    vague |= set(knowledge.venues) if others - knowledge.venues or meals or is_gift else set()
    # “I want to send a parcel.”
    vague |= {"store_luggage"} if is_gift or others & {"mail", "parcel", "pet_grooming"} else set()
    # “I lost my earphones and want to buy new ones.”
    vague |= {"lost_item"} if "shop" in wanted and others - {"lost_item"} else set()
    # “Japanese sweets” are sweets first of all, and “a souvenir of Japan” is nothing to eat.
    vague |= knowledge.national if is_gift or others & _OF_ANY_NATION else set()
    # “A coffee to go.”
    vague |= {"amenity/fast_food"} if any(concept in _TO_GO for concept in others) else set()
    # “I want to buy flowers for my ill grandmother.”
    vague |= {"doctor"} if "shop" in wanted and others - {"doctor"} else set()
    # “Excuse me, may I ask where …”
    vague |= {"ask"} if others - {"ask"} else set()
    vague |= {"rest"} if services or meals or "massage" in others else set()
    # A dish that is named says more than how it should taste.
    vague |= _TASTES if any(is_eaten(concept, knowledge) for concept in others - _TASTES) else set()
    # “Somewhere the kids can sit down for dinner.”
    vague |= {"children_play"} if meals else set()
    return {concept: min(weight, HINT) if concept in vague else weight for concept, weight in wanted.items()}


def _is_service(concept: str, knowledge: Knowledge) -> bool:
    """Whether a place, not a thing from a shop, is what the concept asks for."""
    first = concept if "/" in concept else next(iter(knowledge.offers.get(concept, ())), "shop/")
    return concept not in knowledge.treatments and not first.startswith(("shop/", "cuisine/"))
