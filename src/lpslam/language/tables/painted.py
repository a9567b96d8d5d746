"""What signs are painted with: brands, words for kinds of place, warnings and slogans, gathered from all tables."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from lpslam.language.tables.lexicon import BY_HAND, BY_NAME, Meaning, add_beside, split, with_cuisine
from lpslam.language.tables.words import Folder

_SIGN_ROLES = {"sign_warning": "sign/warning", "sign_slogan": "sign/slogan"}
_SURE_SLOGAN = 4  # words or characters of a slogan that no shop's name comes near to by chance
_TOO_SHORT_INSIDE = 2  # letters of an abbreviation (HR, QA) that is a sign of its own, and chance inside another
_FUEL = "amenity/fuel"
_BARS_OF = {"bubble_tea": "amenity/cafe/bubble_tea", "juice": "amenity/fast_food/juice"}
_OUT_OF_DOORS = ("amenity/fuel", "amenity/charging_station", "amenity/recycling", "office/", "emergency/", "tourism/")
"""Kinds that seldom have a sign among shops: Indigo is a bookshop sooner than a place to charge a car."""


class Known(NamedTuple):
    """A name known as it is painted: a brand, a maker, a warning or a word for a kind of place."""

    painted: str
    source: str
    kinds: tuple[tuple[str, float], ...]
    identity: str


class KnownNames(Mapping[str, Known]):
    """Names as they are kept, each made when it is looked up: few of 60,000 are."""

    def __init__(self, made: Mapping[str, tuple[Any, ...]]) -> None:
        self._made = made

    def __getitem__(self, key: str) -> Known:
        return Known._make(self._made[key])

    def __contains__(self, key: object) -> bool:
        return key in self._made

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)


def add_painted(
    lexicon: Mapping[str, Any],
    folder: Folder,
    unpainted: frozenset[str],
    painted: dict[str, Meaning],
    known: dict[str, Known],
) -> None:
    """Add what one language's signs are painted with; a warning or slogan goes before a place."""
    gathered: dict[str, dict[str, float]] = {}
    for role, kind in _SIGN_ROLES.items():
        for text in split(lexicon.get(role, "")):
            painted.setdefault(folder.phrase(text), Meaning("sign", ((kind, 1.0),)))
            if kind == "sign/warning" or len(folder.phrase(text).split()) >= _SURE_SLOGAN:
                known.setdefault(folder.key(text), Known(text, "warning", ((kind, 1.0),), text))
    for concept, joined in lexicon["means"].items():
        if concept in unpainted:
            continue
        # Goods and wants are no names; kinds of place and of facility are what signs are painted with.
        is_name = "/" in concept and not concept.startswith("sign")
        word = ((concept, BY_HAND),)
        for text in dict.fromkeys(split(joined)):
            phrase, key = folder.phrase_and_key(text)
            gathered.setdefault(phrase, {})[concept] = BY_HAND
            if is_name and len(key) > 1:
                known.setdefault(key, Known(text, "word", word, text))
    for phrase, found in gathered.items():
        painted.setdefault(phrase, Meaning("means", tuple(found.items())))


def add_venues(
    lexicon: Mapping[str, Any], folder: Folder, painted: dict[str, Meaning], known: dict[str, Known]
) -> None:
    """Add the kinds of places in hospitals, airports and so on, beside what their words mean in a mall."""
    for concept, joined in lexicon["venues"].items():
        for text in dict.fromkeys(split(joined)):
            phrase, key = folder.phrase_and_key(text)
            if not (len(key) <= _TOO_SHORT_INSIDE and key.isascii()):
                add_beside(painted, concept, (phrase,), frozenset())
            if len(key) > 1 and key not in known:
                known[key] = Known(text, "word", ((concept, BY_HAND),), text)


def _sells(kinds: Mapping[str, float]) -> bool:
    return any(kind.startswith("shop/") for kind in kinds)


def add_brands(rows: Iterable[Any], cuisine_kinds: Mapping[str, str], known: dict[str, Known]) -> None:
    """Add brands, as the index lists them: those of many names before their namesakes.

    What a brand of another trade is called first goes before what one is called besides: Tous is a jeweller. What is
    written by hand stays; and rows of one trade that share a name are one brand: KFC and 肯德基.
    """
    by_hand = frozenset(known)
    for joined, keys, kinds_of, cuisines in rows:
        names = joined.split("|")
        if "shop/supermarket" in kinds_of:
            # A supermarket is no petrol station for having some elsewhere.
            kinds_of = [kind for kind in kinds_of if kind != _FUEL]
        found = dict.fromkeys([*kinds_of, *(cuisine_kinds.get(each, f"cuisine/{each}") for each in cuisines)], 1.0)
        own = next(
            (kind for drink, kind in _BARS_OF.items() if drink in found and "coffee" not in found), "amenity/cafe"
        )
        # The index lists them as cafés, which asks for coffee there.
        found = {own if kind == "amenity/cafe" else kind: 1.0 for kind in found}
        weighed = tuple(found.items())
        of_hand = next((known[key] for key in keys.split("|") if key in by_hand and known[key].source == "brand"), None)
        if of_hand is not None and _sells(found) and _sells(dict(of_hand.kinds)):
            # What the index says of Li-Ning is less than what is known of it.
            weighed, found = of_hand.kinds, dict(of_hand.kinds)
        held_by = (known[key] for key in keys.split("|") if key in known and known[key].source == "brand")
        identity = next((held.identity for held in held_by if not found.keys().isdisjoint(dict(held.kinds))), names[0])
        for at, (name, key) in enumerate(zip(names, keys.split("|"), strict=True)):
            held = known.get(key)
            is_namesake = (
                at == 0
                and key not in by_hand
                and held is not None
                and held.source == "brand"
                and held.painted != held.identity
                and not all(kind.startswith(_OUT_OF_DOORS) for kind in found)
            )
            if len(key) > 1 and (held is None or (is_namesake and found.keys().isdisjoint(dict(held.kinds)))):
                known[key] = Known(name, "brand", weighed, identity)


def add_kinds(
    by_language: Mapping[str, Mapping[str, Any]],
    cuisine_kinds: Mapping[str, str],
    joining: frozenset[str],
    painted: dict[str, Meaning],
    known: dict[str, Known],
) -> None:
    """Add the names of kinds of place in every language; the shorter kind id is the more general and comes first."""
    for names in by_language.values():
        for kind, rows in names.items():
            concepts = tuple((concept, BY_NAME) for concept in with_cuisine(kind, cuisine_kinds))
            meaning = Meaning("means", concepts)
            for text, phrase, key in rows:
                # Without its accent, thé is an English article; one letter or sign says nothing sure.
                if len(phrase) > 1 and phrase not in joining:
                    painted.setdefault(phrase, meaning)
                if len(key) > 1 and key not in known:
                    known[key] = Known(text, "word", concepts, text)
