"""What the embedded model knows, read from the tables in `data/`: kinds of place, brands, words, wants, warnings.

The gazetteer comes from openly licensed indexes (`tools/build_gazetteer.py`); the lexicon is written by hand: topics
in all languages side by side, and one file a language for how it refuses, warns and turns a sentence. A further
language or topic is a further file, not further code.
"""

import lzma
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache
from importlib.resources import files
from typing import Any

from lpslam.language.kept import kept
from lpslam.language.tables.concepts import Buildings, load_buildings
from lpslam.language.tables.forms import load_folder
from lpslam.language.tables.lexicon import (
    Meaning,
    SpokenTables,
    load_gazetteer,
    load_lexicons,
    packed,
    phrases_of,
    read_table,
    split,
    unpacked,
)
from lpslam.language.tables.painted import Known, KnownNames, add_brands, add_kinds, add_painted, add_venues
from lpslam.language.tables.states import StateTables
from lpslam.language.tables.words import Folder, PhraseTable

_SUBSTITUTE = 0.8
_TRADE_FIRST = ("de", "es", "fr")
_ROLES_CALLED = {"forbidding": "sign_forbidding"}


@dataclass(frozen=True, eq=False)
class Knowledge:
    """All tables, ready to look up. Phrase tables are keyed by `Folder.phrase`, `known` by `Folder.key`."""

    folder: Folder
    painted: PhraseTable[Meaning]
    common: Mapping[str, frozenset[str]]
    articles: frozenset[str]
    joining: frozenset[str]
    leading: frozenset[str]
    turning: frozenset[str]
    asking: frozenset[str]
    both: frozenset[str]
    wishing: Mapping[str, frozenset[str]]
    negating: Mapping[str, frozenset[str]]
    warning_starts: frozenset[str]
    forbidding: frozenset[str]
    known: Mapping[str, Known]
    general: frozenset[str]
    modifiers: frozenset[str]
    national: frozenset[str]
    people: frozenset[str]
    worn: frozenset[str]
    relatives: Mapping[str, PhraseTable[str]]
    auxiliary: frozenset[str]
    treatments: frozenset[str]
    instead: Mapping[str, str]
    instead_of: Mapping[str, str]
    offers: Mapping[str, Mapping[str, float]]
    isa: Mapping[str, tuple[str, ...]]
    contained: Mapping[str, frozenset[str]]
    apart: Mapping[str, frozenset[str]]
    light_food: frozenset[str]
    refusing: Mapping[str, str]
    said_of_food: frozenset[str]
    symptoms: frozenset[str]
    weather: frozenset[str]
    venues: frozenset[str]
    trade_goods: frozenset[str]
    imperatives: frozenset[str]
    company_forms: frozenset[str]
    families: Mapping[str, tuple[str, ...]]
    doors: frozenset[str]
    _tables: "SpokenTables"

    def __post_init__(self) -> None:
        # Kinds and concepts are a few thousand, and are looked up all the time.
        for name in ("family", "above", "share", "served_by"):
            object.__setattr__(self, name, cache(getattr(self, name)))

    def spoken(self, language: str) -> PhraseTable[Meaning]:
        """Return what the phrases of a language mean in a question; built when it is first asked for."""
        return self._tables.of(language)

    def tables_of(self, language: str, is_plain: bool = False) -> tuple[PhraseTable[Meaning], ...]:
        """Return the tables in which a question is looked up: the language's, and English words that it borrows.

        Plain, they are without the turns of phrase of hospitals, offices and so on.
        """
        tables = self._tables.with_english(language)
        return (self._tables.plain(language), *tables[1:]) if is_plain else tables

    def turns_of(self, language: str) -> frozenset[str]:
        """Return the phrases of a language that mean something else, or nothing, when it is read plainly."""
        return self._tables.turns_of(language)

    def states(self, language: str) -> StateTables:
        """Return the things and states of a language."""
        return self._tables.states_of(language)

    def family(self, kind: str) -> str:
        """Return the sort of building whose rooms are of this kind: a hospital for a department; "" for none."""
        return next((name for name, starts in self.families.items() if kind.startswith(starts)), "")

    def word_for(self, concept: str, language: str) -> str | None:
        """Return how a language calls a concept; None where no table says so. "zh-Hant" is traditional Chinese."""
        return self._tables.word_for(concept, language)

    def above(self, kind: str) -> tuple[str, ...]:
        """Return `kind` and every more general kind above it, the nearest first."""
        found: dict[str, None] = {}
        left = [kind]
        while left:
            here = left.pop(0)
            if here not in found:
                found[here] = None
                left.extend([here.rsplit("/", 1)[0]] if "/" in here else [])
                left.extend(self.isa.get(here, ()))
        return tuple(found)

    def share(self, concept: str, kind: str) -> float:
        """Return how well a place of `kind` serves `concept`, 0..1: it is one, or it offers it.

        What is said of the kind itself goes before what is said of the kinds above it: a café serves coffee, a
        bubble tea shop, though a kind of café, hardly.
        """
        return 1.0 if concept in self.above(kind) else self._offered(concept, kind)

    def _offered(self, concept: str, kind: str) -> float:
        tables = [(1.0, self.offers[concept])] if concept in self.offers else []
        if concept.startswith("shop/"):
            # A shop asked for by its kind may be replaced by one that sells the same.
            tables += [(_SUBSTITUTE, table) for table in self._goods_of.get(concept, ())]
        shares = [
            trust * next((table[above] for above in self.above(kind) if above in table), 0.0) for trust, table in tables
        ]
        return max(shares, default=0.0)

    def served_by(self, kind: str) -> Mapping[str, float]:
        """Return all concepts that a place of `kind` serves, and how well: `share`, the other way round."""
        above = self.above(kind)
        offered = {concept for each in above for concept in self._offered_by.get(each, ())}
        # A shop serves as another that sells the same first of all.
        alike = {next(iter(self.offers[concept])) for concept in offered}
        concepts = sorted({*above, *offered, *(each for each in alike if each.startswith("shop/"))})
        return {concept: self.share(concept, kind) for concept in concepts}

    @cached_property
    def _offered_by(self) -> Mapping[str, list[str]]:
        """The concepts that each kind is said to offer."""
        found: dict[str, list[str]] = {}
        for concept, table in self.offers.items():
            for kind in table:
                found.setdefault(kind, []).append(concept)
        return found

    @cached_property
    def _goods_of(self) -> Mapping[str, list[Mapping[str, float]]]:
        """The offers whose first and best seller is a kind of shop."""
        found: dict[str, list[Mapping[str, float]]] = {}
        for table in self.offers.values():
            if table:
                found.setdefault(next(iter(table)), []).append(table)
        return found


@lru_cache(maxsize=1)
def load_knowledge() -> Knowledge:
    """Read the tables of the package, once a process; as they were read before, where the cache has them."""
    made: dict[str, Any] = kept("tables", b"", _made)
    return Knowledge(
        folder=load_folder(),
        painted=PhraseTable(unpacked(made.pop("painted"))),
        known=KnownNames(made.pop("known")),
        relatives={language: PhraseTable(each) for language, each in made.pop("relatives").items()},
        _tables=SpokenTables(load_folder()),
        **made,
    )


def _made() -> dict[str, Any]:
    """The fields of `Knowledge`, of plain values."""
    kinds = read_table("lexicon/kinds.json")
    buildings = load_buildings()
    folder = load_folder()
    lexicons = load_lexicons()
    gazetteer = load_gazetteer()
    painted, known = _painted(kinds, folder, lexicons, gazetteer)
    sets = (
        *("general", "modifiers", "national", "people", "worn", "auxiliary", "treatments", "light_food", "weather"),
        *("said_of_food", "symptoms", "venues", "trade_goods", "imperatives", "company_forms"),
    )
    roles = ("joining", "turning", "asking", "both", "forbidding")
    return {
        "painted": packed(painted),
        "known": {key: tuple(each) for key, each in known.items()},
        "common": {language: phrases_of(folder, lexicon.get("common", "")) for language, lexicon in lexicons.items()},
        "articles": _in_any(lexicons, "article", folder),
        "leading": _leading(lexicons, folder),
        **{
            role: {language: phrases_of(folder, lexicon[role]) for language, lexicon in lexicons.items()}
            for role in ("wishing", "negating")
        },
        "warning_starts": _in_any(lexicons, "sign_warning_start", folder),
        **{role: _in_any(lexicons, _ROLES_CALLED.get(role, role), folder) for role in roles},
        **{name: frozenset(kinds[name]) for name in sets},
        "relatives": {
            language: {folder.phrase(text): who for who, joined in by_whom.items() for text in split(joined)}
            for language, by_whom in kinds["relatives"].items()
        },
        **{name: kinds[name] for name in ("instead", "instead_of", "refusing")},
        "offers": _with_sellers(kinds["offers"], buildings),
        "isa": _above_of(buildings, kinds["isa"]),
        **{name: {of: frozenset(split(each)) for of, each in kinds[name].items()} for name in ("contained", "apart")},
        "families": dict(buildings.families),
        "doors": frozenset(map(folder.key, kinds["doors"])),
    }


def _painted(
    kinds: Mapping[str, Any], folder: Folder, lexicons: Mapping[str, Mapping[str, Any]], gazetteer: Mapping[str, Any]
) -> tuple[dict[str, Meaning], dict[str, Known]]:
    """What signs are painted with, and which names are known."""
    unpainted = frozenset(kinds["unpainted"])
    painted: dict[str, Meaning] = {}
    known: dict[str, Known] = {}
    for lexicon in lexicons.values():
        add_painted(lexicon, folder, unpainted, painted, known)
    for joined, kinds_of in read_table("lexicon/makers.json")["makers"].items():
        names = joined.split("|")
        for name in names:
            known.setdefault(folder.key(name), Known(name, "brand", tuple(kinds_of.items()), names[0]))
    add_brands(gazetteer["brands"], kinds["cuisine_kinds"], known)
    for painted_name, joined in read_table("lexicon/nicknames.json").items():
        called = known.get(folder.key(painted_name))
        if called is not None:
            for name in split(joined):
                known.setdefault(folder.key(name), Known(name, "brand", called.kinds, called.identity))
    joining = _in_any(lexicons, "joining", folder)
    add_kinds(gazetteer["names"], kinds["cuisine_kinds"], joining, painted, known)
    for lexicon in lexicons.values():
        add_venues(lexicon, folder, painted, known)
    return painted, known


def _with_sellers(offers: Mapping[str, Mapping[str, float]], buildings: Buildings) -> Mapping[str, Mapping[str, float]]:
    """What serves a concept, with what its entry says of that."""
    found = {concept: dict(shares) for concept, shares in offers.items()}
    for entry in buildings.concepts:
        if entry.sellers:
            known = found.setdefault(entry.name, {})
            known.update({kind: max(share, known.get(kind, 0.0)) for kind, share in entry.sellers.items()})
    return found


def _above_of(buildings: Buildings, isa: Mapping[str, Sequence[str]]) -> Mapping[str, tuple[str, ...]]:
    """The kinds above each kind, with those that entries name."""
    found = {kind: tuple(parents) for kind, parents in isa.items()}
    for entry in buildings.concepts:
        if entry.above:
            found[entry.name] = tuple(dict.fromkeys((*found.get(entry.name, ()), *entry.above)))
    return found


def _in_any(lexicons: Mapping[str, Mapping[str, Any]], role: str, folder: Folder) -> frozenset[str]:
    """The phrases that have a role in any language."""
    return frozenset().union(*(phrases_of(folder, lexicon.get(role, "")) for lexicon in lexicons.values()))


def _leading(lexicons: Mapping[str, Mapping[str, Any]], folder: Folder) -> frozenset[str]:
    """The words of languages that name the trade first and the owner after it: Boulangerie Petit Jean."""
    said = {
        language: {folder.phrase(text) for joined in lexicons[language]["means"].values() for text in split(joined)}
        for language in ("en", *_TRADE_FIRST)
    }
    return frozenset(set().union(*(said[language] for language in _TRADE_FIRST)) - said["en"])


@lru_cache(maxsize=1)
def load_words() -> frozenset[str]:
    """Common words of European languages, as `Folder.key` gives them (about 20 ms, once a process)."""
    return _listed("words.txt.xz")


@lru_cache(maxsize=1)
def load_short_words() -> frozenset[str]:
    """Very common words of two and three letters (to, der, las), which are too short to be spelt by."""
    return _listed("words_short.txt.xz")


@lru_cache(maxsize=1)
def load_chinese_words() -> frozenset[str]:
    """Common Chinese words of two to four characters, as `Folder.key` gives them (about 20 ms, once a process)."""
    return _listed("words_zh.txt.xz")


def _listed(name: str) -> frozenset[str]:
    packed = (files("lpslam.language") / "data" / name).read_bytes()
    return frozenset(lzma.decompress(packed).decode().split("\n"))
