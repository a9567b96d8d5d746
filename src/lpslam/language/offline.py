"""The embedded language model: tables, votes and rules; no key, no network, no download.

It knows kinds of place, brands, makers, warnings and everyday wants in seven languages. What it does not know it says,
and it rather chooses nothing than guesses.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from lpslam.language.knowledge import Known, load_knowledge, load_words
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading
from lpslam.language.naming import Vote, cased_like, painted_like, vote
from lpslam.language.question import Wish, instead_of, read_question, spoken_key
from lpslam.language.sanitise import clean_text
from lpslam.language.signs import SignMeaning, load_sign_reader
from lpslam.language.spelling import explanation_cost, respelled, weigh
from lpslam.language.words import is_unspaced

_YES = 0.5  # a sign is a kind when its words say so at least this surely
_CHOICE_FLOOR = 0.45  # a landmark that serves the wish less than this is not offered
_SPECIAL = 0.5  # a wanted concept of this weight is more than “food” or “a shop”
_NAME_GUESS = 0.55  # how sure we are that an unknown proper name in a mall is a shop
_SIDE_REFUSED = 0.5  # a place that also serves what is refused
# What a known name is ahead of an unknown one when readings are explained, a letter; less where none reads like it.
_ADVANCE_LETTER, _ADVANCE_IDEOGRAPH, _ADVANCE_WORD, _ADVANCE_UNREAD = 1.2, 3.0, 1.0, 0.5
_READINGS_WEIGHED = 24  # spellings, the commonest; what many readings explain, all do
_READINGS_LOOKED_UP = 8  # spellings whose known neighbours are tried


@dataclass(frozen=True, slots=True)
class _Served:
    """How well one landmark serves a wish: the whole score, and the best match of something asked for by name."""

    score: float
    best: float
    reasons: tuple[str, ...]


class OfflineModel:
    """The embedded `LanguageModel`."""

    def __init__(self) -> None:
        self._knowledge = load_knowledge()
        self._signs = load_sign_reader()

    @property
    def model(self) -> str:
        """Always "offline"."""
        return "offline"

    def name(self, readings: Sequence[Reading]) -> Naming:
        """Take the spelling that explains the readings best, known names being likelier than others (III-E)."""
        voted = vote(readings)
        if not voted.text:
            return Naming("", 0.0, "no reading has a character in it", self.model)
        fold = self._knowledge.folder
        weights = weigh((fold.key(each.text), each.count, each.confidence) for each in readings)
        letters_in_words = dict.fromkeys(weights, 0)
        for each in readings:
            if (own := fold.key(each.text)) in weights:
                letters = sum(len(word) for word in fold.fold(each.text).split() if word in load_words())
                letters_in_words[own] = max(letters_in_words[own], letters)
        own_words = sum(len(word) for word in fold.fold(voted.text).split() if word in load_words())
        respellings = {fold.key(text): text for text in respelled(fold.fold(voted.text), load_words())}
        for own, text in respellings.items():
            gained = sum(len(word) for word in text.split() if word in load_words()) - own_words
            letters_in_words.setdefault(own, int(own_words + _ADVANCE_UNREAD * gained))
        letters_in_words.setdefault(fold.key(voted.text), own_words)
        key, known = self._best_explanation(weights, letters_in_words, fold.key(voted.text))
        if known is None:
            if key in respellings and key not in weights and key != fold.key(voted.text):
                name, evidence = (
                    cased_like(respellings[key], voted.text),
                    "most readings are a slip away from these words",
                )
            else:
                name, evidence = self._painted(key, voted, readings), "letter by letter, most readings say so"
            return Naming(name, voted.agreement, evidence, self.model)
        if key == fold.key(voted.text):
            # Only spaces and punctuation may differ: a warning's words are set apart, a brand stays as it is painted.
            name = voted.text if known.source == "brand" else painted_like(known.painted, voted.text)
            return Naming(name, max(voted.agreement, 0.9), f"the readings agree on {known.painted}", self.model)
        name = self._painted(key, voted, readings) if key in weights else cased_like(known.painted, voted.text)
        return Naming(name, 0.7 * voted.agreement + 0.2, f"the readings are nearest to {known.painted}", self.model)

    def _best_explanation(
        self, weights: Mapping[str, float], letters_in_words: Mapping[str, int], voted: str
    ) -> tuple[str, Known | None]:
        """The key that explains the weighted readings at least cost, and the known name that it is."""
        looks = self._knowledge.folder.skeleton
        heaviest = sorted(weights.items(), key=lambda item: (-item[1], item[0]))[:_READINGS_WEIGHED]
        candidates: dict[str, Known | None] = dict.fromkeys([voted, *(key for key, _ in heaviest), *letters_in_words])
        for key in list(candidates)[:_READINGS_LOOKED_UP]:
            for _, known in self._signs.nearest(key) if key else []:
                candidates[self._knowledge.folder.key(known.painted)] = known
        seen = {looks(key) for key in weights}

        def cost(key: str) -> float:
            known = candidates[key]
            advance = 0.0
            if known is not None:
                letter = _ADVANCE_IDEOGRAPH if is_unspaced(key[0]) else _ADVANCE_LETTER
                advance = letter * len(key) * (1.0 if looks(key) in seen else _ADVANCE_UNREAD)
            else:
                advance = _ADVANCE_WORD * letters_in_words.get(key, 0)
            return explanation_cost(key, heaviest, looks) - advance

        # On a tie the vote stays.
        best = min(candidates, key=lambda key: (cost(key), key != voted, key))
        return best, candidates[best]

    def _painted(self, key: str, voted: Vote, readings: Sequence[Reading]) -> str:
        """The form with this key that was read most, or that the vote gave."""
        fold = self._knowledge.folder
        if fold.key(voted.text) == key:
            return voted.text
        same = [each for each in readings if fold.key(each.text) == key]
        return clean_text(max(same, key=lambda each: (each.count * each.confidence, each.text)).text)

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Say for each name apart whether its words make it what the question asks for (III-G)."""
        wish = read_question(question, self._knowledge)
        return [self._judge(name, question, wish) for name in names]

    def _judge(self, name: str, question: str, wish: Wish) -> Judgement:
        sign = self._signs.read(name)
        if not wish.wanted and not wish.refused:
            return Judgement(question, False, 0.0, "the question names no kind of place that is known", self.model)
        named = [(concept, weight) for concept, weight in wish.wanted if weight >= _SPECIAL] or list(wish.wanted)
        refused = any(self._is(concept, sign) >= _YES for concept in wish.refused)
        best = max((self._match(concept, sign) for concept, _ in named), default=1.0)
        if refused:
            return Judgement(question, False, 0.8, sign.evidence, self.model)
        general = any(concept in ("business", "shop", "place") for concept, _ in named)
        if best < _YES and general and sign.name_like and self._is("facility", sign) < _YES:
            return Judgement(question, True, _NAME_GUESS, sign.evidence, self.model)
        sure = best if best >= _YES else 1.0 - best if sign.kinds else 0.6
        return Judgement(question, best >= _YES, round(sure, 3), sign.evidence, self.model)

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Choose the landmark whose kinds serve the wish best; none rather than one that does not (III-I)."""
        signs = {landmark.id: self._sign_of(landmark) for landmark in landmarks}
        names = self._names(landmarks, signs)
        brands = self._signs.brands_in(clean_text(question))
        wish = read_question(question, self._knowledge, {**brands, **names})
        if wish.language is None:
            return Choice(None, 0.0, "the question is in no language that the embedded model reads", self.model)
        here = [mark.id for mark in landmarks if str(mark.id) not in wish.refused_names]
        named = [id_ for id_ in here if str(id_) in wish.wanted_names]
        if named:
            return Choice(named[0], 0.95, "the question names it", self.model, tuple(named[1:]))
        if not wish.wanted:
            wish = replace(
                wish, wanted=instead_of([*wish.refused, *self._kinds_of(wish.refused_names, signs)], self._knowledge)
            )
        wanted = dict(wish.wanted)
        if wish.wanted_names and not any(weight >= _SPECIAL for weight in wanted.values()):
            # A brand was asked for that is not here; another of its kind may do, but that is for the asker to say.
            return self._without_brand(wish.wanted_names[0], signs)
        if not wanted:
            return Choice(None, 0.0, "the question names nothing that a known kind of place offers", self.model)
        if set(wanted) == {"shop"}:
            return Choice(None, 0.5, "the question asks to buy something that is not known", self.model)
        return self._best(wish, {id_: signs[id_] for id_ in here})

    def _best(self, wish: Wish, signs: dict[int, SignMeaning]) -> Choice:
        served = {id_: self._serve(wish, sign) for id_, sign in signs.items()}
        ranked = sorted(served, key=lambda id_: (-served[id_].score, id_))
        asked = ", ".join(concept for concept, _ in wish.wanted)
        fitting = [id_ for id_ in ranked if served[id_].best >= _CHOICE_FLOOR]
        if not fitting:
            others = tuple(id_ for id_ in ranked if served[id_].score > 0.0)[:3]
            return Choice(None, 0.6, f"asked for {asked}: nothing on this map offers it", self.model, others)
        chosen = fitting[0]
        evidence = f"asked for {asked}; {signs[chosen].evidence} ({', '.join(served[chosen].reasons)})"
        return Choice(chosen, round(min(served[chosen].best, 0.99), 3), evidence, self.model, tuple(fitting[1:6]))

    def _kinds_of(self, names: Sequence[str], signs: dict[int, SignMeaning]) -> list[str]:
        """Kinds of the landmarks that were refused by name."""
        return [kind for id_, sign in signs.items() if str(id_) in names for kind, _ in sign.kinds]

    def _without_brand(self, identity: str, signs: dict[int, SignMeaning]) -> Choice:
        kinds = self._signs.read(identity).kinds
        likeness = {
            id_: max((weight * self._is(kind, sign) for kind, weight in kinds), default=0.0)
            for id_, sign in signs.items()
        }
        others = sorted((id_ for id_ in likeness if likeness[id_] >= _YES), key=lambda id_: (-likeness[id_], id_))
        return Choice(None, 0.8, f"{identity} is not on this map", self.model, tuple(others[:5]))

    def _sign_of(self, landmark: Candidate) -> SignMeaning:
        sign = self._signs.read(landmark.name)
        if sign.kinds:
            return sign
        # The name says nothing: another reading of the same sign may.
        for alias in landmark.aliases:
            other = self._signs.read(alias)
            if other.kinds:
                return other
        return sign

    def _names(self, landmarks: Sequence[Candidate], signs: dict[int, SignMeaning]) -> dict[str, str]:
        """Phrases by which a question may mention a landmark: its name, and other names of the same brand."""
        names: dict[str, str] = {}
        for landmark in landmarks:
            if not signs[landmark.id].is_place and signs[landmark.id].kinds:
                continue
            for text in (landmark.name, *self._other_names(signs[landmark.id])):
                phrase = self._signs.phrase(text)
                if spoken_key(phrase) and (signs[landmark.id].identity or phrase not in self._knowledge.painted):
                    names.setdefault(phrase, str(landmark.id))
        return names

    def _other_names(self, sign: SignMeaning) -> Sequence[str]:
        return self._signs.names_of(sign.identity) if sign.identity else ()

    def _serve(self, wish: Wish, sign: SignMeaning) -> _Served:
        matches = {concept: self._match(concept, sign) for concept, _ in wish.wanted}
        score = sum(weight * matches[concept] for concept, weight in wish.wanted)
        special = [concept for concept, weight in wish.wanted if weight >= _SPECIAL]
        best = max((matches[concept] for concept in special or matches), default=0.0)
        for concept in wish.refused:
            own = self._is(concept, sign)
            if own >= 0.4 and not self._is_also_another(concept, own, sign):
                return _Served(0.0, 0.0, ())
            if own >= 0.4 or self._match(concept, sign) >= 0.7:
                score *= _SIDE_REFUSED
        reasons = tuple(concept for concept, match in matches.items() if match >= _CHOICE_FLOOR)
        return _Served(score, best, reasons)

    def _is(self, concept: str, sign: SignMeaning) -> float:
        """How surely the sign is the concept itself or a kind of it."""
        return max((weight for kind, weight in sign.kinds if concept in self._knowledge.above(kind)), default=0.0)

    def _is_also_another(self, concept: str, weight: float, sign: SignMeaning) -> bool:
        """Whether the place is as surely another kind beside the refused one (pizza and burgers)."""
        top = concept.partition("/")[0]
        return any(
            other >= weight and kind.partition("/")[0] == top and concept not in self._knowledge.above(kind)
            for kind, other in sign.kinds
        )

    def _match(self, concept: str, sign: SignMeaning) -> float:
        """How well the place behind the sign serves the concept: it is one, or it offers it."""
        return max((weight * self._knowledge.share(concept, kind) for kind, weight in sign.kinds), default=0.0)
