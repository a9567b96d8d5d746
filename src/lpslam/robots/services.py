"""The services `ask` and `goal`: questions answered by the map as it grows, and where a robot stands for them."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lpslam.config import Config
from lpslam.errors import LpSlamError, UserError
from lpslam.ground.grid import Grid
from lpslam.language.model import LanguageModel
from lpslam.language.sanitise import clean_text
from lpslam.navigation.walking.routes import route_through
from lpslam.navigation.walking.ways import NoWayError, Walkable
from lpslam.robots import building, types
from lpslam.robots.types import made
from lpslam.session.session import Session
from lpslam.text.types import Landmark
from lpslam.views.answers import answer_text

NOBODY = -1
"""Id of no landmark."""


@dataclass(frozen=True, slots=True)
class Moment:
    """When and in which frame of reference something is answered."""

    nanoseconds: int
    frame: str


class Services:
    """Answers `ask` and `goal`; an error is an answer too.

    Args:
        session: the map; None while there is none.
        ground: gives the newest grid, or None.
        config: the robot, and how much is read of a question.
        language: chooses; the embedded model without.
        moment: now.
        on_goal: called with the `PoseStamped` and the `Path` of every goal that is found.
    """

    def __init__(
        self,
        session: Callable[[], Session | None],
        ground: Callable[[], Grid | None],
        config: Config,
        language: LanguageModel | None,
        moment: Callable[[], Moment],
        on_goal: Callable[[Any, Any], None],
    ) -> None:
        self._session, self._ground, self._moment = session, ground, moment
        self._config, self._language, self._on_goal = config, language, on_goal
        self._walkable: tuple[Grid, Walkable] | None = None
        self._making = threading.Lock()

    def ask(self, request: Any) -> Any:
        """An `Ask_Response` to an `Ask_Request`."""
        kind, nowhere = types.response_of(types.ASK), building.point(np.zeros(3))
        try:
            mark, text, distance, sure = self._found(str(request.question))
        except LpSlamError as error:
            return made(kind, False, str(error), NOBODY, "", nowhere, 0.0, 0.0)
        if mark is None:
            return made(kind, False, text, NOBODY, "", nowhere, 0.0, 0.0)
        place = building.point(mark.position)
        return made(kind, True, text, mark.id, clean_text(mark.name), place, distance, sure)

    def goal(self, request: Any) -> Any:
        """A `Goal_Response` to a `Goal_Request`."""
        kind, moment = types.response_of(types.GOAL), self._moment()
        where = moment.nanoseconds, moment.frame
        pose, path = building.standing(0.0, 0.0, 0.0, *where), building.path(np.zeros((0, 2)), *where)
        try:
            mark = self._wanted(request)
            (leg,) = route_through(self._here(), [mark], self._ground_to_walk_on())
        except LpSlamError as error:
            return made(kind, False, str(error), NOBODY, False, 0.0, pose, path)
        goal = leg.goal
        at, yaw = goal.position, goal.yaw
        pose = building.standing(float(at[0]), float(at[1]), yaw, *where)
        path = building.path(leg.way.points, *where, yaw)
        self._on_goal(pose, path)
        return made(kind, True, clean_text(mark.name), mark.id, goal.is_before, goal.missing, pose, path)

    def _open(self) -> Session:
        session = self._session()
        if session is None:
            raise UserError("there is no map yet: no frame has come")
        return session

    def _found(self, question: str) -> tuple[Landmark | None, str, float, float]:
        longest = self._config.robots.question_letters
        if len(question) > longest:
            raise UserError(f"the question has {len(question):,} letters; give {longest:,} at most")
        answer = self._open().ask(question, language=self._language)
        return answer.landmark, answer_text(answer), answer.distance or 0.0, answer.choice.confidence

    def _wanted(self, request: Any) -> Landmark:
        if str(request.question).strip():
            mark, text, _, _ = self._found(str(request.question))
            if mark is None:
                raise UserError(text)
            return mark
        wanted = int(request.landmark_id)
        for mark in self._open().landmarks():
            if mark.id == wanted:
                return mark
        raise UserError(f"the map has no landmark {wanted}; ask for it by a question")

    def _here(self) -> Any:
        pose = self._open().pose
        if pose is None:
            raise NoWayError("where the camera is is not known now; go to where something was mapped")
        return pose[:2, 3]

    def _ground_to_walk_on(self) -> Walkable:
        grid = self._ground()
        if grid is None:
            raise NoWayError("no floor was seen yet; point the camera so that the floor is in view")
        with self._making:
            if self._walkable is None or self._walkable[0] is not grid:
                self._walkable = grid, Walkable(grid, self._config.ways)
            return self._walkable[1]
