"""What a sign means: what its phrases say together, what follows from names in it, and whether it warns."""

import re
from collections.abc import Sequence, Set
from dataclasses import dataclass

from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.painted import Known
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
_HOUSES = ("shop/", "amenity/", "leisure/", "cuisine/", "craft/", "tourism/")
_SHOP_ENDS = frozenset("店馆屋坊铺舗")


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


@dataclass(frozen=True, slots=True)
class SignMeaning:
    """Kinds of place (or of sign) by weight in 0..1, who they belong to, and why.

    `identity` is the known brand or maker; `name_like` says that an unknown text reads like a proper name.
    """

    kinds: tuple[tuple[str, float], ...]
    evidence: str
    identity: str | None = None
    name_like: bool = False

    @property
    def is_place(self) -> bool:
        """Whether the sign names somewhere to go rather than warns, advertises or says nothing."""
        return any(not kind.startswith("sign") for kind, _ in self.kinds)

    @property
    def warns(self) -> bool:
        """Whether the sign warns or forbids."""
        return any(kind == WARNING for kind, _ in self.kinds)


def of_known(known: Known, sure: float, evidence: str, words: dict[str, float] | None = None) -> SignMeaning:
    """What a known name is, and what is told by other `words` beside it."""
    kinds = {kind: sure * weight for kind, weight in known.kinds}
    for kind, weight in (words or {}).items():
        if not kind.startswith("sign"):
            kinds.setdefault(kind, 0.8 * weight)
    return SignMeaning(tuple(kinds.items()), evidence, known.identity if known.source == "brand" else None)


def as_unknown(text: str, units: Sequence[str]) -> SignMeaning:
    """A text that no table knows: perhaps a proper name."""
    name_like = reads_like_a_name(text, units)
    told = "is not known but reads like a name" if name_like else "is not known"
    return SignMeaning((), f"“{text}” {told}", name_like=name_like)


def joined(parts: Sequence[SignMeaning]) -> SignMeaning:
    """Join what the parts of a sign say; a warning in one of them makes the whole a warning."""
    for part in parts:
        if part.warns:
            return part
    telling = [part for part in parts if part.kinds] or list(parts)
    kinds: dict[str, float] = {}
    for part in telling:
        for kind, weight in part.kinds:
            kinds[kind] = max(weight, kinds.get(kind, 0.0))
    if any(not kind.startswith("sign") for kind in kinds):
        kinds = {kind: weight for kind, weight in kinds.items() if not kind.startswith("sign")}
    return SignMeaning(
        tuple(kinds.items()),
        "; ".join(part.evidence for part in telling),
        next((part.identity for part in telling if part.identity), None),
        any(part.name_like for part in parts),
    )


class Warnings:
    """Reads warnings by how they begin and by their words."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._starts = tuple(
            start.replace(" ", "") for start in knowledge.warning_starts if len(start) >= 6 or is_unspaced(start)
        )

    def read(self, text: str, key: str, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> SignMeaning | None:
        """Return what a sign that warns means; None where it does not."""
        if self._ends_in_a_trade(units, spans):
            return None
        start = self._warning_start(key, units)
        if start is not None:
            return SignMeaning(((WARNING, 0.95),), f"“{text}” begins like a warning (“{start}”)")
        if forbids(text, units, spans):
            return SignMeaning(((WARNING, 0.95),), f"“{text}” forbids something")
        if WARNING in weighed(spans):
            return SignMeaning(((WARNING, 0.95),), f"“{text}” has words of a warning")
        return None

    def _ends_in_a_trade(self, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> bool:
        """Whether a sign names a danger only to name a shop after it: “Danger Zone Games”.

        What asks or forbids (“No food”, “Keep off the furniture”) is no name, and goods that one is warned of (coffee,
        water, glass) are no trade.
        """
        words = [at for at, unit in enumerate(units) if not is_mark(unit) and unit not in self._knowledge.company_forms]
        if not words or not spans or units[words[0]] in self._knowledge.imperatives:
            return False
        if is_unspaced(units[words[0]]):
            # 勿忘我花店 begins with a “don't”, and says no more of what must not be done.
            whole = " ".join(units)
            forbids = any(whole.startswith(start) for start in self._knowledge.forbidding)
            kinds = [concept for concept, _ in spans[-1].value.concepts]
            is_house = any(kind.startswith(_HOUSES) for kind in kinds) or units[words[-1]] in _SHOP_ENDS
            return not forbids and is_house and spans[-1].end > words[-1] and spans[-1].end - spans[-1].start > 1
        return spans[-1].end > words[-1] and any(
            concept in self._knowledge.trade_goods or concept.startswith(TRADES)
            for concept, _ in spans[-1].value.concepts
        )

    def _warning_start(self, key: str, units: Sequence[str]) -> str | None:
        for end in range(min(4, len(units)), 0, -1):
            phrase = " ".join(units[:end])
            if phrase in self._knowledge.warning_starts and (len(units) > end or end > 1):
                return phrase.replace(" ", "") if is_unspaced(phrase) else phrase
        if not key.startswith(self._starts):
            return None
        return next((start for start in self._starts if key.startswith(start) and key != start), None)
