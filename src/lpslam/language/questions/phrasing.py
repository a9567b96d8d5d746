"""How an answer is said in the language of its question, and questions that only mean something after another one."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from lpslam.language.questions.question import language_of, read_question
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge, load_knowledge
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import PhraseTable, is_mark, longest_phrases

_ENGLISH, _TRADITIONAL = "en", "zh-Hant"
_PARTED = "; "
_MORE, _FILLER = "more", "filler"
_LONGEST = 80  # letters; whoever says more says what


class Phrases:
    """The templates of one language; `language` is its tag, "zh-Hant" being traditional Chinese."""

    def __init__(self, language: str, templates: Mapping[str, Any]) -> None:
        self.language = language
        self._templates = templates

    def say(self, what: str, **parts: object) -> str:
        """Fill a template; what was read in the world stays what it is, whatever braces it holds."""
        return str(self._templates[what]).format_map({name: str(part) for name, part in parts.items()})

    def direction(self, degrees: float) -> str:
        """Say where something is, counter-clockwise from straight ahead."""
        directions: Sequence[str] = self._templates["directions"]
        return directions[round(degrees / (360.0 / len(directions))) % len(directions)]

    def things(self, concepts: Sequence[str]) -> str:
        """Name kinds of place and what they offer."""
        if self.language == _ENGLISH:
            # The tables are written in English: "amenity/toilets".
            return self.join(list(dict.fromkeys(each.rpartition("/")[2].replace("_", " ") for each in concepts)))
        knowledge, nouns = load_knowledge(), self._templates["words"]
        said = [nouns.get(each) or knowledge.word_for(each, self.language) for each in concepts]
        return self.join([word for word in dict.fromkeys(said) if word] or concepts)

    def reasons(self, evidence: str) -> str:
        """Say reasons, parted by "; ", which stand in English (`data/reasons.json`); any other text stays as it is."""
        return evidence if self.language == _ENGLISH else "; ".join(map(self._reason, evidence.split(_PARTED)))

    def _reason(self, reason: str) -> str:
        for pattern, said in _reasons():
            if found := pattern.fullmatch(reason):
                return said[self.language].format_map(found.groupdict())
        return reason

    def join(self, parts: Sequence[str]) -> str:
        """Put the parts of a list together."""
        return str(self._templates["joint"]).join(parts)


@lru_cache(maxsize=256)
def answer_language(question: str, language: str | None = None) -> str:
    """Return the tag of the language to answer in: the question's, English where it cannot be told.

    `language` is the one that the question is in, where that is known.
    """
    text = clean_text(question, 400)
    knowledge = load_knowledge()
    language = language or language_of(text, knowledge) or _ENGLISH
    return _TRADITIONAL if language == "zh" and knowledge.folder.is_traditional(text) else language


@lru_cache(maxsize=16)
def phrases_in(language: str) -> Phrases:
    """Return the templates of a language; English for one that has none."""
    tables = _tables()
    known = language if language in tables else _ENGLISH
    return Phrases(known, tables[known])


@lru_cache(maxsize=1)
def _tables() -> Mapping[str, Mapping[str, Any]]:
    tables: Mapping[str, Mapping[str, Any]] = read_table("answers.json")
    return tables


@lru_cache(maxsize=1)
def _reasons() -> tuple[tuple[re.Pattern[str], Mapping[str, str]], ...]:
    """Patterns of the English reasons, and how each language says them; the first that fits is meant."""
    rows: list[Mapping[str, str]] = read_table("reasons.json")
    return tuple((re.compile(re.sub(r"\\{(\w+)\\}", r"(?P<\1>.+)", re.escape(row[_ENGLISH]))), row) for row in rows)


@dataclass(frozen=True, slots=True)
class FollowUp:
    """What a question takes from the one before it.

    Attributes:
        question: the want, in full.
        keeps: whether what was already named is to be left out.
        language: tag of the language to answer in.
    """

    question: str
    keeps: bool
    language: str


def follow_up(text: str, before: str | None) -> FollowUp:
    """Read `text` after the question `before`; without one it stands for itself."""
    own = FollowUp(text, False, answer_language(text))
    if before is None or len(clean_text(text, 400)) > _LONGEST:
        return own
    knowledge = load_knowledge()
    language = _language_of_more(text, knowledge)
    if language is not None:
        is_same = own.language.partition("-")[0] == language
        return FollowUp(before, True, own.language if is_same else language)
    wish = read_question(text, knowledge)
    has_own = wish.wanted or wish.wanted_names
    if not has_own and (wish.refused or wish.refused_names):
        return FollowUp(f"{before.rstrip(' ?？.。!！')}. {text}", False, own.language)
    return own


def _language_of_more(text: str, knowledge: Knowledge) -> str | None:
    """The language in which a text asks for another one and says nothing else; None where it does not."""
    units = [unit for unit in knowledge.folder.units(clean_text(text)) if not is_mark(unit)]
    for language, table in _asking_more().items():
        spans = longest_phrases(units, (table,))
        is_all = bool(units) and sum(span.end - span.start for span in spans) == len(units)
        if is_all and any(span.value == _MORE for span in spans):
            return language
    return None


@lru_cache(maxsize=1)
def _asking_more() -> Mapping[str, PhraseTable[str]]:
    tree = read_table("follow_ups.json")
    phrase = load_knowledge().folder.phrase
    return {
        language: PhraseTable((phrase(text), role) for role in (_FILLER, _MORE) for text in roles[role].split("|"))
        for language, roles in tree.items()
    }
