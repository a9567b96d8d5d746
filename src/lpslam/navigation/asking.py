"""Navigation: a question in any language → the landmark that serves it (paper, Fig. 1)."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config
from lpslam.errors import UserError
from lpslam.language.model import Choice, LanguageModel
from lpslam.language.offline import embedded_model
from lpslam.language.sanitise import clean_text
from lpslam.language.wishes.form import Wish
from lpslam.navigation.answering import answer_wish
from lpslam.navigation.directory import Directory
from lpslam.navigation.known import directory_of
from lpslam.navigation.places import Here
from lpslam.text.types import Landmark

if TYPE_CHECKING:
    from lpslam.mapfile.language_map import LanguageMap


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Where to go, and why.

    Attributes:
        question: as asked.
        landmark: the place; None when nothing in the map serves.
        distance: metres from where the question was asked; None without a landmark.
        choice: what the language model said.
        alternatives: next best, best first.
        here: (3,) map frame, where the question was asked.
        heading: radians counter-clockwise from the map's x axis, which way the asker looks; None where that is unknown.
        same_name: places of the landmark's name, of which it is the nearest where nothing else is asked for.
        wish: what was understood.
        stops: the places of a plan in order, `landmark` being the last; None for a stop that nothing serves.
    """

    question: str
    landmark: Landmark | None
    distance: float | None
    choice: Choice
    alternatives: tuple[Landmark, ...] = ()
    here: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    heading: float | None = None
    same_name: int = 0
    wish: Wish = field(default_factory=lambda: Wish(()))
    stops: tuple[Landmark | None, ...] = ()

    def distance_to(self, landmark: Landmark) -> float:
        """Metres from where the question was asked."""
        return float(np.linalg.norm(landmark.position - self.here))

    def direction_to(self, landmark: Landmark) -> float:
        """Degrees counter-clockwise, in [0, 360), from where the asker looks or, unknown, from the map's x axis."""
        x, y, _ = landmark.position - self.here
        return float(np.degrees(np.arctan2(y, x) - (self.heading or 0.0)) % 360.0)


def ask(
    world: "LanguageMap",
    question: str,
    *,
    language: LanguageModel | None = None,
    position: NDArray[np.float64] | None = None,
    heading: float | None = None,
    excluded: Collection[int] = (),
    history: Sequence[tuple[str, str]] = (),
    config: Config | None = None,
) -> Answer:
    """Navigation: a question in any language → the landmark that serves it, with its position.

    Args:
        world: the map.
        question: what is wanted.
        language: chooses among the names; the embedded model without. It never sees a position.
        position: (3,) map frame, where the question is asked, or (2,) at the camera's last height; without, where the
            camera was last.
        heading: radians counter-clockwise from the map's x axis, which way the asker looks; without either, as the
            camera looked last.
        excluded: ids of landmarks that are no answer, having been named before.
        history: (question, answer) of the dialogue so far, the oldest first; only a model that converses takes it.
        config: thresholds; the defaults without.

    Raises:
        UserError: the question is empty.
    """
    directory, view = directory_of(world, config.navigation if config is not None else None)
    return answer(question, directory, view, language, position, heading, excluded, history)


def answer(
    question: str,
    landmarks: Sequence[Landmark] | Directory,
    view: tuple[NDArray[np.float64], float],
    language: LanguageModel | None,
    position: NDArray[np.float64] | None,
    heading: float | None,
    excluded: Collection[int] = (),
    history: Sequence[tuple[str, str]] = (),
    wish: Wish | None = None,
) -> Answer:
    """As `ask`, of a map whose landmarks and last view are in hand.

    Args:
        question: what is wanted.
        landmarks: of the map; a `Directory` of them, where many questions are asked.
        view: where the camera was last, (3,) map frame, and its heading in radians.
        language, position, heading, excluded, history: as in `ask`.
        wish: what the question means, where somebody has said that.

    Raises:
        UserError: the question is empty.
    """
    if not clean_text(question):
        raise UserError("the question is empty; ask for a place, as in: Where can I eat pizza?")
    known = (landmarks if isinstance(landmarks, Directory) else Directory(landmarks)).without(excluded)
    here, looked = view
    if position is None:
        heading = looked if heading is None else heading
    else:
        here = np.concatenate([position, here[len(position) :]])
    solution = answer_wish(question, known, language or embedded_model(), Here(here, heading), None, history, wish)
    by_id = known.by_id
    last = solution.stops[-1]
    chosen = by_id[last.place.id] if last.place is not None else None
    evidence = "; ".join(filter(None, dict.fromkeys((last.evidence, *solution.notes))))
    others = tuple(by_id[place.id] for place in last.others)
    choice = Choice(
        None if chosen is None else chosen.id, last.confidence, evidence, last.model, tuple(mark.id for mark in others)
    )
    stops = tuple(by_id[stop.place.id] if stop.place is not None else None for stop in solution.stops)
    if chosen is None:
        return Answer(question, None, None, choice, others, here, heading, wish=solution.wish, stops=stops)
    distance = float(np.linalg.norm(chosen.position - here))
    return Answer(
        question, chosen, distance, choice, others, here, heading, known.names[chosen.name], solution.wish, stops
    )
