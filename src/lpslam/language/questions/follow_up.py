"""Questions that only mean something after another one: “and another one?”, 还有别的吗, “but not pizza”."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from lpslam.language.questions.phrasing import answer_language
from lpslam.language.questions.question import read_question
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge, load_knowledge
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import PhraseTable, is_mark, longest_phrases

_MORE, _FILLER = "more", "filler"
_LONGEST = 80  # letters; whoever says more says what


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
        return FollowUp(before, True, _in_script(language, own.language))
    wish = read_question(text, knowledge)
    has_own = wish.wanted or wish.wanted_names
    if not has_own and (wish.refused or wish.refused_names):
        return FollowUp(f"{before.rstrip(' ?？.。!！')}. {text}", False, own.language)
    return own


def _language_of_more(text: str, knowledge: Knowledge) -> str | None:
    """The language in which a text asks for another one and says nothing else; None where it does not."""
    units = [unit for unit in knowledge.folder.units(clean_text(text)) if not is_mark(unit)]
    for language, table in _tables().items():
        spans = longest_phrases(units, (table,))
        is_all = bool(units) and sum(span.end - span.start for span in spans) == len(units)
        if is_all and any(span.value == _MORE for span in spans):
            return language
    return None


def _in_script(language: str, detected: str) -> str:
    return detected if detected.partition("-")[0] == language else language


@lru_cache(maxsize=1)
def _tables() -> Mapping[str, PhraseTable[str]]:
    tree = read_table("follow_ups.json")
    phrase = load_knowledge().folder.phrase
    return {
        language: PhraseTable((phrase(text), role) for role in (_FILLER, _MORE) for text in roles[role].split("|"))
        for language, roles in tree.items()
    }
