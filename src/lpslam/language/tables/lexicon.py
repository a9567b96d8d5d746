"""The lexicon: what phrases mean in a question, by language, as written by hand and as the gazetteer has it."""

import json
import lzma
from collections.abc import Iterable, Mapping, Set
from functools import cache, cached_property
from importlib.resources import files
from typing import Any, NamedTuple

from lpslam.language.kept import building, kept
from lpslam.language.languages import LANGUAGES, LATIN
from lpslam.language.tables.concepts import load_buildings
from lpslam.language.tables.states import StateTables
from lpslam.language.tables.words import Folder, PhraseTable

TOPICS = ("food", "goods", "services", "facilities", "trades")
SAID_ONLY = ("needs",)  # topics of which nothing is painted on a sign
_ROLES = (
    *("context_before", "context_after", "past", "refuse_before", "refuse_after", "refuse_back", "neutral"),
    "break",
)
_PARTITIVES = "du|de la|des|de l|le|la|les|el|los|las|der|die|das|some|any"
_SHORTEST_BEGINNING = 4  # letters of a part that may be the beginning of a longer word
# How sure a word makes us of a kind: written for this by hand, a kind's own name in the index, or a search term.
BY_HAND, BY_NAME, BY_TERM = 1.0, 0.95, 0.8
Packed = tuple[list[tuple[Any, ...]], dict[str, int]]
"""What phrases mean, of plain values: each meaning once, and which is whose."""


class Meaning(NamedTuple):
    """What a phrase says: a role in the sentence ("means" or a refusal) and, for "means", concepts by weight."""

    role: str
    concepts: tuple[tuple[str, float], ...] = ()


def read_table(path: str) -> Any:
    """Read a JSON file of `data/`."""
    return json.loads((files("lpslam.language") / "data" / path).read_text(encoding="utf-8"))


def load_lexicons() -> dict[str, dict[str, Any]]:
    """The lexicon of each language, with what topics and buildings say in it.

    Concepts of buildings stand beside what a word means else: `venues` on signs, `said_in_venues` in questions only.
    """
    lexicons: dict[str, dict[str, Any]] = {language: read_table(f"lexicon/{language}.json") for language in LANGUAGES}
    sections = {"needs": "said"}
    for topic in (*TOPICS, *SAID_ONLY):
        for concept, by_language in read_table(f"lexicon/topics/{topic}.json").items():
            for language, joined in by_language.items():
                means = lexicons[language].setdefault(sections.get(topic, "means"), {})
                means[concept] = f"{means[concept]}|{joined}" if concept in means else joined
    for entry in load_buildings().concepts:
        for section, said in (("venues", entry.signs), ("said_in_venues", entry.asked)):
            for language, joined in said.items():
                means = lexicons[language].setdefault(section, {})
                means[entry.name] = f"{means[entry.name]}|{joined}" if entry.name in means else joined
    return lexicons


def load_gazetteer() -> dict[str, Any]:
    """Names of kinds of place and brands, from openly licensed indexes."""
    packed_file = files("lpslam.language") / "data" / "gazetteer.json.xz"
    gazetteer: dict[str, Any] = json.loads(lzma.decompress(packed_file.read_bytes()))
    return gazetteer


def packed(table: Mapping[str, Meaning]) -> Packed:
    """Return a table of plain values."""
    said = {meaning: at for at, meaning in enumerate(dict.fromkeys(table.values()))}
    return [tuple(each) for each in said], {phrase: said[meaning] for phrase, meaning in table.items()}


def unpacked(given: Packed) -> dict[str, Meaning]:
    """Return the table of which `packed` made plain values."""
    said = [Meaning(*each) for each in given[0]]
    return {phrase: said[at] for phrase, at in given[1].items()}


def split(joined: str) -> list[str]:
    """Return the phrases that a table joins with bars."""
    return [text for text in joined.split("|") if text]


def phrases_of(folder: Folder, joined: str) -> frozenset[str]:
    """Return the keys of joined phrases."""
    return frozenset(folder.phrase(text) for text in split(joined))


def with_cuisine(kind: str, cuisine_kinds: Mapping[str, str]) -> list[str]:
    """A kind such as amenity/restaurant/pizza, followed by its cuisine where it has one."""
    top, _, last = kind.rpartition("/")
    if top not in ("amenity/restaurant", "amenity/fast_food", "amenity/cafe"):
        return [kind]
    return [kind, cuisine_kinds.get(last, f"cuisine/{last}")]


class SpokenTables:
    """What phrases mean in a question, by language: what is written by hand goes before names, things and terms."""

    def __init__(self, folder: Folder) -> None:
        self._folder = folder
        # Each is built when it is first asked for.
        self._both, self._borrowed = cache(self._every_and_plain), cache(self._of_english)
        self.turns_of, self.states_of = cache(self._turns), cache(self._states)

    @cached_property
    def _lexicons(self) -> Mapping[str, Mapping[str, Any]]:
        return load_lexicons()

    @cached_property
    def _gazetteer(self) -> Mapping[str, Any]:
        return load_gazetteer()

    @cached_property
    def _kinds(self) -> Mapping[str, Any]:
        kinds: Mapping[str, Any] = read_table("lexicon/kinds.json")
        return kinds

    def of(self, language: str) -> PhraseTable[Meaning]:
        """Return what a language's phrases mean, by `Folder.phrase`."""
        return self._both(language)[0]

    def _every_and_plain(self, language: str) -> tuple[PhraseTable[Meaning], PhraseTable[Meaning]]:
        with building():
            every, plain = kept(f"spoken-{language}", b"", lambda: tuple(map(packed, self._build(language))))
            return PhraseTable(unpacked(every)), PhraseTable(unpacked(plain))

    def plain(self, language: str) -> PhraseTable[Meaning]:
        """Return `of` without the turns of phrase of other buildings than malls, which hide the words in them."""
        return self._both(language)[1]

    def _turns(self, language: str) -> frozenset[str]:
        """The phrases that mean something else in `of` than in `plain`."""
        every, plain = self._both(language)
        return frozenset(key for key, said in every.items() if plain.get(key) != said)

    def with_english(self, language: str) -> tuple[PhraseTable[Meaning], ...]:
        """Return a language's table, and the English words that it borrows."""
        return (self.of(language),) if language == "en" else (self.of(language), self._borrowed(language))

    def _of_english(self, language: str) -> PhraseTable[Meaning]:
        # German “hat” is no hat, Spanish “suspender” no braces: a language's own words are not borrowed.
        own = self._common(language) | phrases_of(self._folder, self._lexicons[language].get("own_words", ""))
        return PhraseTable((key, said) for key, said in self.of("en").items() if key not in own)

    def _states(self, language: str) -> StateTables:
        """The things and states of a language."""
        tree = read_table("lexicon/states.json")
        return StateTables(
            self._names(tree["things"], language),
            self._names(tree["states"], language),
            PhraseTable((phrase, ()) for phrase in phrases_of(self._folder, tree["at_home"][language])),
            {(pair.split("+")[0], pair.split("+")[1]): want for pair, want in tree["together"].items()},
            kept(f"apart-{language}", b"", lambda: self._apart(language)),
        )

    def _apart(self, language: str) -> list[tuple[tuple[str, ...], str]]:
        return [
            (tuple(self._part(part, language) for part in parts), entry.name)
            for entry in load_buildings().concepts
            for parts in entry.apart.get(language, ())
        ]

    def _part(self, part: str, language: str) -> str:
        """The beginning of a word as the units of a question are joined; a short one is a whole word."""
        part = " ".join(self._folder.units(part)) if "'" in part else self._folder.fold(part).replace("-", " ")
        if language not in LATIN:
            return part.replace(" ", "")
        return f" {part}" if len(part) >= _SHORTEST_BEGINNING else f" {part} "

    def word_for(self, concept: str, language: str) -> str | None:
        """Return how a language calls a concept; "zh-Hant" is traditional Chinese."""
        spoken, _, script = language.partition("-")
        for region, names in self._gazetteer["names"].items():
            if region == language or (not script and region.partition("-")[0] == spoken):
                for row in names.get(concept, ()):
                    return str(row[0])
        words = split(self._lexicons[spoken]["means"].get(concept, "")) if spoken in self._lexicons else []
        if not words:
            return None
        return self._folder.traditional(words[0]) if script == "Hant" else words[0]

    def _names(self, by_name: Mapping[str, Mapping[str, str]], language: str) -> PhraseTable[tuple[str, ...]]:
        found: dict[str, list[str]] = {}
        for name, by_language in by_name.items():
            for text in split(by_language[language]):
                found.setdefault(self._folder.phrase(text), []).append(name)
        return PhraseTable((phrase, tuple(names)) for phrase, names in found.items())

    def _build(self, language: str) -> tuple[dict[str, Meaning], dict[str, Meaning]]:
        """What phrases mean, and what they mean plainly."""
        lexicon = self._lexicons[language]
        phrase = self._folder.phrase
        common = self._common(language)
        articles = phrases_of(self._folder, lexicon.get("article", "")) | phrases_of(self._folder, _PARTITIVES)
        table: dict[str, Meaning] = {}
        for role in _ROLES:
            for text in split(lexicon.get(role, "")):
                key = phrase(text)
                both = role == "refuse_after" and table.get(key) == Meaning("refuse_before")
                table[key] = Meaning("refuse_either" if both else role)
        by_hand: dict[str, dict[str, float]] = {}
        unspoken = frozenset(self._kinds["unspoken"])
        for concept, joined in (*lexicon["means"].items(), *lexicon["said"].items()):
            for text in dict.fromkeys(split(joined)) if concept not in unspoken else ():
                key = phrase(text)
                # Without its accent, uña is a Spanish article.
                if key not in common or key == text.casefold():
                    by_hand.setdefault(key, {})[concept] = BY_HAND
        for key, found in by_hand.items():
            table.setdefault(key, Meaning("means", tuple(_named_itself(found).items())))
        # Chinese of every region is one language.
        regions = [region for region in self._gazetteer["names"] if region.partition("-")[0] == language]
        for region in regions:
            for kind, rows in self._gazetteer["names"][region].items():
                self._add(table, kind, BY_NAME, (row[1] for row in rows if row[1] not in common))
        named = {phrase(text) for joined in lexicon["venues"].values() for text in split(joined)}
        for source, sure in (("things", BY_NAME), ("terms", BY_TERM)):
            # What names a kind of room goes before the key words of a picture of it: 🛂 is called customs as well.
            known = common | (named if source == "things" else frozenset())
            for region, by_concept in self._gazetteer[source].items():
                if region.partition("-")[0] == language:
                    for concept, joined in by_concept.items():
                        self._add(table, concept, sure, (each for each in joined.split("|") if each not in known))
        plain = dict[str, Meaning]()
        for section in ("venues", "said_in_venues"):
            if section == "said_in_venues":
                plain = dict(table)
            for concept, joined in lexicon[section].items():
                said = [phrase(text) for text in split(joined)]
                # “Du beurre” stands in the tables as it is.
                said += [key for each in said for article in articles if (key := f"{article} {each}") in table]
                add_beside(table, concept, said, common)
        return table, plain

    def _common(self, language: str) -> frozenset[str]:
        return phrases_of(self._folder, self._lexicons[language].get("common", ""))

    def _add(self, table: dict[str, Meaning], kind: str, sure: float, phrases: Iterable[str]) -> None:
        meaning = Meaning("means", tuple((each, sure) for each in with_cuisine(kind, self._kinds["cuisine_kinds"])))
        for phrase in phrases:
            if len(phrase) > 1:
                table.setdefault(phrase, meaning)


def add_beside(table: dict[str, Meaning], concept: str, phrases: Iterable[str], hidden: Set[str]) -> None:
    """Add a concept to what phrases mean already; what refuses, warns or is said everywhere stays what it is."""
    for key in phrases:
        said = table.get(key)
        if not key or key in hidden or (said is not None and said.role != "means"):
            continue
        concepts = said.concepts if said is not None else ()
        if all(concept != other for other, _ in concepts):
            table[key] = Meaning("means", (*concepts, (concept, BY_HAND if not concepts else BY_NAME)))


def _named_itself(found: Mapping[str, float]) -> Mapping[str, float]:
    """Who asks for a dentist by that word wants no pharmacy: the kind of place goes before the want."""
    kinds = {
        concept: sure
        for concept, sure in found.items()
        if "/" in concept and not concept.startswith(("shop/", "cuisine/"))
    }
    return kinds or found
