"""What a question wants and what it refuses (judging, III-G; choosing, III-I)."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lpslam.language.knowledge import Knowledge, Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.words import Span, is_mark, is_unspaced, longest_phrases

_KANA = re.compile(r"[\u3040-\u30ff]")
_HANGUL = re.compile(r"[\uac00-\ud7af]")
_HAN = re.compile(r"[\u4e00-\u9fff]")
_BREAKING_MARKS = frozenset(",.;:!?，。；：！？、…")
_QUESTION_LENGTH = 400
_MODIFIER, _GENERAL = 0.6, 0.3


@dataclass(frozen=True, slots=True)
class Wish:
    """Concepts wanted and refused, by weight; `language` is None where the question could not be read.

    `wanted_names` and `refused_names` hold the values of the names that were passed in and mentioned.
    """

    wanted: tuple[tuple[str, float], ...]
    refused: tuple[str, ...]
    wanted_names: tuple[str, ...]
    refused_names: tuple[str, ...]
    language: str | None


def language_of(text: str, knowledge: Knowledge) -> str | None:
    """Return the language of a question by its script, or by its commonest words where the script is Latin."""
    if _KANA.search(text):
        return "ja"
    if _HANGUL.search(text):
        return "ko"
    if _HAN.search(text):
        return "zh"
    words = [unit for unit in knowledge.folder.units(text) if not is_mark(unit)]
    hits = {language: sum(word in common for word in words) for language, common in knowledge.common.items() if common}
    best = max(hits, key=lambda language: hits[language])
    if hits[best]:
        return best
    # A word or two carry no grammar that could turn their meaning round; a whole sentence might.
    return "en" if len(words) <= 2 and text.isascii() else None


def read_question(question: str, knowledge: Knowledge, names: Mapping[str, str] | None = None) -> Wish:
    """Read a question; `names` maps phrases (see `Folder.phrase`) to what is reported when they are mentioned."""
    text = clean_text(question, _QUESTION_LENGTH)
    language = language_of(text, knowledge)
    if language is None:
        return Wish((), (), (), (), None)
    mentioned = {phrase: Meaning("name", ((value, 1.0),)) for phrase, value in (names or {}).items()}
    tables = [mentioned, knowledge.spoken[language]]
    if language != "en":
        tables.append(knowledge.spoken["en"])
    units = knowledge.folder.units(text)
    wanted: dict[str, float] = {}
    refused: list[str] = []
    wanted_names: list[str] = []
    refused_names: list[str] = []
    for clause in _clauses(units, longest_phrases(units, tables)):
        for span, is_refused in _told(clause, knowledge):
            for concept, weight in span.value.concepts:
                if span.value.role == "name":
                    (refused_names if is_refused else wanted_names).append(concept)
                elif is_refused:
                    refused.append(concept)
                else:
                    weight *= _importance(concept, knowledge)
                    wanted[concept] = max(weight, wanted.get(concept, 0.0))
    for concept in refused:
        wanted.pop(concept, None)
    return Wish(tuple(wanted.items()), tuple(refused), tuple(wanted_names), tuple(refused_names), language)


def _clauses(units: Sequence[str], spans: Sequence[Span[Meaning]]) -> list[list[Span[Meaning]]]:
    """Group phrases into clauses: a refusal does not reach over a comma or a “but”."""
    clauses: list[list[Span[Meaning]]] = [[]]
    marks = [at for at, unit in enumerate(units) if unit in _BREAKING_MARKS]
    for span in spans:
        while marks and marks[0] < span.start:
            marks.pop(0)
            clauses.append([])
        if span.value.role == "break":
            clauses.append([])
        else:
            clauses[-1].append(span)
    return [clause for clause in clauses if clause]


def _told(clause: Sequence[Span[Meaning]], knowledge: Knowledge) -> list[tuple[Span[Meaning], bool]]:
    """Return each phrase that means something, with whether it is refused.

    A refusal in front reaches forward to the end of the clause, one behind reaches back to the one before it. Beside
    a refused dish, “eat” itself is not refused.
    """
    refused = [False] * len(clause)
    ahead = False
    since = 0
    for at, span in enumerate(clause):
        if span.value.role == "refuse_before" or (span.value.role == "refuse_after" and at == since):
            ahead = True
        elif span.value.role == "refuse_after":
            refused[since:at] = [True] * (at - since)
            since, ahead = at, False
        refused[at] = refused[at] or ahead
    told = [(span, no) for span, no in zip(clause, refused, strict=True) if span.value.role in ("means", "name")]
    if any(no and not _is_general(span, knowledge) for span, no in told):
        told = [(span, no and not _is_general(span, knowledge)) for span, no in told]
    return told


def _is_general(span: Span[Meaning], knowledge: Knowledge) -> bool:
    return span.value.role == "means" and all(concept in knowledge.general for concept, _ in span.value.concepts)


def _importance(concept: str, knowledge: Knowledge) -> float:
    if concept in knowledge.general:
        return _GENERAL
    return _MODIFIER if concept in knowledge.modifiers else 1.0


def instead_of(refused: Sequence[str], knowledge: Knowledge) -> tuple[tuple[str, float], ...]:
    """What someone wants who only says what not: something else of the same use."""
    wanted: dict[str, float] = {}
    for concept in refused:
        for above in knowledge.above(concept):
            if above in knowledge.instead:
                wanted[knowledge.instead[above]] = _GENERAL
    return tuple((concept, weight) for concept, weight in wanted.items() if concept not in refused)


def spoken_key(text: str) -> bool:
    """Whether a name may be looked for inside a question: short or unspaced one-letter names would match anywhere."""
    return len(text) >= (2 if is_unspaced(text) else 3)
