"""Asking the embedded model in tests."""

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel


def chosen(model: OfflineModel, question: str, *names: str) -> str | None:
    """The name of the landmark that is chosen among some."""
    answer = model.choose(question, [Candidate(at, name) for at, name in enumerate(names)])
    return None if answer.landmark is None else names[answer.landmark]
