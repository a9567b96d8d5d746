"""The embedded language model: tables, votes and rules; no key, no network, no download.

It knows kinds of place, brands, makers, warnings and everyday wants in seven languages. What it does not know it says,
and it rather chooses nothing than guesses.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache

from lpslam.language.choosing.choosing import Choosing
from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import best_of, likeness, match
from lpslam.language.kept import building, steps_of
from lpslam.language.languages import LANGUAGES
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading
from lpslam.language.naming.namer import Namer
from lpslam.language.questions.question import read_question
from lpslam.language.questions.wanted import Wish
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.wishes.form import Stop
from lpslam.language.wishes.form import Wish as WishForm
from lpslam.language.wishes.reading import read_wish
from lpslam.language.wishes.rules import rules_of
from lpslam.language.wishes.scoring import EmbeddedScorer
from lpslam.language.wishes.served import Way

CANNOT_JUDGE = (
    "I cannot judge this: the question names no kind of place that is known; "
    "ask for a kind of place (“Is this a restaurant?”), or with another model (--llm)"
)
_MAPS_KEPT = 4  # sets of landmarks whose tables are kept: those of the maps that are asked in turn
_WORDS_SPEAK = 0.55  # how sure the words of a question make us where no table reads it
_YES = 0.5  # a sign is a kind when its words say so at least this surely
_NAME_GUESS = 0.55  # how sure we are that an unknown proper name in a mall is a shop


class OfflineModel:
    """The embedded `LanguageModel`."""

    def __init__(self) -> None:
        with building():
            self._knowledge = load_knowledge()
            self._signs = load_sign_reader()
        self.namer = Namer(self._knowledge, self._signs)
        self._indices: tuple[LandmarkIndex, ...] = ()
        self._scorer_of = lru_cache(maxsize=_MAPS_KEPT)(self._scorer)

    @property
    def model(self) -> str:
        """Always "offline"."""
        return "offline"

    def name(self, readings: Sequence[Reading]) -> Naming:
        """Take the string that explains the readings best, known names being likelier than others (III-E)."""
        return self.namer.name(readings, self.model)

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Say for each name apart whether its words make it what the question asks for (III-G)."""
        wish = read_question(question, self._knowledge)
        return [self._judge(name, question, wish) for name in names]

    def _judge(self, name: str, question: str, wish: Wish) -> Judgement:
        sign = self._signs.read(name)
        if not wish.wanted and not wish.refused:
            return Judgement(question, False, 0.0, CANNOT_JUDGE, self.model)
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
        choice = Choosing(self.index(landmarks), self._signs, self._knowledge, self.model).ranked(question).choice
        if choice.landmark is not None or not landmarks:
            return choice
        # Where the tables find nothing, the words of the question may speak for one all the same.
        served = self.scorer(landmarks).serve(Stop(clean_text(question)))
        is_doubted = served.sure < LEAST_SURE * served.strictness
        if served.way is not Way.GUESS or is_doubted or not served.scores:
            return choice
        best = best_of(served.scores)
        return replace(choice, landmark=best, evidence=served.evidence, confidence=min(served.confidence, _WORDS_SPEAK))

    def read_wish(self, question: str) -> WishForm:
        """Return what a question means, as a form that the map answers."""
        return read_wish(question, self._knowledge)

    def scorer(self, landmarks: Sequence[Candidate]) -> EmbeddedScorer:
        """Return what says which of the landmarks serve a stop of a wish; kept for the next question about them."""
        return self._scorer_of(self.index(landmarks))

    def _scorer(self, index: LandmarkIndex) -> EmbeddedScorer:
        with building():
            return EmbeddedScorer(index.landmarks, index, self._signs, self._knowledge)

    def preparations(self, landmarks: Sequence[Candidate]) -> Iterator[None]:
        """Build, a little at a time, what questions about some landmarks would build when they first need it."""
        for language in LANGUAGES:
            for row in rules_of(language).rows:
                row.prepare()
                yield
            for is_plain in (False, True):
                yield from steps_of(self._knowledge.tables_of(language, is_plain))
        yield from self.scorer(landmarks).steps()

    def index(self, landmarks: Sequence[Candidate]) -> LandmarkIndex:
        """Return the landmarks as they are looked up; kept for the next question about the same ones."""
        for index in self._indices:
            if index.is_of(landmarks):
                return index
        with building():
            index = LandmarkIndex(landmarks, self._signs, self._knowledge)
        # Replaced, never changed: other threads may be going through them.
        self._indices = (index, *self._indices)[:_MAPS_KEPT]
        return index


@lru_cache(maxsize=1)
def embedded_model() -> OfflineModel:
    """Return the embedded model that reads wishes for others, made once a process."""
    return OfflineModel()
