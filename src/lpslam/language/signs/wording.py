"""What the phrases found on a sign say together."""

import re
from collections.abc import Sequence, Set

from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span, is_mark, is_unspaced

TRADES = (
    *("shop/", "cuisine/", "craft/", "amenity/restaurant", "amenity/cafe", "amenity/bar", "amenity/pub"),
    "leisure/fitness_centre",
)
_SURROUNDINGS = (
    *("facility/platform", "railway/", "highway/", "leisure/park", "leisure/garden", "amenity/parking"),
    "train",
)
_VENUES = ("amenity/hospital", "amenity/clinic", "aeroway/aerodrome", "shop/mall")
_WHOM_FOR = {"facility/toilets_women": "woman", "facility/toilets_men": "man"}
SELDOM = 0.4  # the weight of what a sign says by the way
SLOGAN = "sign/slogan"
WARNING = "sign/warning"


def weighed(spans: Sequence[Span[Meaning]]) -> dict[str, float]:
    """Return what phrases say by weight."""
    kinds: dict[str, float] = {}
    for span in spans:
        for kind, weight in span.value.concepts:
            kinds[kind] = max(weight, kinds.get(kind, 0.0))
    return kinds


def places_in(kinds: dict[str, float]) -> dict[str, float]:
    """Return the kinds that are of places, not of signs."""
    return {kind: weight for kind, weight in kinds.items() if not kind.startswith("sign")}


def said_in(spans: Sequence[Span[Meaning]]) -> str:
    """Return the phrases as they are quoted in evidence."""
    return ", ".join(span.key.replace(" ", "") if is_unspaced(span.key) else span.key for span in spans)


def share_covered(spans: Sequence[Span[Meaning]], units: Sequence[str]) -> float:
    """Return the share of a sign's words that are in the phrases."""
    words = sum(not is_mark(unit) for unit in units)
    return sum(span.end - span.start for span in spans) / max(words, 1)


def as_a_house(kinds: dict[str, float], wares: Set[str]) -> dict[str, float]:
    """A pub that is called after the platform beside it is no platform, a hospital's pharmacy no hospital.

    And where `wares` are sold (“Ladies' Fashion”), “Ladies” is no toilet but whom they are for.
    """
    if any(not kind.startswith(_VENUES) and "/" in kind for kind in kinds):
        kinds = {kind: min(weight, SELDOM) if kind.startswith(_VENUES) else weight for kind, weight in kinds.items()}
    if not any(kind in wares or kind.startswith((*TRADES, "amenity/pharmacy", "amenity/bank")) for kind in kinds):
        return kinds
    kinds = for_whom(kinds)
    if any(kind.startswith("cuisine/") for kind in kinds):
        # A bodega with tapas is no corner shop.
        kinds = {kind: min(weight, SELDOM) if kind == "shop/convenience" else weight for kind, weight in kinds.items()}
    return {kind: min(weight, SELDOM) if kind.startswith(_SURROUNDINGS) else weight for kind, weight in kinds.items()}


def for_whom(kinds: dict[str, float]) -> dict[str, float]:
    """“Ladies” beside what is sold says whom it is for."""
    if kinds.keys().isdisjoint(_WHOM_FOR):
        return kinds
    return {_WHOM_FOR.get(kind, kind): weight for kind, weight in kinds.items() if kind != "amenity/toilets"}


def forbids(text: str, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> bool:
    """Whether a sign begins with “no” and goods, or goes on as a sentence does: “NO SHOES”, “No carts beyond here”.

    Shops begin with it too, but then are named: “No Name Bar”, “No. 5 Bakery”.
    """
    if not units or units[0] != "no":
        return False
    goods = bool(spans) and all("/" not in concept for span in spans for concept, _ in span.value.concepts)
    return (text.startswith("No ") and text[3:4].islower()) or (goods and share_covered(spans, units[1:]) >= 1.0)


def without_stray_letters(spans: list[Span[Meaning]], units: Sequence[str]) -> list[Span[Meaning]]:
    """Drop single Han letters inside a name: 花 means flowers at the end of a name or alone, not in 樱花寿司."""
    kept = [span for span in spans if span.end - span.start > 1 or not is_unspaced(span.key) or span.end == len(units)]
    return [span for span in kept if len(kept) == 1 or span.end - span.start > 1 or not is_unspaced(span.key)]


def is_mostly_slogan(spans: Sequence[Span[Meaning]]) -> bool:
    """Whether most of the phrases advertise."""
    slogan = sum(any(kind == SLOGAN for kind, _ in span.value.concepts) for span in spans)
    return 2 * slogan > len(spans)


def reads_like_a_name(text: str, units: Sequence[str]) -> bool:
    """One to four words with vowels or in Han, mostly letters: what an unknown shop front looks like."""
    words = [unit for unit in units if not is_mark(unit)]
    letters = sum(ch.isalpha() for ch in text)
    spaced = [word for word in words if not is_unspaced(word)]
    if is_unspaced(text):
        return 2 <= letters <= 8
    sounding = all(re.search(r"[aeiouy]", word) or not word.isascii() for word in spaced if len(word) > 3)
    return len(words) <= 4 and letters >= 3 and letters >= 0.7 * len(text.replace(" ", "")) and sounding
