"""Which landmarks serve a stop's words: by what stands on their boards first, then by what they are.

Ids and strings only: where landmarks stand is the map's own knowledge.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache, partial

from lpslam.language.choosing.choosing import Choosing, Ranked
from lpslam.language.choosing.evidence import Supported
from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import FITS, best_of, match
from lpslam.language.kept import steps_of
from lpslam.language.languages import CAPITALS_ARE_NAMES
from lpslam.language.model import Candidate
from lpslam.language.questions.phrasing import answer_language, phrases_in
from lpslam.language.questions.question import read_part, read_question
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.reader import SignReader
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.wishes.board_words import AskedWords, BoardWords
from lpslam.language.wishes.codes import without_codes
from lpslam.language.wishes.form import Ask, Stop, with_meaning
from lpslam.language.wishes.guesses import IN_SPITE, KIND_SURE, LEAST_IN_SPITE, Guesses, clues_of, is_told
from lpslam.language.wishes.identities import Identities
from lpslam.language.wishes.names import Names
from lpslam.language.wishes.refusing import Refusing
from lpslam.language.wishes.rules import parted
from lpslam.language.wishes.served import AS_WELL, UNQUESTIONED, Served, Way
from lpslam.language.wishes.sorts import Sorts, attributes_of, told_apart
from lpslam.language.wishes.trust import Opening, Trust

_FEWEST_TO_TELL_APART = 2
_SHORT_QUESTION = 8  # words of a question whose capital is the name that it asks for
_BRIEF = math.log1p(2)  # of a wish of two words, as `clues_of` has its length: “milk”
_COMPARABLE = 0.6  # of the best score: places that an attribute may tell apart
_FEW_WORDS = 3  # of a stop that may be no more than a name and the words before it
_SHORT_NAME = 5  # words of an anchor that is a name
_OFFERS = 0.8  # of what is asked for: a place that has it of its own
_DISTRUSTED = "what the only such board says reads as if it spoke to a machine"
_NAMED = 0.9  # of what alone tells a place
_WHOLE = 0.95  # of a name's letters: the name itself
_KEPT = 8  # stops of which it is kept what they say of the place: one and its parts
_READ = 0.5  # a wanted concept of this weight is more than “food” or “a shop”


class EmbeddedScorer:
    """The embedded model's scores over one set of landmarks."""

    def __init__(
        self, landmarks: Sequence[Candidate], index: LandmarkIndex, signs: SignReader, knowledge: Knowledge
    ) -> None:
        self.model = "offline"
        self._landmarks = landmarks
        self._index = index
        self._signs = signs
        self._knowledge = knowledge
        self._choosing = Choosing(index, signs, knowledge, self.model)
        self._asked = AskedWords(knowledge)
        self._names = Names(landmarks, knowledge, signs.repair)
        self._boards = BoardWords(self._names, self._asked, index, knowledge)
        self._identities = Identities(landmarks, self._names, knowledge)
        self._sorts = Sorts(landmarks, index, knowledge)
        self._opening = Opening(landmarks)
        self._by_id = {mark.id: mark for mark in landmarks}
        self._guesses = Guesses(index, self._names, knowledge)
        self._trust = Trust(landmarks, index)
        self._trusted = self._trust.of
        self._refusing = Refusing(self.serve, self._boards, self._identities, index, knowledge)
        self._attributes = lru_cache(maxsize=_KEPT)(self._wanted_attributes)
        self._clues = partial(clues_of, index=index, asked=self._asked, knowledge=knowledge)

    def steps(self) -> Iterator[None]:
        """Build what is made when it is first asked for, a little at a time."""
        own = (self._names, self._identities, self._opening, self._guesses, self._trust, self._index.names)
        return steps_of((*own, self._signs, self._signs.repair))

    def serve(self, stop: Stop) -> Served:
        """Return the landmarks that serve a stop: by identity, by name, else by what they are."""
        served = self._judged(self._found(stop)) if stop.what else self._trust.any_place(stop)
        served = self._heeding(served) if stop.identity and served.way is not Way.IDENTITY else served
        if stop.what and not stop.identity and self._identities.is_another_number(stop.what, _best(served.scores)):
            served = replace(served, scores={}, evidence="no board bears this number")
        is_unsure = not served.scores or served.sure < LEAST_SURE * served.strictness
        if stop.what and is_unsure and not (stop.identity or served.settled):
            held = self._trusted(self._identities.held(stop.what))
            served = Served(stop, held, "the board bears it", 0.8, way=Way.IDENTITY) if held else served
        if stop.floor is not None:
            served = replace(served, on_any_floor=frozenset(filter(self._sorts.joins_floors, served.scores)))
        return self._opening.open(served) if stop.at else served

    def _heeding(self, served: Served) -> Served:
        """What serves a stop of which a number was thought to be said by the way, but for what is numbered otherwise.

        “Building 5, please, my colleague is there” asks for nothing else that is here.
        """
        scores = {id_: score for id_, score in served.scores.items() if not self._identities.differs(id_, served.stop)}
        served = replace(served, scores=scores)
        if scores and served.sure >= LEAST_SURE and served.way is not Way.GUESS:
            return served
        bearing = self._trusted(self._identities.bearing_all(served.stop))
        return Served(served.stop, bearing, "the board bears it", 0.97, way=Way.IDENTITY) if bearing else served

    def _judged(self, served: Served) -> Served:
        """With how probable it is that what serves is what was meant; a guess where that is likelier."""
        stop = served.stop
        is_missing = bool(stop.identity) and not served.scores and not served.ignored
        if served.settled or is_missing or served.way in UNQUESTIONED[1:]:
            return served
        meaning = self._read(stop)
        language = self._language(stop, meaning)
        served, clues = self._surest(served, meaning, language)
        if is_told(stop) or served.way in UNQUESTIONED[1:]:
            return served
        if self._boards.refuses(stop.what, meaning) or self._boards.parted(stop.what, meaning, language):
            left = self._refusing.left_of(served, meaning, language)
            is_found = bool(left.scores) and left.sure >= LEAST_SURE
            if is_found or meaning.contradicted or self._boards.leaves_out(stop.what, language):
                return left
            return self._guesses.told(left, meaning, language, partial(self._not_refused, stop, meaning))
        if self._boards.is_bare_name(stop.what, meaning):
            # A name that stands on no board is hardly answered by another place.
            return served if served.sure >= LEAST_IN_SPITE else replace(served, sure=0.0)
        if meaning.wanted_names or (served.scores and not clues and not served.is_said):
            return served
        if served.is_said:
            clues = clues or self._clues(served)
        judged = self._guesses.judged(served, clues, meaning, language, partial(self._not_otherwise, stop))
        # Words that ask for this kind alone are outdone only by a sure guess.
        is_sure_guess = judged.way is Way.GUESS and judged.sure >= LEAST_IN_SPITE
        return served if served.is_said and not is_sure_guess else judged

    def _surest(self, served: Served, meaning: Meaning, language: str) -> tuple[Served, Mapping[str, float]]:
        """What tables found, or boards say where that is unsure; and its clues, none where nothing is to be doubted."""
        if not served.scores or served.way is Way.NAME:
            return served, {}
        clues = self._clues(served)
        offers = (
            max(clues[each] for each in ("is one", "offers it", "phrase of several words", "only general")) >= _OFFERS
        )
        is_said = clues["says so"] >= 1.0 and clues["length"] <= _BRIEF
        if (is_said and offers) or min(clues["says so"], clues["is one"]) >= 1.0:
            # Every word asks for this very kind, and the sign is one: “a restaurant”; or two for what it offers.
            return replace(served, is_said=True), {}
        sure = self._guesses.sure(served, clues, meaning, language)
        is_said = is_said and sure >= LEAST_SURE
        is_doubted = served.way is Way.KIND and served.stop.ask is not Ask.WHETHER
        strict = max(served.strictness, KIND_SURE if is_doubted else 0.0)
        served = replace(served, sure=sure, confidence=min(served.confidence, sure), is_said=is_said, strictness=strict)
        if sure >= LEAST_SURE or served.way not in (Way.KIND, Way.GUESS):
            return served, clues
        said = self._by_words(served.stop, meaning, served.ignored)
        of_said = self._clues(said) if said is not None and said.scores else {}
        other = self._guesses.sure(said, of_said, meaning, language) if said is not None and of_said else 0.0
        if max(other, sure) < LEAST_SURE and (heard := self._by_ear(served.stop, meaning, served.ignored)) is not None:
            return heard, {}
        if said is None or other <= sure:
            return served, clues
        return replace(said, sure=other, confidence=other), of_said

    def _not_otherwise(self, stop: Stop, scores: Mapping[int, float]) -> dict[int, float]:
        """Landmarks that may be trusted, and whose boards say nothing else: the north entrance is not the east one."""
        asked = self._attributes(stop.what, stop.language)
        return {
            id_: score
            for id_, score in self._trusted(scores).items()
            if not asked or told_apart(asked, attributes_of(self._by_id[id_].name)) >= 0
        }

    def _not_refused(self, stop: Stop, meaning: Meaning, scores: Mapping[int, float]) -> dict[int, float]:
        """Of those, landmarks that are not what a negation is said of."""
        refused = {id_ for name in meaning.refused_names for id_ in self._index.ids_of.get(name, ())}
        return {id_: score for id_, score in self._not_otherwise(stop, scores).items() if id_ not in refused}

    def _language(self, stop: Stop, meaning: Meaning) -> str:
        return meaning.language or next(iter(self._asked.likely(stop.what)), "en")

    def _read(self, stop: Stop) -> Meaning:
        return read_part(stop.what, stop.language, self._knowledge, self._index.names)

    def _by_words(self, stop: Stop, meaning: Meaning, ignored: tuple[str, ...]) -> Served | None:
        """The landmarks whose boards say the words themselves."""
        literal = self._told_apart(stop, self._boards.literal(stop.what))
        if not literal:
            return None
        scores = self._trusted(literal)
        strength = max(scores.values(), default=0.0)
        said = "the board says these words" if scores else _DISTRUSTED
        return Served(stop, scores, said, 0.7, ignored=ignored, way=Way.WORDS, strength=strength)

    def _found(self, stop: Stop) -> Served:
        allowed, ignored, failed = self._identities.identified(stop)
        if failed:
            return Served(stop, {}, f"no board bears {failed}", 0.8, self._of_what(stop), ignored)
        if allowed is not None:
            scores = self._of_the_kind(stop, self._trusted(allowed))
            return Served(stop, scores, "the board bears it", 0.97, ignored=ignored, way=Way.IDENTITY)
        here = {} if stop.identity else self._identities.numbered_as_here(stop.what)
        if here:
            return Served(stop, self._trusted(here), "the board bears it", 0.97, ignored=ignored, way=Way.IDENTITY)
        meaning = self._read(stop)
        stop = with_meaning(stop, [kind for kind, _ in meaning.wanted], (*meaning.refused, *meaning.refused_names))
        found = self._identities.told_apart(stop.what, self._boards.by_name(stop.what, meaning))
        if found:
            scores = self._trusted(found)
            named = frozenset(scores)
            strength = max(scores.values(), default=0.0)
            said = "the board says the name" if scores else _DISTRUSTED
            return Served(stop, scores, said, 0.95, ignored=ignored, exact=named, way=Way.NAME, strength=strength)
        general = self._sorts.of_any_sort(stop, meaning)
        if general:
            scores = self._trusted(general)
            return Served(stop, scores, "any of this sort", 0.9, ignored=ignored, way=Way.SORT)
        tables = self._choosing.ranked(stop.what, stop.language)
        choice = tables.choice
        scores = self._sorts.of_the_family(meaning, self._trusted(tables.scores))
        is_one = not is_told(stop) and not self._boards.refuses(stop.what, meaning)
        scores = self._identities.told_apart(stop.what, self._told_apart(stop, scores), is_one)
        by_board = None if scores else self._by_words(stop, meaning, ignored) or self._by_ear(stop, meaning, ignored)
        if by_board is not None:
            return by_board
        is_missing = self._is_another(stop, meaning, scores) if scores else self._is_missing_brand(stop, meaning)
        supported = None if is_missing else self._supported(stop, meaning, scores)
        best = _best(scores if supported is None else supported.scores)
        if is_missing or (best and self._boards.are_others(stop.what, meaning, best)):
            return Served(*(stop, {}, choice.evidence, choice.confidence, choice.alternatives, ignored), settled=True)
        if not scores and supported is None:
            return Served(stop, {}, choice.evidence, choice.confidence, choice.alternatives, ignored)
        read, top = scores, max(scores.values(), default=0.0)
        scores = {id_: score / top for id_, score in scores.items()}
        words, _ = self._asked.asked(stop.what)
        exact = frozenset(id_ for id_, share in self._names.covered(words).items() if share >= _WHOLE and id_ in scores)
        is_named = bool(meaning.wanted_names and scores)
        why = tables.reason if supported is None else self._spoken_for(stop, tables, supported)
        serving = scores if supported is None else supported.scores
        told = Served(
            *(stop, serving, why(best_of(serving)), choice.confidence),
            ignored=ignored,
            exact=exact & serving.keys(),
            way=Way.NAME if is_named else Way.KIND if read else Way.GUESS,
            strength=top,
            heard={} if supported is None else supported.clues,
            read={} if supported is None else read,
            why=why,
        )
        # What was read, and is nowhere here, is not answered by what is only near it.
        is_near = not read and self._is_missing(stop, meaning)
        return replace(told, strictness=IN_SPITE, doubt=choice.evidence) if is_near else told

    def _is_missing(self, stop: Stop, meaning: Meaning) -> bool:
        """“The swimming pool” is no place that has to do with water: what is read in full, and is not here."""
        return any(weight >= _READ for _, weight in meaning.wanted) and not self._asked.asked(stop.what)[1]

    def _is_missing_brand(self, stop: Stop, meaning: Meaning) -> bool:
        """Whether a brand is asked for that is not here, and nothing else: no other place is meant."""
        brands = self._signs.brands_in(stop.what).values()
        is_lacking = bool(brands) and self._index.phrase_of.keys().isdisjoint(brands) and not is_told(stop)
        return is_lacking and not any(weight >= _READ for _, weight in meaning.wanted)

    def _is_another(self, stop: Stop, meaning: Meaning, scores: Mapping[int, float]) -> bool:
        """Whether a name is asked for that stands on no board, where boards of the sort bear names: room Gamma."""
        languages, said = self._asked.likely(stop.what), stop.what.split()
        if not CAPITALS_ARE_NAMES.issuperset(languages[:1]) or len(said) > _SHORT_QUESTION:
            return False
        capital = {self._knowledge.folder.fold(word) for word in said[1:] if word[:1].isupper()}
        named = [word for word in self._asked.asked(stop.what)[1] if word in capital]
        if not named or self._boards.refuses(stop.what, meaning) or scores.keys() & self._names.covered(named).keys():
            return False
        best = _best(scores)
        return all(self._sorts.is_a_room(id_) and self._asked.of(self._by_id[id_].name, languages)[1] for id_ in best)

    def _by_ear(self, stop: Stop, meaning: Meaning, ignored: tuple[str, ...]) -> Served | None:
        """The one landmark whose name sounds like what is asked for."""
        heard = self._boards.by_ear(stop.what, meaning)
        if not heard:
            return None
        scores, said = self._trusted(heard), "a name that sounds so"
        return Served(stop, scores, said, 0.8, ignored=ignored, way=Way.HEARD, strength=max(heard.values()))

    def _supported(self, stop: Stop, meaning: Meaning, scores: Mapping[int, float]) -> Supported | None:
        """What the words of a stop speak for, beside what the tables read; None where that is not theirs to say.

        Nothing that is refused is weighed; and what a place, an order or a list tells apart is a sort that is read.
        """
        if is_told(stop) and scores:
            return None
        if meaning.wanted_names or self._boards.refuses(stop.what, meaning):
            return None
        found = self._guesses.support.of(stop.what, self._language(stop, meaning), scores)
        kept = self._identities.told_apart(stop.what, self._not_otherwise(stop, found.scores), not is_told(stop))
        if not scores and self._is_missing(stop, meaning):
            # A place to eat that has no pizza by the tables has none by the words of the question.
            general = [kind for kind, _ in meaning.wanted if kind in self._knowledge.general]
            kept = {id_: score for id_, score in kept.items() if not self._serves_any(id_, general)}
        return replace(found, scores=kept) if kept else None

    def _serves_any(self, id_: int, kinds: Sequence[str]) -> bool:
        own = self._index.signs[id_].kinds
        return any(match(kind, own, self._knowledge) >= FITS for kind in kinds)

    def _spoken_for(self, stop: Stop, tables: Ranked, supported: Supported) -> Callable[[int], str]:
        """Why a landmark is chosen: as the tables read the question, else by its words."""
        phrases = phrases_in(answer_language(stop.what, stop.language))
        best = best_of(supported.scores)
        words = phrases.join(supported.words) or stop.what

        def why(id_: int) -> str:
            if id_ in tables.scores and not id_ == best != tables.choice.landmark:
                return tables.reason(id_)
            name = clean_text(self._index.name_of[id_])
            return phrases.say("words_speak", words=words if id_ == best else stop.what, name=name)

        return why

    def _of_the_kind(self, stop: Stop, scores: dict[int, float]) -> dict[int, float]:
        """Of several that bear a code, those of the kind that the words say: who flies out of A27 wants a gate."""
        if len(scores) < _FEWEST_TO_TELL_APART:
            return scores
        meaning = read_question(without_codes(stop.what), self._knowledge)
        fitting = {id_: score for id_, score in scores.items() if self._serves_any(id_, meaning.main)}
        return fitting or scores

    def _told_apart(self, stop: Stop, scores: Mapping[int, float]) -> dict[int, float]:
        """Of rooms and doors of one kind, those that the wish tells from the others: “the blue lounge”, 北口."""
        asked = self._attributes(stop.what, stop.language)
        if not asked:
            return dict(scores)
        told = {
            id_: told_apart(asked, attributes_of(self._by_id[id_].name)) if self._sorts.is_of_the_house(id_) else 0
            for id_ in scores
        }
        least = _COMPARABLE * max(scores.values(), default=0.0)
        best = max([0, *(told[id_] for id_, score in scores.items() if score >= least)])
        return {id_: score for id_, score in scores.items() if told[id_] >= best}

    def _wanted_attributes(self, what: str, language: str | None) -> frozenset[tuple[str, str]]:
        """What the words of a stop say of the place that it wants, not of what it refuses."""
        parts = parted(what, language or next(iter(self._asked.likely(what)), "en"))
        return attributes_of(what if parts is None else parts[0])

    def is_understood(self, stop: Stop) -> bool:
        """Whether a stop's words are words for a place at all, on this map or on another."""
        if stop.identity:
            return True
        meaning = read_question(stop.what, self._knowledge)
        is_name = any(ch.isupper() for ch in stop.what) and len(stop.what.split()) <= _SHORT_NAME
        return is_name or any(weight > 0.5 for _, weight in meaning.wanted)

    def _of_what(self, stop: Stop) -> tuple[int, ...]:
        """What comes next where an identity stands on no board: others of the same sort."""
        choice = self._choosing.ranked(stop.what).choice
        return tuple(id_ for id_ in (choice.landmark, *choice.alternatives) if id_ is not None)


def _best(scores: Mapping[int, float]) -> list[int]:
    """The landmarks that serve as well as any."""
    least = AS_WELL * max(scores.values(), default=0.0)
    return [id_ for id_, score in scores.items() if score >= least]
