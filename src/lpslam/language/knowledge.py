"""What the embedded model knows, read from the tables in `data/`: kinds of place, brands, words, wants, warnings.

The gazetteer comes from openly licensed indexes (`tools/build_gazetteer.py`); the lexicon is written by hand, one
file a language. A further language is a further file, not further code.
"""

import json
import lzma
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from typing import Any

from lpslam.language.words import Folder

HAND_WRITTEN = ("en", "zh", "ja", "ko", "es", "de", "fr")
_ROLES = ("refuse_before", "refuse_after", "neutral", "break")
_SIGN_ROLES = {"sign_warning": "sign/warning", "sign_slogan": "sign/slogan"}

# How sure a word makes us of a kind: written for this by hand, or a kind's own name in the index.
_BY_HAND, _BY_NAME = 1.0, 0.95


_SUBSTITUTE = 0.8


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a phrase says: a role in the sentence ("means" or a refusal) and, for "means", concepts by weight."""

    role: str
    concepts: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Known:
    """A name known as it is painted: a brand, a maker, a warning or a word for a kind of place."""

    painted: str
    source: str
    kinds: tuple[tuple[str, float], ...]
    identity: str


@dataclass(frozen=True)
class Knowledge:
    """All tables, ready to look up. Phrase tables are keyed by `Folder.phrase`, `known` by `Folder.key`."""

    folder: Folder
    spoken: Mapping[str, Mapping[str, Meaning]]
    painted: Mapping[str, Meaning]
    common: Mapping[str, frozenset[str]]
    warning_starts: frozenset[str]
    known: Mapping[str, Known]
    general: frozenset[str]
    modifiers: frozenset[str]
    instead: Mapping[str, str]
    offers: Mapping[str, Mapping[str, float]]
    isa: Mapping[str, tuple[str, ...]]
    _above: dict[str, tuple[str, ...]] = field(default_factory=dict)
    _shares: dict[tuple[str, str], float] = field(default_factory=dict)

    def above(self, kind: str) -> tuple[str, ...]:
        """Return `kind` and every more general kind above it, the nearest first."""
        if kind not in self._above:
            found: dict[str, None] = {}
            left = [kind]
            while left:
                here = left.pop(0)
                if here not in found:
                    found[here] = None
                    left.extend([here.rsplit("/", 1)[0]] if "/" in here else [])
                    left.extend(self.isa.get(here, ()))
            self._above[kind] = tuple(found)
        return self._above[kind]

    def share(self, concept: str, kind: str) -> float:
        """Return how well a place of `kind` serves `concept`, 0..1: it is one, or it offers it.

        What is said of the kind itself goes before what is said of the kinds above it: a café serves coffee, a
        bubble tea shop, though a kind of café, hardly.
        """
        if (concept, kind) not in self._shares:
            self._shares[concept, kind] = 1.0 if concept in self.above(kind) else self._offered(concept, kind)
        return self._shares[concept, kind]

    def _offered(self, concept: str, kind: str) -> float:
        tables = [(1.0, self.offers[concept])] if concept in self.offers else []
        if concept.startswith("shop/"):
            # A shop asked for by its kind may be replaced by one that sells the same.
            tables += [(_SUBSTITUTE, table) for table in self.offers.values() if next(iter(table)) == concept]
        shares = [
            trust * next((table[above] for above in self.above(kind) if above in table), 0.0) for trust, table in tables
        ]
        return max(shares, default=0.0)


@lru_cache(maxsize=1)
def load_knowledge() -> Knowledge:
    """Read every table of the package (about 0.3 s, once a process)."""
    kinds = _read("lexicon/kinds.json")
    han = _read("lexicon/han.json")
    folder = Folder(han["traditional"], han["simplified"], han["lookalikes"])
    lexicons = {language: _read(f"lexicon/{language}.json") for language in HAND_WRITTEN}
    makers = _read("lexicon/makers.json")
    gazetteer = json.loads(lzma.decompress((files("lpslam.language") / "data" / "gazetteer.json.xz").read_bytes()))
    named = _kind_phrases(folder, gazetteer["names"], kinds)
    spoken: dict[str, Mapping[str, Meaning]] = {}
    painted: dict[str, Meaning] = {}
    for language, lexicon in lexicons.items():
        by_hand = _concept_phrases(folder, lexicon["means"])
        roles = {folder.phrase(text): Meaning(role) for role in _ROLES for text in _split(lexicon.get(role, ""))}
        spoken[language] = {**named.get(language, {}), **by_hand, **roles}
        signs = {
            folder.phrase(text): Meaning("sign", ((kind, 1.0),))
            for role, kind in _SIGN_ROLES.items()
            for text in _split(lexicon.get(role, ""))
        }
        for phrase, meaning in (signs | by_hand).items():
            painted.setdefault(phrase, signs.get(phrase, meaning))
    joining = frozenset().union(*(_phrases(folder, lexicon.get("joining", "")) for lexicon in lexicons.values()))
    for table in named.values():
        for phrase, meaning in table.items():
            # Without its accent, thé is an English article.
            if phrase not in joining:
                painted.setdefault(phrase, meaning)
    return Knowledge(
        folder=folder,
        spoken=spoken,
        painted=painted,
        common={language: _phrases(folder, lexicon.get("common", "")) for language, lexicon in lexicons.items()},
        warning_starts=frozenset().union(
            *(_phrases(folder, lexicon.get("sign_warning_start", "")) for lexicon in lexicons.values())
        ),
        known=_known_names(folder, lexicons.values(), makers, gazetteer, kinds),
        general=frozenset(kinds["general"]),
        modifiers=frozenset(kinds["modifiers"]),
        instead=kinds["instead"],
        offers=kinds["offers"],
        isa={kind: tuple(parents) for kind, parents in kinds["isa"].items()},
    )


def _read(path: str) -> Any:
    return json.loads((files("lpslam.language") / "data" / path).read_text(encoding="utf-8"))


def _split(joined: str) -> list[str]:
    return [text for text in joined.split("|") if text]


def _phrases(folder: Folder, joined: str) -> frozenset[str]:
    return frozenset(folder.phrase(text) for text in _split(joined))


def _concept_phrases(folder: Folder, means: Mapping[str, str]) -> dict[str, Meaning]:
    """Turn {concept: "phrase|phrase"} into {phrase: meaning}; a phrase under several concepts has them all."""
    gathered: dict[str, dict[str, float]] = {}
    for concept, joined in means.items():
        for text in _split(joined):
            gathered.setdefault(folder.phrase(text), {})[concept] = _BY_HAND
    return {phrase: Meaning("means", tuple(found.items())) for phrase, found in gathered.items()}


def _kind_phrases(
    folder: Folder, by_language: Mapping[str, Mapping[str, str]], kinds: Mapping[str, Any]
) -> dict[str, dict[str, Meaning]]:
    """Names of kinds as phrase tables by language; Chinese of every region is one language."""
    tables: dict[str, dict[str, Meaning]] = {}
    for region, names in by_language.items():
        table = tables.setdefault(region.partition("-")[0], {})
        for kind, joined in names.items():
            concepts = tuple((concept, _BY_NAME) for concept in _with_cuisine(kind, kinds))
            for text in _split(joined):
                phrase = folder.phrase(text)
                # One letter or sign says nothing sure; the shorter kind id is the more general and comes first.
                if len(phrase) > 1:
                    table.setdefault(phrase, Meaning("means", concepts))
    return tables


def _with_cuisine(kind: str, kinds: Mapping[str, Any]) -> list[str]:
    """A kind such as amenity/restaurant/pizza, followed by its cuisine where it has one."""
    top, _, last = kind.rpartition("/")
    if top not in ("amenity/restaurant", "amenity/fast_food", "amenity/cafe"):
        return [kind]
    return [kind, kinds["cuisine_kinds"].get(last, f"cuisine/{last}")]


def _known_names(
    folder: Folder,
    lexicons: Iterable[Mapping[str, Any]],
    makers: Mapping[str, Any],
    gazetteer: Mapping[str, Any],
    kinds: Mapping[str, Any],
) -> dict[str, Known]:
    """Names as painted, by key. By hand goes before the index; a brand of many names goes before its namesake."""
    known: dict[str, Known] = {}

    def add(text: str, source: str, found: tuple[tuple[str, float], ...], identity: str) -> None:
        key = folder.key(text)
        if len(key) > 1:
            known.setdefault(key, Known(text, source, found, identity))

    for lexicon in lexicons:
        for text in _split(lexicon.get("sign_warning", "")):
            add(text, "warning", (("sign/warning", 1.0),), text)
        for kind, joined in lexicon["means"].items():
            # Goods and wants are no names; kinds of place and of facility are what signs are painted with.
            if "/" in kind and not kind.startswith("sign"):
                for text in _split(joined):
                    add(text, "word", ((kind, _BY_HAND),), text)
    for joined, kinds_of in makers["makers"].items():
        names = _split(joined)
        for name in names:
            add(name, "brand", tuple(kinds_of.items()), names[0])
    for joined, kinds_of, cuisines in sorted(gazetteer["brands"], key=lambda row: -row[0].count("|")):
        names = _split(joined)
        found = [*kinds_of, *(kinds["cuisine_kinds"].get(cuisine, f"cuisine/{cuisine}") for cuisine in cuisines)]
        for name in names:
            add(name, "brand", tuple((kind, 1.0) for kind in dict.fromkeys(found)), names[0])
    for by_kind in gazetteer["names"].values():
        for kind, joined in by_kind.items():
            for text in _split(joined):
                add(text, "word", tuple((each, _BY_NAME) for each in _with_cuisine(kind, kinds)), text)
    return known


@lru_cache(maxsize=1)
def load_words() -> frozenset[str]:
    """Common words of European languages, as `Folder.key` gives them (about 20 ms, once a process)."""
    packed = (files("lpslam.language") / "data" / "words.txt.xz").read_bytes()
    return frozenset(lzma.decompress(packed).decode().split("\n"))
