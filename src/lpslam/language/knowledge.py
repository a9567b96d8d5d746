"""What the embedded model knows, read from the tables in `data/`: kinds of place, brands, words, wants, warnings.

The gazetteer comes from openly licensed indexes (`tools/build_gazetteer.py`); the lexicon is written by hand: topics
in all languages side by side, and one file a language for how it refuses, warns and turns a sentence. A further
language or topic is a further file, not further code.
"""

import json
import lzma
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

from lpslam.language.states import StateTables
from lpslam.language.words import Folder

HAND_WRITTEN = ("en", "zh", "ja", "ko", "es", "de", "fr")
TOPICS = ("food", "goods", "services", "facilities", "trades")
SAID_ONLY = ("needs",)  # topics of which nothing is painted on a sign
_ROLES = (
    *("context_before", "context_after", "past", "refuse_before", "refuse_after", "refuse_back", "neutral"),
    "break",
)
_SIGN_ROLES = {"sign_warning": "sign/warning", "sign_slogan": "sign/slogan"}

# How sure a word makes us of a kind: written for this by hand, a kind's own name in the index, or a search term.
_BY_HAND, _BY_NAME, _BY_TERM = 1.0, 0.95, 0.8

_SUBSTITUTE = 0.8
_TRADE_FIRST = ("de", "es", "fr")
_SURE_SLOGAN = 4  # words or characters of a slogan that no shop's name comes near to by chance


class Meaning(NamedTuple):
    """What a phrase says: a role in the sentence ("means" or a refusal) and, for "means", concepts by weight."""

    role: str
    concepts: tuple[tuple[str, float], ...] = ()


class Known(NamedTuple):
    """A name known as it is painted: a brand, a maker, a warning or a word for a kind of place."""

    painted: str
    source: str
    kinds: tuple[tuple[str, float], ...]
    identity: str


@dataclass(frozen=True, eq=False)
class Knowledge:
    """All tables, ready to look up. Phrase tables are keyed by `Folder.phrase`, `known` by `Folder.key`."""

    folder: Folder
    painted: Mapping[str, Meaning]
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
    known: Mapping[str, Known]
    general: frozenset[str]
    modifiers: frozenset[str]
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
    _tables: "_SpokenTables"
    _above: dict[str, tuple[str, ...]] = field(default_factory=dict)
    _shares: dict[tuple[str, str], float] = field(default_factory=dict)

    def spoken(self, language: str) -> Mapping[str, Meaning]:
        """Return what the phrases of a language mean in a question; built when it is first asked for."""
        return self._tables.of(language)

    def tables_of(self, language: str) -> tuple[Mapping[str, Meaning], ...]:
        """Return the tables in which a question is looked up: the language's, and English words that it borrows."""
        return self._tables.with_english(language)

    def states(self, language: str) -> StateTables:
        """Return the things and states of a language."""
        return self._tables.states_of(language)

    def word_for(self, concept: str, language: str) -> str | None:
        """Return how a language calls a concept; None where no table says so. "zh-Hant" is traditional Chinese."""
        return self._tables.word_for(concept, language)

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
            tables += [(_SUBSTITUTE, table) for table in self._goods_of.get(concept, ())]
        shares = [
            trust * next((table[above] for above in self.above(kind) if above in table), 0.0) for trust, table in tables
        ]
        return max(shares, default=0.0)

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
    """Read the tables of the package (about 0.25 s, once a process)."""
    kinds = _read("lexicon/kinds.json")
    han = _read("lexicon/han.json")
    folder = Folder(han["traditional"], han["simplified"], han["lookalikes"], han["both"])
    lexicons = _lexicons()
    gazetteer = json.loads(lzma.decompress((files("lpslam.language") / "data" / "gazetteer.json.xz").read_bytes()))
    unpainted = frozenset(kinds["unpainted"])
    painted: dict[str, Meaning] = {}
    known: dict[str, Known] = {}
    for lexicon in lexicons.values():
        _add_painted(lexicon, folder, unpainted, painted, known)
    for joined, kinds_of in _read("lexicon/makers.json")["makers"].items():
        names = joined.split("|")
        for name in names:
            known.setdefault(folder.key(name), Known(name, "brand", tuple(kinds_of.items()), names[0]))
    _add_brands(gazetteer["brands"], kinds["cuisine_kinds"], known)
    for painted_name, joined in _read("lexicon/nicknames.json").items():
        called = known.get(folder.key(painted_name))
        if called is not None:
            for name in _split(joined):
                known.setdefault(folder.key(name), Known(name, "brand", called.kinds, called.identity))
    joining = _in_any(lexicons, "joining", folder)
    _add_kinds(gazetteer["names"], kinds["cuisine_kinds"], joining, painted, known)
    return Knowledge(
        folder=folder,
        painted=painted,
        common={language: _phrases(folder, lexicon.get("common", "")) for language, lexicon in lexicons.items()},
        articles=_in_any(lexicons, "article", folder),
        joining=joining,
        leading=_leading(lexicons, folder),
        turning=_in_any(lexicons, "turning", folder),
        asking=_in_any(lexicons, "asking", folder),
        both=_in_any(lexicons, "both", folder),
        wishing={language: _phrases(folder, lexicon["wishing"]) for language, lexicon in lexicons.items()},
        negating={language: _phrases(folder, lexicon["negating"]) for language, lexicon in lexicons.items()},
        warning_starts=_in_any(lexicons, "sign_warning_start", folder),
        known=known,
        general=frozenset(kinds["general"]),
        modifiers=frozenset(kinds["modifiers"]),
        auxiliary=frozenset(kinds["auxiliary"]),
        treatments=frozenset(kinds["treatments"]),
        instead=kinds["instead"],
        instead_of=kinds["instead_of"],
        offers=kinds["offers"],
        isa={kind: tuple(parents) for kind, parents in kinds["isa"].items()},
        contained={thing: frozenset(_split(joined)) for thing, joined in kinds["contained"].items()},
        apart={kind: frozenset(_split(joined)) for kind, joined in kinds["apart"].items()},
        light_food=frozenset(kinds["light_food"]),
        refusing=kinds["refusing"],
        said_of_food=frozenset(kinds["said_of_food"]),
        symptoms=frozenset(kinds["symptoms"]),
        weather=frozenset(kinds["weather"]),
        venues=frozenset(kinds["venues"]),
        trade_goods=frozenset(kinds["trade_goods"]),
        imperatives=frozenset(kinds["imperatives"]),
        company_forms=frozenset(kinds["company_forms"]),
        _tables=_SpokenTables(folder, lexicons, gazetteer, kinds["cuisine_kinds"], frozenset(kinds["unspoken"])),
    )


def _read(path: str) -> Any:
    return json.loads((files("lpslam.language") / "data" / path).read_text(encoding="utf-8"))


def _lexicons() -> dict[str, dict[str, Any]]:
    """The lexicon of each language, with what the topics say in it."""
    lexicons: dict[str, dict[str, Any]] = {language: _read(f"lexicon/{language}.json") for language in HAND_WRITTEN}
    for topic in (*TOPICS, *SAID_ONLY):
        for concept, by_language in _read(f"lexicon/topics/{topic}.json").items():
            for language, joined in by_language.items():
                means = lexicons[language].setdefault("said" if topic in SAID_ONLY else "means", {})
                means[concept] = f"{means[concept]}|{joined}" if concept in means else joined
    return lexicons


def _split(joined: str) -> list[str]:
    return [text for text in joined.split("|") if text]


def _phrases(folder: Folder, joined: str) -> frozenset[str]:
    return frozenset(folder.phrase(text) for text in _split(joined))


def _in_any(lexicons: Mapping[str, Mapping[str, Any]], role: str, folder: Folder) -> frozenset[str]:
    """The phrases that have a role in any language."""
    return frozenset().union(*(_phrases(folder, lexicon.get(role, "")) for lexicon in lexicons.values()))


def _leading(lexicons: Mapping[str, Mapping[str, Any]], folder: Folder) -> frozenset[str]:
    """The words of languages that name the trade first and the owner after it: Boulangerie Petit Jean."""
    said = {
        language: {folder.phrase(text) for joined in lexicons[language]["means"].values() for text in _split(joined)}
        for language in ("en", *_TRADE_FIRST)
    }
    return frozenset(set().union(*(said[language] for language in _TRADE_FIRST)) - said["en"])


def _add_painted(
    lexicon: Mapping[str, Any],
    folder: Folder,
    unpainted: frozenset[str],
    painted: dict[str, Meaning],
    known: dict[str, Known],
) -> None:
    """Add what one language's signs are painted with; a warning or slogan goes before a place."""
    gathered: dict[str, dict[str, float]] = {}
    for role, kind in _SIGN_ROLES.items():
        for text in _split(lexicon.get(role, "")):
            painted.setdefault(folder.phrase(text), Meaning("sign", ((kind, 1.0),)))
            if kind == "sign/warning" or len(folder.phrase(text).split()) >= _SURE_SLOGAN:
                known.setdefault(folder.key(text), Known(text, "warning", ((kind, 1.0),), text))
    for concept, joined in lexicon["means"].items():
        if concept in unpainted:
            continue
        # Goods and wants are no names; kinds of place and of facility are what signs are painted with.
        is_name = "/" in concept and not concept.startswith("sign")
        word = ((concept, _BY_HAND),)
        for text in dict.fromkeys(_split(joined)):
            phrase, key = folder.phrase_and_key(text)
            gathered.setdefault(phrase, {})[concept] = _BY_HAND
            if is_name and len(key) > 1:
                known.setdefault(key, Known(text, "word", word, text))
    for phrase, found in gathered.items():
        painted.setdefault(phrase, Meaning("means", tuple(found.items())))


def _add_brands(rows: Iterable[Any], cuisine_kinds: Mapping[str, str], known: dict[str, Known]) -> None:
    """Add brands, as the index lists them: those of many names before their namesakes."""
    for joined, keys, kinds_of, cuisines in rows:
        names = joined.split("|")
        found = dict.fromkeys([*kinds_of, *(cuisine_kinds.get(each, f"cuisine/{each}") for each in cuisines)], 1.0)
        weighed = tuple(found.items())
        for name, key in zip(names, keys.split("|"), strict=True):
            if len(key) > 1 and key not in known:
                known[key] = Known(name, "brand", weighed, names[0])


def _add_kinds(
    by_language: Mapping[str, Mapping[str, Any]],
    cuisine_kinds: Mapping[str, str],
    joining: frozenset[str],
    painted: dict[str, Meaning],
    known: dict[str, Known],
) -> None:
    """Add the names of kinds of place in every language; the shorter kind id is the more general and comes first."""
    for names in by_language.values():
        for kind, rows in names.items():
            concepts = tuple((concept, _BY_NAME) for concept in _with_cuisine(kind, cuisine_kinds))
            meaning = Meaning("means", concepts)
            for text, phrase, key in rows:
                # Without its accent, thé is an English article; one letter or sign says nothing sure.
                if len(phrase) > 1 and phrase not in joining:
                    painted.setdefault(phrase, meaning)
                if len(key) > 1 and key not in known:
                    known[key] = Known(text, "word", concepts, text)


def _with_cuisine(kind: str, cuisine_kinds: Mapping[str, str]) -> list[str]:
    """A kind such as amenity/restaurant/pizza, followed by its cuisine where it has one."""
    top, _, last = kind.rpartition("/")
    if top not in ("amenity/restaurant", "amenity/fast_food", "amenity/cafe"):
        return [kind]
    return [kind, cuisine_kinds.get(last, f"cuisine/{last}")]


class _SpokenTables:
    """What phrases mean in a question, by language: what is written by hand goes before names, things and terms."""

    def __init__(
        self,
        folder: Folder,
        lexicons: Mapping[str, Mapping[str, Any]],
        gazetteer: Mapping[str, Any],
        cuisine_kinds: Mapping[str, str],
        unspoken: frozenset[str],
    ) -> None:
        self._unspoken = unspoken
        self._folder = folder
        self._lexicons = lexicons
        self._gazetteer = gazetteer
        self._cuisine_kinds = cuisine_kinds
        self._built: dict[str, dict[str, Meaning]] = {}
        self._borrowed: dict[str, dict[str, Meaning]] = {}
        self._states: dict[str, StateTables] = {}

    def of(self, language: str) -> dict[str, Meaning]:
        if language not in self._built:
            self._built[language] = self._build(language)
        return self._built[language]

    def with_english(self, language: str) -> tuple[dict[str, Meaning], ...]:
        if language == "en":
            return (self.of("en"),)
        if language not in self._borrowed:
            # German “hat” is no hat: what the language's own small words are is not borrowed.
            own = self._common(language)
            self._borrowed[language] = {key: said for key, said in self.of("en").items() if key not in own}
        return self.of(language), self._borrowed[language]

    def states_of(self, language: str) -> StateTables:
        if language not in self._states:
            tree = _read("lexicon/states.json")
            self._states[language] = StateTables(
                self._names(tree["things"], language),
                self._names(tree["states"], language),
                _phrases(self._folder, tree["at_home"][language]),
                {(pair.split("+")[0], pair.split("+")[1]): want for pair, want in tree["together"].items()},
            )
        return self._states[language]

    def word_for(self, concept: str, language: str) -> str | None:
        spoken, _, script = language.partition("-")
        for region, names in self._gazetteer["names"].items():
            if region == language or (not script and region.partition("-")[0] == spoken):
                for row in names.get(concept, ()):
                    return str(row[0])
        words = _split(self._lexicons[spoken]["means"].get(concept, "")) if spoken in self._lexicons else []
        if not words:
            return None
        return self._folder.traditional(words[0]) if script == "Hant" else words[0]

    def _names(self, by_name: Mapping[str, Mapping[str, str]], language: str) -> dict[str, tuple[str, ...]]:
        found: dict[str, list[str]] = {}
        for name, by_language in by_name.items():
            for text in _split(by_language[language]):
                found.setdefault(self._folder.phrase(text), []).append(name)
        return {phrase: tuple(names) for phrase, names in found.items()}

    def _build(self, language: str) -> dict[str, Meaning]:
        lexicon = self._lexicons[language]
        phrase = self._folder.phrase
        common = self._common(language)
        table: dict[str, Meaning] = {}
        for role in _ROLES:
            for text in _split(lexicon.get(role, "")):
                key = phrase(text)
                both = role == "refuse_after" and table.get(key) == Meaning("refuse_before")
                table[key] = Meaning("refuse_either" if both else role)
        by_hand: dict[str, dict[str, float]] = {}
        for concept, joined in (*lexicon["means"].items(), *lexicon["said"].items()):
            for text in dict.fromkeys(_split(joined)) if concept not in self._unspoken else ():
                key = phrase(text)
                # Without its accent, uña is a Spanish article.
                if key not in common or key == text.casefold():
                    by_hand.setdefault(key, {})[concept] = _BY_HAND
        for key, found in by_hand.items():
            table.setdefault(key, Meaning("means", tuple(_named_itself(found).items())))
        # Chinese of every region is one language.
        regions = [region for region in self._gazetteer["names"] if region.partition("-")[0] == language]
        for region in regions:
            for kind, rows in self._gazetteer["names"][region].items():
                self._add(table, kind, _BY_NAME, (row[1] for row in rows if row[1] not in common))
        for source, sure in (("things", _BY_NAME), ("terms", _BY_TERM)):
            for region, by_concept in self._gazetteer[source].items():
                if region.partition("-")[0] == language:
                    for concept, joined in by_concept.items():
                        self._add(table, concept, sure, (each for each in joined.split("|") if each not in common))
        return table

    def _common(self, language: str) -> frozenset[str]:
        return _phrases(self._folder, self._lexicons[language].get("common", ""))

    def _add(self, table: dict[str, Meaning], kind: str, sure: float, phrases: Iterable[str]) -> None:
        meaning = Meaning("means", tuple((each, sure) for each in _with_cuisine(kind, self._cuisine_kinds)))
        for phrase in phrases:
            if len(phrase) > 1:
                table.setdefault(phrase, meaning)


def _named_itself(found: Mapping[str, float]) -> Mapping[str, float]:
    """Who asks for a dentist by that word wants no pharmacy: the kind of place goes before the want."""
    kinds = {
        concept: sure
        for concept, sure in found.items()
        if "/" in concept and not concept.startswith(("shop/", "cuisine/"))
    }
    return kinds or found


@lru_cache(maxsize=1)
def load_words() -> frozenset[str]:
    """Common words of European languages, as `Folder.key` gives them (about 20 ms, once a process)."""
    packed = (files("lpslam.language") / "data" / "words.txt.xz").read_bytes()
    return frozenset(lzma.decompress(packed).decode().split("\n"))
