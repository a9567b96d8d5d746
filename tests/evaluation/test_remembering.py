"""When signs are remembered, and what reading costs, on made-up memories whose every answer is known."""

import numpy as np
import pytest

from lpslam.config import EvaluationConfig
from lpslam.evaluation.remembering import reading_cost, remembering_delays
from lpslam.evaluation.signs import TrueSign
from lpslam.text.remembering.memory import Pool, TextClass
from lpslam.text.types import Placement, TextObservation

KEYFRAME = np.eye(4)
KEYFRAME[:3, 3] = [10.0, 0.0, 0.0]
THRESHOLDS = EvaluationConfig()


def sighting(text: str, seconds: float, x: float, keyframe: int = 0) -> TextObservation:
    placement = Placement((x - 10.0, 0.0, 2.0), (0.0, -1.0, 0.0), (1.0, 0.0, 0.0), 1.0, 0.2, 0.01)
    return TextObservation(int(30 * seconds), seconds, keyframe, text, 0.9, placement, 20.0)


def remembered(promoted_at: float | None, *observations: TextObservation) -> TextClass:
    return TextClass(0, 0.0, 9.0, pool=Pool.LONG_TERM, promoted_at=promoted_at, observations=list(observations))


def sign(identifier: int, text: str, x: float, seconds: float | None, frames: int = 20) -> TrueSign:
    return TrueSign(identifier, text, (), "shop", (x, 0.0, 2.0), None, frames, readable_from=seconds)


def delays(classes: list[TextClass], signs: list[TrueSign]) -> dict[int | str, float | None]:
    return remembering_delays(classes, {0: KEYFRAME}.get, signs, np.eye(4), THRESHOLDS)


def test_a_sign_is_remembered_when_its_class_is() -> None:
    exits = remembered(2.5, sighting("EXlT", 2.0, 0.1), sighting("EXIT", 2.2, 0.0), sighting("EXIT", 2.5, 0.0))
    assert delays([exits], [sign(0, "EXIT", 0.0, 1.9)]) == {0: pytest.approx(0.6)}
    # Readable by definition only later: no delay is worse than having read it.
    assert delays([exits], [sign(0, "EXIT", 0.0, 3.0)]) == {0: pytest.approx(-0.5)}


def test_a_second_sign_of_a_known_class_is_remembered_when_it_is_seen() -> None:
    exits = remembered(2.5, sighting("EXIT", 2.2, 0.0), sighting("EXIT", 2.5, 0.0), sighting("EXIT", 7.0, 15.0))
    found = delays([exits], [sign(0, "EXIT", 0.0, 2.0), sign(1, "EXIT", 15.0, 6.5), sign(2, "EXIT", 5.0, 4.0)])
    assert found == {0: pytest.approx(0.5), 1: pytest.approx(0.5), 2: None}


def test_what_is_read_wrongly_elsewhere_or_from_nowhere_does_not_count() -> None:
    wrong = remembered(1.0, sighting("TAXI", 1.0, 0.0), sighting("EXIT", 1.0, 1.2), sighting("EXIT", 1.0, 0.0, 1))
    assert delays([wrong], [sign(0, "EXIT", 0.0, 0.5)]) == {0: None}
    assert delays([remembered(1.0)], [sign(0, "EXIT", 0.0, 0.5)]) == {0: None}
    # Nothing is expected of signs that were readable too briefly, or of which that is not known.
    assert delays([wrong], [sign(0, "TAXI", 0.0, 0.5, frames=9), sign(1, "TAXI", 0.0, None)]) == {}


def test_cost_is_told_by_the_minute() -> None:
    statistics = {
        "frames_read": 40, "texts_read": 60, "texts_rejected": 15, "reader_processor_ms": 5500.0,
        "mapping_ms": 900.0,
    }  # fmt: skip
    cost = reading_cost(statistics, 20.0)
    assert cost is not None
    assert (cost.detections_a_minute, cost.recognitions_a_minute) == (120.0, 225.0)
    assert cost.reader_seconds_a_minute == pytest.approx(16.5)
    assert reading_cost({}, 20.0) is None
