"""Asking the embedded model in tests."""

from collections.abc import Sequence

import numpy as np

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import solve


def chosen(model: OfflineModel, question: str, *names: str) -> str | None:
    """The name of the landmark that is chosen among some."""
    answer = model.choose(question, [Candidate(at, name) for at, name in enumerate(names)])
    return None if answer.landmark is None else names[answer.landmark]


def solved(model: OfflineModel, question: str, boards: Sequence[Sequence[str]]) -> list[str | None]:
    """The name of the board that each stop of a wish leads to; boards, by their lines, stand four metres apart."""
    places = [Place(at, board[0], np.array([4.0 * at, 0.0, 0.0]), None) for at, board in enumerate(boards)]
    marks = [Candidate(at, board[0], (), tuple(board[1:])) for at, board in enumerate(boards)]
    stops = solve(model.read_wish(question), places, model.scorer(marks), Here(np.zeros(3))).stops
    return [None if stop.place is None else stop.place.name for stop in stops]
