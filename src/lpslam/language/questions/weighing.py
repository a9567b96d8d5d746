"""What of a question weighs how much: beside what is wanted, much is only said by the way (choosing, III-I)."""

from lpslam.language.questions.sorts import is_eaten
from lpslam.language.tables.knowledge import Knowledge

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
