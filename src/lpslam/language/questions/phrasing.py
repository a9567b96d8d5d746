"""How an answer is said in the language of its question: one table of templates a language (`data/answers.json`)."""

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

from lpslam.language.questions.question import language_of
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.tables.lexicon import read_table

_ENGLISH, _TRADITIONAL = "en", "zh-Hant"


class Phrases:
    """The templates of one language; `language` is its tag, "zh-Hant" being traditional Chinese."""

    def __init__(self, language: str, templates: Mapping[str, Any]) -> None:
        self.language = language
        self._templates = templates

    def say(self, what: str, **parts: object) -> str:
        """Fill a template; what was read in the world stays what it is, whatever braces it holds."""
        return str(self._templates[what]).format_map({name: str(part) for name, part in parts.items()})

    def reason(self, english: str) -> str:
        """Say a reason that has no parts in this language; as it is where it is none of the table's."""
        return _reasons().get(self.language, {}).get(english, english)

    def direction(self, degrees: float) -> str:
        """Say where something is, counter-clockwise from straight ahead."""
        directions: Sequence[str] = self._templates["directions"]
        return directions[round(degrees / (360.0 / len(directions))) % len(directions)]

    def things(self, concepts: Sequence[str]) -> str:
        """Name kinds of place and what they offer; English as the tables write them."""
        if self.language == _ENGLISH:
            return ", ".join(concepts)
        knowledge, nouns = load_knowledge(), self._templates["words"]
        said = [nouns.get(each) or knowledge.word_for(each, self.language) for each in concepts]
        return self.join([word for word in dict.fromkeys(said) if word] or concepts)

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
def _reasons() -> Mapping[str, Mapping[str, str]]:
    tables: Mapping[str, Mapping[str, str]] = read_table("reasons.json")
    return tables
