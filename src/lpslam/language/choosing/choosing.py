"""Choosing the landmark that serves a question (navigation, III-I) among any number of landmarks."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import FITS, FITS_INSTEAD, Matches, Served, serve
from lpslam.language.languages import LATIN
from lpslam.language.model import Choice
from lpslam.language.questions.phrasing import Phrases, answer_language, phrases_in
from lpslam.language.questions.question import asks_for_another, instead_of, read_question, without_common
from lpslam.language.questions.speaking import languages_of
from lpslam.language.questions.stance import places_of
from lpslam.language.questions.wanted import Wish
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.reader import SignReader
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import PhraseTable, longest_phrases

_YES = 0.5  # a place is a kind when its words say so at least this surely
_SPECIAL = 0.5  # a wanted concept of this weight is more than “food” or “a shop”
_ALTERNATIVES = 5
_FEW_WORDS = 2  # words of a question that may be in another language than it seems
_MALL = 0.3  # of the landmarks: so many shops make a mall of a building
_BARE_NO = 5  # letters of a plain “not” in any language; longer phrases refuse
_FEW = 3  # landmarks that one word may stand for
_ANY = frozenset({"shop", "place", "business"})  # kinds that say nothing of what is wanted
_PLACES = (
    *("amenity/", "shop/", "tourism/", "facility/", "department/"),
    *("healthcare/", "office/", "leisure/", "railway/"),
)
"""Kinds of place that are no word of another language by chance."""
_PART = "part:"  # before the words that are parts of names, among names


Scores = dict[int, float]
"""How well landmarks serve, by id, 0 to 1; those that do not serve are not in it."""
Understood = tuple[Wish, set[int]]
"""A wish, and the landmarks that are refused by a part of their name."""


@dataclass(frozen=True, slots=True, eq=False)
class Ranked:
    """What serves a question.

    Attributes:
        choice: the best, and why.
        scores: of all landmarks that serve.
        why: why any of these serves, by id, where that is another reason for each; in the question's language.
    """

    choice: Choice
    scores: Scores = field(default_factory=dict)
    why: Callable[[int], str] | None = None

    def reason(self, id_: int) -> str:
        """Why one of those that serve does."""
        return self.choice.evidence if self.why is None else self.why(id_)


class Choosing:
    """Chooses among one set of landmarks, as the tables read a question."""

    def __init__(self, index: LandmarkIndex, signs: SignReader, knowledge: Knowledge, model: str) -> None:
        self._index, self._signs, self._knowledge, self._model = index, signs, knowledge, model

    def ranked(self, question: str, language: str | None = None) -> Ranked:
        """What serves a question as the tables read it, with the scores of all landmarks that serve; no guess.

        `language` is that of the text which the question is a part of.
        """
        understood = self._understand(question, language=language)
        said_in = answer_language(question, language)
        first = self._as_understood(understood, question, said_in)
        if first.choice.landmark is not None or understood[0].contradicted:
            return first
        alone = None if language is None else self._understand(question)
        as_alone = () if alone is None or alone == understood else (alone,)
        for other in (*as_alone, *self._other_readings(understood[0], question)):
            found = self._as_understood(other, question, said_in)
            if found.choice.landmark is not None:
                return found
        return first

    def _other_readings(self, wish: Wish, question: str) -> Iterator[Understood]:
        """How else a question may be meant of which nothing here serves the first reading."""
        if self._index.shops >= _MALL and wish.turned:
            # A turn of phrase of hospitals may hide a word that serves in a mall.
            plain = self._understand(question, is_plain=True)
            if plain[0] != wish:
                yield plain
        is_a_place = any(concept.startswith(_PLACES) for concept, _ in wish.wanted)
        is_plain = not (is_a_place or wish.refused or wish.wanted_names)
        if wish.language in LATIN and len(question.split()) <= _FEW_WORDS and is_plain:
            # “Pan” is a pan in English and bread in Spanish; “the” is no tea.
            bare = without_common(question, wish.language, self._knowledge)
            for language in LATIN if bare else ():
                if language != wish.language:
                    yield self._understand(bare, language=language)

    def _as_understood(self, understood: Understood, question: str, said_in: str) -> Ranked:
        wish, refused = understood
        wish = self._as_in_this_building(wish)
        phrases = phrases_in("en" if wish.language is None else said_in)
        if not self._index.landmarks or wish.language is None:
            why = "unread" if self._index.landmarks else "empty_map"
            return Ranked(Choice(None, float(not self._index.landmarks), phrases.say(why), self._model))
        wish, refused = self._without_refused(wish, refused, question)
        named = [id_ for name in wish.wanted_names for id_ in self._index.ids_of.get(name, ()) if id_ not in refused]
        if named:
            choice = Choice(named[0], 0.95, phrases.say("named"), self._model, tuple(named[1 : 1 + _ALTERNATIVES]))
            return Ranked(choice, dict.fromkeys(named, 1.0))
        if wish.contradicted and not asks_for_another(question):
            said_both = phrases.say("contradiction", things=", ".join(wish.contradicted))
            return Ranked(Choice(None, 0.8, said_both, self._model))
        if not wish.wanted:
            wish = replace(wish, wanted=self._instead_of_refused(wish, refused))
        says_only_where = all(kind in self._knowledge.venues for kind, _ in wish.wanted)
        if says_only_where and wish.refused and not refused and not _asks(question, wish.language, self._knowledge):
            # Who asks for nothing and refuses what nothing stands in for tells of it: “my laptop is not starting”.
            wish = replace(wish, wanted=tuple((kind, 1.0) for kind in wish.refused), refused=())
        wanted = dict(wish.wanted)
        missing = [name for name in wish.wanted_names if name not in self._index.ids_of]
        if missing and not any(weight >= _SPECIAL for weight in wanted.values()):
            # A brand was asked for that is not here; another of its kind may do, but that is for the asker to say.
            return Ranked(self._without_brand(missing[0], question, phrases))
        if not wanted:
            return Ranked(Choice(None, 0.0, phrases.say("no_kind"), self._model))
        if wanted.keys() <= _ANY:
            return Ranked(Choice(None, 0.5, phrases.say("unknown"), self._model))
        return self._best(wish, refused, phrases)

    def _without_refused(self, wish: Wish, refused: set[int], question: str) -> tuple[Wish, set[int]]:
        """The landmarks that are refused by name or as one of many, and what is wanted then."""
        refused = refused | {id_ for name in wish.refused_names for id_ in self._index.ids_of.get(name, ())}
        if asks_for_another(question):
            # “Starbucks is full, another café?” names what is not wanted.
            named_besides = (*wish.wanted_names, *wish.near_names)
            refused |= {id_ for name in named_besides for id_ in self._index.ids_of.get(name, ())}
            if refused and wish.refused and not wish.wanted:
                # “除了星巴克还有别的咖啡店吗”: the name is refused, and its kind is what is asked for.
                wish = replace(wish, wanted=tuple((kind, 1.0) for kind in wish.refused), refused=())
        if "chain" in wish.refused:
            refused |= {id_ for id_, sign in self._index.signs.items() if sign.identity}
        return wish, refused

    def _instead_of_refused(self, wish: Wish, refused: set[int]) -> tuple[tuple[str, float], ...]:
        """Where only a refusal is said: something else of the same use."""
        others = [*wish.refused, *(kind for id_ in refused for kind, _ in self._index.signs[id_].kinds)]
        return instead_of(others, self._knowledge)

    def _as_in_this_building(self, wish: Wish) -> Wish:
        """Leave out kinds of rooms that no place of this map is, where words mean something else besides.

        “Milk” is an aisle in a supermarket, and groceries in a mall.
        """
        wanted = [concept for concept, _ in wish.wanted]
        absent = {concept for concept in wanted if self._knowledge.family(concept) and not self._index.has(concept)}
        left = tuple(each for each in wish.wanted if each[0] not in absent)
        return replace(wish, wanted=left) if absent and left else wish

    def _understand(self, question: str, is_plain: bool = False, language: str | None = None) -> Understood:
        """Read a question that may mention landmarks by name, and brands that are not here.

        Returns:
            The wish, and the landmarks that are refused by a part of their name.
        """
        text = clean_text(question)
        brands = {
            phrase: Meaning("name", ((self._index.phrase_of.get(identity, identity), 1.0),))
            for phrase, identity in self._signs.brands_in(text).items()
            if phrase not in self._index.names
        }
        is_unsaid = partial(self._index.is_unsaid, text)
        names = _Names(PhraseTable(brands), self._index.names, is_unsaid)
        parts = self._parts_in(text)
        if not parts:
            return read_question(question, self._knowledge, names, is_plain, language), set()
        mentioned = {word: Meaning("name", ((_PART + word, 1.0),)) for word in parts}
        all_names = _Names(PhraseTable(brands | mentioned), self._index.names, is_unsaid)
        wish = read_question(question, self._knowledge, all_names, is_plain, language)
        refused = {name for name in wish.refused_names if name.startswith(_PART)}
        if not refused:
            # A part of a name may be any word: alone it asks for nothing.
            return read_question(question, self._knowledge, names, is_plain, language), set()
        wanted, others, near = (
            tuple(name for name in names if not name.startswith(_PART))
            for names in (wish.wanted_names, wish.refused_names, wish.near_names)
        )
        wish = replace(wish, wanted_names=wanted, refused_names=others, near_names=near)
        return wish, {id_ for name in refused for id_ in parts[name.removeprefix(_PART)]}

    def _parts_in(self, text: str) -> dict[str, set[int]]:
        """Words of a question that mean nothing themselves and stand in the names of few landmarks."""
        every = self._knowledge.folder.units(text)
        units = {unit for unit in every if unit in self._index.ids_by_word}
        few = {
            unit: ids
            for unit in units
            if unit not in self._index.names and len(ids := self._index.ids_by_word[unit]) <= _FEW
        }
        if not few:
            return {}
        languages = languages_of(text, self._knowledge)[:2]
        return {
            unit: ids
            for unit, ids in few.items()
            if not any(unit in self._knowledge.spoken(each) for each in languages)
        }

    def _best(self, wish: Wish, refused: set[int], phrases: Phrases) -> Ranked:
        matches = {concept: self._index.matches(concept) for concept, _ in wish.wanted}
        served = serve(wish, matches, self._index.kinds, self._index.people, self._knowledge)
        ranked = sorted(served, key=lambda each: (-each.score, self._index.members[each.group]))
        asked = phrases.say("wanted", things=phrases.things([concept for concept, _ in wish.wanted]))
        fitting = [each for each in ranked if each.best >= FITS]
        ids = self._first_ids(fitting, refused)
        if not ids and (refused or wish.refused):
            fitting = [each for each in ranked if each.best >= FITS_INSTEAD]
            ids = self._first_ids(fitting, refused)
        if not ids:
            nothing = phrases.say("nothing_offers", wanted=asked)
            return Ranked(Choice(None, 0.6, nothing, self._model, tuple(self._first_ids(ranked, refused)[:3])))
        of = {id_: each for each in fitting for id_ in self._index.members[each.group] if id_ not in refused}
        why = partial(_serves, of, matches, asked, self._index, phrases)
        choice = Choice(ids[0], round(min(of[ids[0]].best, 0.99), 3), why(ids[0]), self._model, tuple(ids[1:]))
        return Ranked(choice, {id_: each.score for id_, each in of.items()}, why)

    def _first_ids(self, ranked: Sequence[Served], refused: set[int]) -> list[int]:
        """The first few ids of the best groups, by score and then by id."""
        found: list[tuple[float, int]] = []
        for served in ranked:
            if len(found) > _ALTERNATIVES and served.score < found[-1][0]:
                break
            left = [id_ for id_ in self._index.members[served.group] if id_ not in refused][: _ALTERNATIVES + 1]
            found.extend((served.score, id_) for id_ in left)
        return [id_ for _, id_ in sorted(found, key=lambda each: (-each[0], each[1]))[: _ALTERNATIVES + 1]]

    def _without_brand(self, identity: str, question: str, phrases: Phrases) -> Choice:
        asked = self._knowledge.folder.fold(question)
        # Of a brand's many names, the one that was used.
        name = max(
            (each for each in self._signs.names_of(identity) if self._knowledge.folder.fold(each) in asked),
            key=len,
            default="",
        )
        alike: dict[int, float] = {}
        for kind, weight in self._signs.read(identity).kinds:
            for group, share in self._index.alike(kind).items():
                first = self._index.members[group][0]
                alike[first] = max(weight * share, alike.get(first, 0.0))
        others = sorted((id_ for id_ in alike if alike[id_] >= _YES), key=lambda id_: (-alike[id_], id_))
        return Choice(
            None, 0.8, phrases.say("no_brand", name=name or identity), self._model, tuple(others[:_ALTERNATIVES])
        )


def _asks(question: str, language: str | None, knowledge: Knowledge) -> bool:
    """Whether a question has a word of wishing or refusing for somebody who asks: “where”, “I want”, “instead of”."""
    if language is None:
        return False
    units = knowledge.folder.units(question)
    spans = longest_phrases(units, (knowledge.spoken(language),))
    is_refusal = any(span.value.role.startswith("refuse") and len(span.key) > _BARE_NO for span in spans)
    return is_refusal or bool(places_of(knowledge.wishing[language], units))


@dataclass(frozen=True, slots=True, eq=False)
class _Names:
    """A few names before many, without copying the many, and without some of them."""

    few: PhraseTable[Meaning]
    many: PhraseTable[Meaning]
    is_hidden: Callable[[str], bool]

    def get(self, key: str, /) -> Meaning | None:
        found = self.few.get(key)
        if found is None and (found := self.many.get(key)) is not None and self.is_hidden(key):
            return None
        return found

    def sizes(self, units: Sequence[str], at: int, /) -> Collection[int]:
        few = self.few.sizes(units, at)
        return (*few, *self.many.sizes(units, at)) if few else self.many.sizes(units, at)


def _serves(
    served: Mapping[int, Served], matches: Matches, asked: str, index: LandmarkIndex, phrases: Phrases, id_: int
) -> str:
    """Why one of the landmarks that serve does."""
    name, sign, group = clean_text(index.name_of[id_]), index.signs[id_].evidence, served[id_].group
    things = [concept for concept, found in matches.items() if found.get(group, 0.0) >= FITS]
    return phrases.say("serves", wanted=asked, name=name, sign=sign, things=phrases.things(things))
