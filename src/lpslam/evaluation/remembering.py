"""How soon a sign is remembered, and what reading costs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.config import EvaluationConfig
from lpslam.evaluation.signs import TrueSign
from lpslam.text.remembering.memory import TextClass
from lpslam.text.remembering.similarity import comparison_key, similarity

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ReadingCost:
    """What reading a recording cost.

    Attributes:
        seconds: of the recording.
        detections, recognitions: images searched, and boxes read.
        reader_seconds: of processor time that reading and placing texts took.
    """

    seconds: float
    detections: int
    recognitions: int
    reader_seconds: float

    @property
    def detections_a_minute(self) -> float:
        """Of the recording."""
        return 60.0 * self.detections / max(self.seconds, 1e-9)

    @property
    def recognitions_a_minute(self) -> float:
        """Of the recording."""
        return 60.0 * self.recognitions / max(self.seconds, 1e-9)

    @property
    def reader_seconds_a_minute(self) -> float:
        """Of the recording."""
        return 60.0 * self.reader_seconds / max(self.seconds, 1e-9)


def reading_cost(statistics: dict[str, float], seconds: float) -> ReadingCost | None:
    """Sum up the reading of a run.

    Args:
        statistics: of `TextStatistics`; empty where nothing was read.
        seconds: of the recording.
    """
    if not statistics:
        return None
    return ReadingCost(
        seconds=seconds,
        detections=int(statistics["frames_read"]),
        recognitions=int(statistics["texts_read"] + statistics["texts_rejected"]),
        reader_seconds=statistics.get("reader_processor_ms", 0.0) / 1000.0,
    )


def remembering_delays(
    classes: Sequence[TextClass],
    world_from_keyframe: Callable[[int], Array | None],
    signs: Sequence[TrueSign],
    truth_from_map: Array,
    thresholds: EvaluationConfig,
) -> dict[int | str, float | None]:
    """Say how long after it could first be read each expected sign was in long-term memory, at its place.

    That is from when a class in long-term memory had a reading like the sign, at the sign: less than nothing for a
    sign that was read before a person is expected to. Signs of which no such time is known are left out.

    Args:
        classes: those in long-term memory.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose in the map frame; None where it has none.
        signs: of the scene.
        truth_from_map: 4×4.
        thresholds: what counts as right.

    Returns:
        By the sign's id: seconds; None for a sign that was never remembered.
    """
    sightings = [_sightings(each, world_from_keyframe, truth_from_map) for each in classes]
    delays: dict[int | str, float | None] = {}
    for sign in signs:
        if sign.readable_from is None or (sign.readable_frames or 0) < thresholds.readable_frames:
            continue
        moments = [
            max(each.promoted_at, moment)
            for each in sightings
            if (moment := each.first_of(sign, thresholds)) is not None
        ]
        delays[sign.id] = min(moments) - sign.readable_from if moments else None
    return delays


@dataclass(frozen=True, slots=True, eq=False)
class _Sightings:
    """Sightings of one class: (n,) texts, (n, 3) true positions, (n,) seconds, and when the class became long-term."""

    texts: NDArray[np.str_]
    positions: Array
    times: Array
    promoted_at: float

    def first_of(self, sign: TrueSign, thresholds: EvaluationConfig) -> float | None:
        """Seconds of the first sighting of a sign; None without."""
        names = {comparison_key(name) for name in sign.names}
        alike = [
            text
            for text in set(self.texts.tolist())
            if max(similarity(comparison_key(text), name) for name in names) >= thresholds.name_similarity
        ]
        near = np.linalg.norm(self.positions - np.array(sign.centre), axis=1) <= thresholds.landmark_distance
        here = near & np.isin(self.texts, alike)
        return float(self.times[here].min()) if here.any() else None


def _sightings(
    text_class: TextClass, world_from_keyframe: Callable[[int], Array | None], truth_from_map: Array
) -> _Sightings:
    placed = [
        (each, pose)
        for each in text_class.observations
        if each.placement is not None and (pose := world_from_keyframe(each.keyframe)) is not None
    ]
    positions = np.array(
        [transform_points(truth_from_map @ pose, np.array([each.place.position]))[0] for each, pose in placed]
    )
    return _Sightings(
        texts=np.array([each.text for each, _ in placed], dtype=np.str_),
        positions=positions.reshape(-1, 3),
        times=np.array([each.timestamp for each, _ in placed]),
        promoted_at=text_class.promoted_at if text_class.promoted_at is not None else text_class.last_seen,
    )
