"""What a question is about, by the pieces of its words: for turns of phrase that no table lists.

Every phrase of a language's tables is cut into pieces of letters, weighed by how few concepts share them (tf-idf), and
a question is compared with the concepts by the pieces of its words: “the battery of the forklift is flat” is nearest
to where forklifts are charged. It is a guess, made where reading finds nothing, and only where nothing else comes near.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from lpslam.language.building import building
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.words import is_mark, is_unspaced, longest_phrases

_PIECES = (4, 5)  # letters of the pieces of a word, with its ends
_PIECE = 0.5  # what a piece weighs of a whole short word
_SHORTEST = 3  # letters of a word that says something
_CLEAR, _CLEARER = 0.5, 1.0  # least score where no table reads anything, and where one reads what is not to be had
_AS_WELL, _NEARLY = 0.9, 0.7  # of the best score: meant as well; so near that it may be meant instead


class Cues:
    """The concepts of one language by the pieces of the words that are used for them."""

    def __init__(self, language: str, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._common = knowledge.common[language]
        self._tables = knowledge.tables_of(language)
        said: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
        unsaid = knowledge.general | knowledge.modifiers
        for phrase, meaning in knowledge.spoken(language).items():
            if meaning.role != "means":
                continue
            pieces = self._pieces(phrase.split(" "))
            size = math.sqrt(sum(weight * weight for weight in pieces.values())) or 1.0
            for concept, _ in meaning.concepts:
                if concept not in unsaid:
                    for piece, weight in pieces.items():
                        said[concept][piece] += weight / size
        shared = Counter(piece for pieces in said.values() for piece in pieces)
        self._unheard = math.log(max(len(said), 2))
        self._rare = {piece: self._unheard - math.log(count) for piece, count in shared.items()}
        self._by_piece: dict[str, list[tuple[str, float]]] = defaultdict(list)
        for concept, heard in said.items():
            weights = {piece: math.log1p(count) * self._rare[piece] for piece, count in heard.items()}
            # Softened: a concept of many phrases is not the less likely for them.
            size = math.sqrt(math.sqrt(sum(weight * weight for weight in weights.values()))) or 1.0
            for piece, weight in weights.items():
                self._by_piece[piece].append((concept, weight / size))

    def _pieces(self, units: Iterable[str]) -> dict[str, float]:
        """The pieces of words that say something: of scripts without spaces every two characters."""
        found: dict[str, float] = defaultdict(float)
        run = ""
        for unit in (*units, ""):
            if unit and is_unspaced(unit):
                run += unit
                continue
            for at in range(len(run) - 1):
                found[run[at : at + 2]] += 1.0
            run = ""
            if len(unit) < _SHORTEST or is_mark(unit) or unit in self._common:
                continue
            word = f"^{unit}$"
            if len(word) <= _PIECES[-1]:
                found[word] += 1.0
                continue
            for size in _PIECES:
                for at in range(len(word) - size + 1):
                    found[word[at : at + size]] += _PIECE
        return found

    def scores(self, units: Sequence[str]) -> Mapping[str, float]:
        """Return by concept how near it is to the words of a question."""
        pieces = self._pieces(units)
        size = math.sqrt(sum((weight * self._rare.get(piece, self._unheard)) ** 2 for piece, weight in pieces.items()))
        found: dict[str, float] = defaultdict(float)
        for piece, weight in pieces.items():
            for concept, said in self._by_piece.get(piece, ()):
                found[concept] += weight * self._rare[piece] * said / size
        return found

    def guessed(self, question: str, is_read: bool) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Return the concepts that a question is about, if that is clear, the nearest first; and those that come next.

        What is read in full by the tables (`is_read`: they found something) is not guessed at.
        """
        units = self._knowledge.folder.units(question)
        if is_read and not self._says_more(units):
            return (), ()
        scores = self.scores(units)
        top = max(scores.values(), default=0.0)
        if top < (_CLEARER if is_read else _CLEAR):
            return (), ()
        meant = tuple(
            sorted((each for each in scores if scores[each] >= _AS_WELL * top), key=lambda each: -scores[each])
        )
        near = tuple(sorted(concept for concept, score in scores.items() if _AS_WELL * top > score >= _NEARLY * top))
        return meant, near

    def _says_more(self, units: Sequence[str]) -> bool:
        """Whether a question has words, beside those that the tables know, that say something."""
        covered = {at for span in longest_phrases(units, self._tables) for at in range(span.start, span.end)}
        return any(
            at not in covered and not is_mark(unit) and unit not in self._common for at, unit in enumerate(units)
        )


@lru_cache(maxsize=8)
def cues_of(language: str, knowledge: Knowledge) -> Cues:
    """Return the cues of a language, made when they are first asked for."""
    with building():
        return Cues(language, knowledge)
