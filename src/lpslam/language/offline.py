"""The embedded language model: tables, votes and rules; no key, no network, no download.

It knows kinds of place, brands, makers, warnings and everyday wants in seven languages. What it does not know it says,
and it rather chooses nothing than guesses.
"""

from collections.abc import Mapping, Sequence

from lpslam.language.building import building
from lpslam.language.choosing import choose
from lpslam.language.knowledge import Known, load_knowledge, load_words
from lpslam.language.landmark_index import LandmarkIndex
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading
from lpslam.language.naming import Vote, cased_like, painted_like, vote
from lpslam.language.question import Wish, read_question
from lpslam.language.sanitise import clean_text
from lpslam.language.serving import likeness, match
from lpslam.language.signs import load_sign_reader
from lpslam.language.spelling import explanation_cost, respelled, weigh
from lpslam.language.words import is_unspaced

_YES = 0.5  # a sign is a kind when its words say so at least this surely
_NAME_GUESS = 0.55  # how sure we are that an unknown proper name in a mall is a shop
# What a known name is ahead of an unknown one when readings are explained, a letter; less where none reads like it.
_ADVANCE_LETTER, _ADVANCE_IDEOGRAPH, _ADVANCE_WORD, _ADVANCE_UNREAD = 1.2, 3.0, 1.0, 0.5
_READINGS_WEIGHED = 24  # spellings, the commonest; what many readings explain, all do
_READINGS_LOOKED_UP = 8  # spellings whose known neighbours are tried


class OfflineModel:
    """The embedded `LanguageModel`."""

    def __init__(self) -> None:
        with building():
            self._knowledge = load_knowledge()
            self._signs = load_sign_reader()
        self._index: LandmarkIndex | None = None

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
            # Only spaces and punctuation may differ: a warning's words are set apart, a brand stays as it is painted;
            # a mark that it has, and that was read even once, was there.
            marked = [each.text for each in readings if each.text.casefold() == known.painted.casefold()]
            name = (marked or [voted.text])[0] if known.source == "brand" else painted_like(known.painted, voted.text)
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
        # “必胜客欢乐餐厅” is no listed name, but begins with one.
        heads = {key: self._signs.brand_head(key) for key in candidates}

        def cost(key: str) -> float:
            known = candidates[key]
            letter = _ADVANCE_IDEOGRAPH if is_unspaced(key) else _ADVANCE_LETTER
            if known is not None:
                advance = letter * len(key) * (1.0 if looks(key) in seen else _ADVANCE_UNREAD)
            else:
                advance = _ADVANCE_WORD * letters_in_words.get(key, 0) + _ADVANCE_UNREAD * letter * heads[key]
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
        # “A place to eat” asks for more than a place, “the sign of a restroom” for more than a sign.
        asked = [concept for concept in wish.main if concept not in ("place", "sign")] or wish.main
        refused = any(likeness(concept, sign.kinds, self._knowledge) >= _YES for concept in wish.refused)
        best = max((match(concept, sign.kinds, self._knowledge) for concept in asked), default=1.0)
        if refused:
            return Judgement(question, False, 0.8, sign.evidence, self.model)
        general = any(concept in ("business", "shop", "place") for concept in asked)
        if best < _YES and general and sign.name_like and likeness("facility", sign.kinds, self._knowledge) < _YES:
            return Judgement(question, True, _NAME_GUESS, sign.evidence, self.model)
        sure = best if best >= _YES else 1.0 - best if sign.kinds else 0.6
        return Judgement(question, best >= _YES, round(sure, 3), sign.evidence, self.model)

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Choose the landmark whose kinds serve the wish best; none rather than one that does not (III-I)."""
        return choose(question, self.index(landmarks), self._signs, self._knowledge, self.model)

    def index(self, landmarks: Sequence[Candidate]) -> LandmarkIndex:
        """Return the landmarks as they are looked up; kept for the next question about the same ones."""
        if self._index is None or not self._index.is_of(landmarks):
            with building():
                self._index = LandmarkIndex(landmarks, self._signs, self._knowledge)
        return self._index
