"""Which landmarks serve a stop's words, as any model but the embedded one says."""

from collections.abc import Sequence

from lpslam.language.model import Candidate, Choice, Chooser, Converses, LanguageModel
from lpslam.language.signs.distrust import choose_trusted
from lpslam.language.wishes.form import Stop, Wish
from lpslam.language.wishes.served import Served


class _After:
    """A model that converses, in the middle of a dialogue."""

    def __init__(self, model: Converses, history: Sequence[tuple[str, str]]) -> None:
        self._model, self._history = model, history

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Choose after what was asked and answered before."""
        return self._model.choose_after(self._history, question, landmarks)


class ModelScorer:
    """Any other model: it names a landmark and the next best, for the words of a stop.

    A wish of one stop that says nothing of where it stands is put to the model as it was asked.
    """

    def __init__(
        self,
        model: LanguageModel,
        landmarks: Sequence[Candidate],
        question: str,
        wish: Wish,
        history: Sequence[tuple[str, str]] = (),
    ) -> None:
        self._model = model
        self._chooser: Chooser = _After(model, history) if history and isinstance(model, Converses) else model
        self._landmarks = landmarks
        is_plain = len(wish.stops) == 1 and wish.stops[0].relation is None and wish.stops[0].what
        self._whole = question if is_plain else None

    @property
    def model(self) -> str:
        """Which model answers."""
        return self._model.model

    def is_understood(self, stop: Stop) -> bool:
        """A model that finds none has understood."""
        return True

    def serve(self, stop: Stop) -> Served:
        """Ask the model for the landmark that serves a stop's words."""
        if not stop.what:
            return Served(stop, dict.fromkeys([mark.id for mark in self._landmarks], 1.0), "any place", 0.9)
        choice = choose_trusted(self._chooser, self._whole or stop.what, self._landmarks)
        ids = {mark.id for mark in self._landmarks}
        if choice.landmark is None or choice.landmark not in ids:
            others = tuple(id_ for id_ in choice.alternatives if id_ in ids)
            missing = "" if choice.landmark is None else f" (no such landmark: {choice.landmark})"
            return Served(stop, {}, choice.evidence + missing, choice.confidence, others, model=choice.model)
        name = next(mark.name for mark in self._landmarks if mark.id == choice.landmark)
        scores = {mark.id: 1.0 for mark in self._landmarks if mark.name == name}
        others = tuple(id_ for id_ in choice.alternatives if id_ in ids and id_ not in scores)
        return Served(stop, scores, choice.evidence, choice.confidence, others, (), False, choice.model)
