"""What the command line says of the ground: where to stand before an answer, how to go, and robots' own files."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from lpslam.config import Config
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import Answer
from lpslam.navigation.walking.storeys import Building
from lpslam.navigation.walking.ways import NoWayError


class Guide:
    """Tells the way to answers of one map; its ground is made when it is asked for first.

    Args:
        world: the map.
        config: the robot, and how the ground is seen.
    """

    def __init__(self, world: LanguageMap, config: Config) -> None:
        self._world, self._config = world, config
        self._building: Building | None = None

    def record(self, answer: Answer) -> dict[str, Any]:
        """The way as JSON can hold it, or why there is none."""
        from lpslam.navigation.walking.routes import route

        try:
            legs = route(answer, self._ground())
        except NoWayError as error:
            return {"route": None, "no_route": str(error)}
        return {
            "route": [
                {
                    "landmark": leg.landmark.id,
                    "goal": {
                        "x": round(float(leg.goal.position[0]), 3),
                        "y": round(float(leg.goal.position[1]), 3),
                        "yaw": round(leg.goal.yaw, 4),
                        "is_before_the_sign": leg.goal.is_before,
                        "missing_m": round(leg.goal.missing, 2),
                        "why_short": leg.goal.why or None,
                    },
                    "length_m": round(leg.way.length, 2),
                    "seconds": round(leg.way.seconds, 1),
                    "points": [[round(float(x), 3), round(float(y), 3)] for x, y in leg.way.points],
                    "climbs": [[climb.first, climb.last, climb.storeys] for climb in leg.way.climbs],
                    "steps": steps,
                }
                for leg, steps in zip(legs, self._steps(answer, legs), strict=True)
            ]
        }

    def said(self, answer: Answer) -> str:
        """The way in words, in the question's language, or why there is none."""
        from lpslam.language.questions.phrasing import answer_language
        from lpslam.navigation.walking.routes import route
        from lpslam.navigation.walking.telling import length_told
        from lpslam.views.drawable import printable

        if answer.landmark is None:
            return ""
        try:
            legs = route(answer, self._ground())
        except NoWayError as error:
            return f"  no way: {error}"
        language, lines = answer_language(answer.question), []
        for leg, steps in zip(legs, self._steps(answer, legs), strict=True):
            x, y = leg.goal.position
            lines.append(f"  → ({x:.2f}, {y:.2f}, {leg.goal.yaw:.2f} rad); {length_told(leg.way, language)}")
            if not leg.goal.is_before:
                lines.append(
                    f"    {leg.goal.missing:.1f} m short of it, the nearest that can be reached: {leg.goal.why}"
                )
            lines += [f"    {number}. {printable(step)}" for number, step in enumerate(steps, 1)]
        return "\n".join(lines)

    def ready_to_export(self, question: str | None = None) -> Callable[[Path], list[Path]]:
        """What writes the ground into a folder in robots' own formats, with the way to the answer of a question if
        there is one, and returns the files.

        Raises:
            UserError: the map has no ground, or nothing serves.
        """
        from lpslam.language.offline import embedded_model
        from lpslam.navigation.asking import ask
        from lpslam.navigation.walking.exporting import export_storeys
        from lpslam.navigation.walking.routes import route

        building, landmarks, legs = self._ground(), self._world.landmarks(), []
        if question is not None:
            answer = ask(self._world, question)
            # A robot is not sent over stairs.
            legs = route(answer, building.ground_at(answer.here))
        judged = embedded_model().judge([mark.name for mark in landmarks], _WARNING)
        warnings = [mark for mark, judgement in zip(landmarks, judged, strict=True) if judgement.answer]
        return lambda folder: export_storeys(folder, building, landmarks, warnings, legs)

    def _steps(self, answer: Answer, legs: Any) -> list[list[str]]:
        from lpslam.language.questions.phrasing import answer_language
        from lpslam.navigation.walking.routes import told_legs

        return told_legs(legs, self._world.landmarks(), answer_language(answer.question), answer.heading)

    def _ground(self) -> Building:
        from lpslam.navigation.walking.routes import building_of
        from lpslam.views.run_progress import saying_what_is_compiled

        if self._building is None:
            with saying_what_is_compiled():
                self._building = building_of(self._world, self._config)
        return self._building


_WARNING = "Is this a warning?"
"""What is asked of every sign for the mask of places to keep out of."""
