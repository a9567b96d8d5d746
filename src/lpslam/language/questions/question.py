"""What a question wants and what it refuses (judging, III-G; choosing, III-I).

A question is cut into units, phrases that mean something are found in them, and the words between them tell what is
refused, what is only said by the way ("on the train", 看电影前) and where one thought ends.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

from lpslam.language.languages import LATIN
from lpslam.language.questions.speaking import languages_of
from lpslam.language.questions.stance import NEXT_TO, Clause, Stand, Told, clauses_of, spilled, told_in
from lpslam.language.questions.wanted import (
    ASIDE,
    GENERAL,
    GIFTS,
    HINT,
    MAIN,
    MODIFIER,
    THING,
    Wish,
    as_treated,
    is_general,
    without_symptoms,
)
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.inflection import known_form
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning, read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.states import Trouble, says_at_home, together_in, troubles_in
from lpslam.language.tables.words import Phrases, PhraseTable, Span, is_unspaced, longest_phrases

_HYPHEN = standing(r"(?<=[^\W\d_])[-\u2010\u2011](?=\w)|(?<=\w)[-\u2010\u2011](?=[^\W\d_])")
# The mark in “T. rex” ends no clause.
_ABBREVIATED = standing(r"\b([^\W\d_])\. (?=\w)")
# “Fischallergie” refuses fish.
_ALLERGY = standing(r"(\w{3,}?)s?(allergien?|unverträglichkeit|intoleranz)\b", re.IGNORECASE)
# Without its accent, as words are looked up, té is a Spanish pronoun.
_SPANISH_TEA = standing(r"\bté\b", re.IGNORECASE)
_ANOTHER = standing(read_table("patterns.json")["another"], re.IGNORECASE)
"""Words that ask for something beside what is named."""
_QUESTION_LENGTH = 400
_KEPT = 64  # readings that are kept: those of one question and its parts, and of a few that are asked at one time
_FEW_WORDS = 2  # words of a question that may be in any language
_MEALS = frozenset({"food", "drink"})
NO_NAMES: PhraseTable[Meaning] = PhraseTable()
"""Of who knows none."""


def language_of(text: str, knowledge: Knowledge) -> str | None:
    """Return the likeliest language of a question; None where it cannot be told."""
    likely = _likely(text, knowledge)
    # Of several it is the one in which the question says something.
    return read_question(text, knowledge).language if len(likely) > 1 else next(iter(likely), None)


def read_question(
    question: str,
    knowledge: Knowledge,
    names: Phrases[Meaning] = NO_NAMES,
    is_plain: bool = False,
    language: str | None = None,
) -> Wish:
    """Read a question; `names` maps phrases (see `Folder.phrase`) to names that are reported when mentioned.

    It is read in the likeliest language in which it says something; plainly, without the turns of phrase that are
    used in other buildings than malls; `language` is the one that it is in, where that is known.
    """
    if language is None:
        likely = _likely(question, knowledge)
        language = likely[0] if len(likely) == 1 else None
    if names is NO_NAMES:
        return _without_names(question, knowledge, is_plain, language)
    return _read(question, knowledge, is_plain, language, names)


def read_part(text: str, language: str | None, knowledge: Knowledge, names: Phrases[Meaning] = NO_NAMES) -> Wish:
    """Read a part of a question in the language of the whole; in any where it says nothing in that."""
    wish = read_question(text, knowledge, names, language=language)
    says = wish.wanted or wish.refused or wish.wanted_names or wish.refused_names
    return wish if says or language is None else read_question(text, knowledge, names)


@lru_cache(maxsize=_KEPT)
def _without_names(question: str, knowledge: Knowledge, is_plain: bool, language: str | None) -> Wish:
    """One question is read by many who look for different things in it."""
    return _read(question, knowledge, is_plain, language, NO_NAMES)


def _read(question: str, knowledge: Knowledge, is_plain: bool, language: str | None, names: Phrases[Meaning]) -> Wish:
    """As `read_question`."""
    text = _as_read(question)
    first: Wish | None = None
    likely = (language,) if language else _likely(question, knowledge)
    first_language = likely[0] if likely else None
    turned = False
    for each in likely:
        # The common words of one language mean nothing in another: “the” is no tea.
        said = text if each == first_language or not first_language else without_common(text, first_language, knowledge)
        reading = _Reading(said, each, knowledge, names, is_plain)
        turned = turned or reading.turned
        wish = reading.wish() if not turned else replace(reading.wish(), turned=True)
        if wish.wanted or wish.refused or wish.wanted_names or wish.refused_names:
            return wish
        first = first or wish
    if first is None:
        # “7-Eleven, which direction?” is in no language that is sure, but names a place.
        reading = _Reading(text, "en", knowledge, names, is_plain)
        named = reading.wish()
        if named.wanted_names and not named.refused_names:
            return Wish((), (), named.wanted_names, (), "en", turned=reading.turned)
    return first or Wish((), (), (), (), None)


@lru_cache(maxsize=_KEPT)
def _as_read(question: str) -> str:
    """A question as it is cut into units: “a sit-down meal” is looked up as three words."""
    text = _ABBREVIATED.sub(r"\1 ", clean_text(question, _QUESTION_LENGTH))
    return _ALLERGY.sub(r"\1 \2", _HYPHEN.sub(" ", text))


@lru_cache(maxsize=_KEPT)
def _likely(question: str, knowledge: Knowledge) -> tuple[str, ...]:
    """The languages in which a question is read in turn, until it says something."""
    text = _as_read(question)
    likely = languages_of(text, knowledge)
    if likely and likely[0] in LATIN and len(text.split()) <= _FEW_WORDS:
        # What says nothing in the likeliest language may be a word of another: “pay”.
        likely = tuple(dict.fromkeys((*likely, *LATIN)))
    return likely


def without_common(text: str, language: str, knowledge: Knowledge) -> str:
    """Return the words of a short text that are no common ones of its language; all in a script without spaces."""
    if language not in LATIN:
        return text
    common = knowledge.common[language]
    return " ".join(word for word in text.split() if knowledge.folder.fold(word).strip(".,;:!?") not in common)


class _Said:
    """What the phrases of a question say, gathered: concepts wanted and refused, by which phrases, and names."""

    def __init__(self, wanted: dict[str, float], refusing: tuple[set[int], set[int]]) -> None:
        self.wanted, self.refusing = wanted, refusing
        self.refused: list[str] = []
        self.wanted_by: dict[str, set[str]] = {}
        self.refused_by: dict[str, set[str]] = {}
        self.refused_with: dict[str, list[set[str]]] = {}
        self.names: dict[str, list[str]] = {"wanted": [], "refused": [], "near": []}

    def refuse(self, span: Span[Meaning], concept: str) -> None:
        """Take a concept of a phrase as refused."""
        self.refused.append(concept)
        self.refused_by.setdefault(concept, set()).add(span.key)
        self.refused_with.setdefault(concept, []).append({other for other, _ in span.value.concepts} - {concept})

    def want(self, span: Span[Meaning], concept: str, weight: float) -> None:
        """Take a concept of a phrase as wanted."""
        self.wanted[concept] = max(weight, self.wanted.get(concept, 0.0))
        self.wanted_by.setdefault(concept, set()).add(span.key)

    def both(self, concept: str) -> set[str]:
        """The phrases by which a concept is wanted and refused."""
        return self.wanted_by.get(concept, set()) & self.refused_by.get(concept, set())


class _Reading:
    """One question in one language: cut once into units, phrases, troubles and clauses, and then weighed."""

    def __init__(self, text: str, language: str, knowledge: Knowledge, names: Phrases[Meaning], is_plain: bool) -> None:
        self._text = _SPANISH_TEA.sub("tea", text) if language == "es" else text
        self._language, self._knowledge = language, knowledge
        self.turned = False
        self._units, spans = self._phrases((names, *knowledge.tables_of(language, is_plain)))
        self._states = knowledge.states(language)
        troubles = [
            trouble
            for trouble in troubles_in(self._units, self._states)
            # “Left luggage” has lost nothing.
            if not any(
                span.value.role == "means" and trouble.units.issubset(range(span.start, span.end)) for span in spans
            )
        ]
        self._spans = [span for span in spans if span.value.role in ("means", "name") or not _is_part(span, troubles)]
        self._troubles = troubles + together_in(knowledge.folder.units(self._text), self._states)
        self._stains = [trouble.units for trouble in self._troubles if trouble.concept == "laundry"]

    def _phrases(self, tables: tuple[Phrases[Meaning], ...]) -> tuple[list[str], list[Span[Meaning]]]:
        folder = self._knowledge.folder
        units = folder.units(self._text)
        starts = folder.word_starts(self._text) if self._language == "ko" else frozenset[int]()

        def is_barred(at: int, end: int, said: Meaning) -> bool:
            # The end of one Korean word and the beginning of the next make no third.
            return end - at == 2 and at + 1 in starts and said.role in ("means", "name")

        spans = longest_phrases(units, tables, is_barred)
        kept = self._knowledge.common[self._language] | self._knowledge.states(self._language).words
        covered = {at for span in spans for at in range(span.start, span.end)}
        spoken = [
            unit if at in covered or unit in kept else known_form(unit, self._language, self._knowledge) or unit
            for at, unit in enumerate(units)
        ]
        again = spans if spoken == units else longest_phrases(spoken, tables, is_barred)
        hidden = self._knowledge.turns_of(self._language)
        self.turned = any(span.key in hidden for span in (*spans, *again))
        return spoken, again

    def wish(self) -> Wish:
        """What is wanted and what is refused."""
        said = self._gathered()
        self._settle(said)
        contradicted = {phrase for concept in said.refused for phrase in said.both(concept)}
        contradicted |= set(said.names["wanted"]) & set(said.names["refused"])
        for concept in (*said.refused, *self._knowledge.said_of_food):
            said.wanted.pop(concept, None)
        wanted = self._weighed(said)
        main = [concept for concept, weight in wanted.items() if weight > GENERAL]
        return Wish(
            tuple(wanted.items()),
            tuple(dict.fromkeys(said.refused)),
            tuple(dict.fromkeys(said.names["wanted"])),
            tuple(dict.fromkeys(said.names["refused"])),
            self._language,
            tuple(dict.fromkeys(said.names["near"])),
            () if main else tuple(sorted(contradicted)),
            *self._parted(*said.refusing),
        )

    def _parted(self, refusing: set[int], things: set[int]) -> tuple[str, str]:
        """The question without what refuses, and what is refused alone; two empty texts where nothing is."""
        without, every = self._knowledge.folder.without, set(range(len(self._units)))
        return (without(self._text, refusing), without(self._text, every - things)) if refusing else ("", "")

    def _gathered(self) -> _Said:
        """Go through the clauses: what is wanted, what is refused, what is only said by the way."""
        knowledge = self._knowledge
        clauses = clauses_of(self._units, self._spans, self._language, knowledge)
        told = told_in(clauses, self._units, self._language, knowledge, asks_for_another(self._text))
        refusing = _refusing(clauses, told)
        refused = [span for each in told for span, stand in each if stand is Stand.REFUSED]
        # “A toilet, but not the disabled one.”
        self._troubles = [
            each
            for each in self._troubles
            if each.units <= refusing[0] or not any(_is_part(span, [each]) for span in refused)
        ]
        said = _Said({trouble.concept: MAIN for trouble in self._troubles}, refusing)
        asides = _asides(self._spans, self._units, knowledge)
        asides |= {span.start for span in self._spans if _is_part(span, self._troubles)}
        has_main = bool(self._troubles) or any(
            span.value.role == "means" and span.start not in asides and not is_general(span, knowledge)
            for span in self._spans
        )
        asides |= spilled(self._spans, self._stains, self._units, knowledge)
        for span, stand in (each for clause in told for each in clause):
            is_aside = span.start in asides or stand is Stand.ASIDE
            is_refused = stand is Stand.REFUSED
            for concept, weight in span.value.concepts:
                if span.value.role == "name":
                    said.names["refused" if is_refused else "near" if is_aside else "wanted"].append(concept)
                elif is_refused:
                    said.refuse(span, concept)
                else:
                    said.want(
                        span, concept, weight * (ASIDE if is_aside and has_main else _importance(concept, knowledge))
                    )
        return said

    def _settle(self, said: _Said) -> None:
        """Tell what is truly refused from what is only named beside it."""
        knowledge, wanted = self._knowledge, said.wanted
        for concept in {*wanted, *said.refused} & set(knowledge.refusing):
            # “Gluten free” names what it refuses.
            wanted.pop(concept, None)
            said.refused.append(knowledge.refusing[concept])
        if "lost_item" in wanted and says_at_home(self._units, self._states):
            wanted["lost_item"] = HINT
        # “No clothes for women, but for men” refuses no clothes.
        refused = [
            concept
            for concept in said.refused
            if concept not in wanted
            or not all(others - wanted.keys() for others in said.refused_with.get(concept, [set()]))
        ]
        # Nobody refuses to eat (“I'm hungry, but not for that”), but who wants a present may want none to eat.
        spared = knowledge.general - (_MEALS if {*GIFTS, "business", "shop"} & wanted.keys() else frozenset())
        said.refused = [concept for concept in refused if concept not in spared]

    def _weighed(self, said: _Said) -> dict[str, float]:
        """Weigh what is wanted: what is done to things, whom they are for, what will do instead."""
        knowledge, wanted = self._knowledge, said.wanted
        if said.refused and all(concept in knowledge.instead_of for concept in said.refused):
            # Who eats no meat wants a kitchen without.
            wanted |= {knowledge.instead_of[concept]: MAIN for concept in said.refused}
        is_child_ill = "child" in wanted and max(wanted.get("medicine", 0.0), wanted.get("doctor", 0.0)) >= MAIN
        wanted = as_treated(without_symptoms(wanted, knowledge), knowledge)
        if is_child_ill:
            # A child that is ill is taken to its own doctor where there is one.
            wanted["amenity/doctors/paediatrics"] = MAIN
        if self._stains and "clothes" in wanted:
            # Where nobody cleans the shirt, another one will do.
            wanted["clothes"] = THING
        if not knowledge.worn.isdisjoint(wanted) and knowledge.people.isdisjoint({*wanted, *said.refused}):
            # A jacket for “my husband” is one for men.
            named = {span.value for span in longest_phrases(self._units, (knowledge.relatives[self._language],))}
            wanted |= dict.fromkeys(named, MODIFIER) if len(named) == 1 else {}
        return wanted


def asks_for_another(question: str) -> bool:
    """Whether a question asks for something beside what it names."""
    return _ANOTHER.search(question) is not None


def _refusing(clauses: Sequence[Clause], told: Sequence[Told]) -> tuple[set[int], set[int]]:
    """The units of a question that refuse something, and those of them that say what.

    They are clauses that do nothing else, and the phrases of others.
    """
    found: set[int] = set()
    words: set[int] = set()
    for clause, each in zip(clauses, told, strict=True):
        no = [span for span in clause.spans if span.value.role.startswith("refuse")]
        refused = [span for span, stand in each if stand is Stand.REFUSED]
        if not any(stand is Stand.WANTED for _, stand in each):
            found.update(clause.units if refused or no else ())
        elif refused:
            found.update(at for span in (*no, *refused) for at in range(span.start, span.end))
        turns = (span for span in clause.spans if span.value.role not in ("means", "name"))
        words.update(at for span in turns for at in range(span.start, span.end))
    return found, found - words


def _is_part(span: Span[Meaning], troubles: Sequence[Trouble]) -> bool:
    return any(not trouble.units.isdisjoint(range(span.start, span.end)) for trouble in troubles)


def _asides(spans: Sequence[Span[Meaning]], units: Sequence[str], knowledge: Knowledge) -> set[int]:
    """Starts of the phrases that are only said by the way: after “before my”, before の前に."""
    asides: set[int] = set()
    for before, after in pairwise(spans):
        between = units[before.end : after.start]
        # “Sit in the dark and watch something” wants a film.
        is_close = len(between) <= NEXT_TO and knowledge.both.isdisjoint(between)
        if is_close and before.value.role == "context_before" and after.value.role in ("means", "name"):
            asides.add(after.start)
        if is_close and after.value.role == "context_after" and before.value.role in ("means", "name"):
            asides.add(before.start)
    return asides


def _importance(concept: str, knowledge: Knowledge) -> float:
    if concept in knowledge.general:
        return GENERAL
    return MODIFIER if concept in knowledge.modifiers else MAIN


def instead_of(refused: Sequence[str], knowledge: Knowledge) -> tuple[tuple[str, float], ...]:
    """What someone wants who only says what not: something else of the same use."""
    wanted: dict[str, float] = {}
    for concept in refused:
        for above in knowledge.above(concept):
            if above in knowledge.instead:
                wanted[knowledge.instead[above]] = GENERAL
    return tuple((concept, weight) for concept, weight in wanted.items() if concept not in refused)


def spoken_key(text: str) -> bool:
    """Whether a name may be looked for inside a question: short or unspaced one-letter names would match anywhere."""
    return len(text) >= (2 if is_unspaced(text) else 3)
