"""How well a map's landmarks tell the signs of the scene: recall, precision, names, places, facings."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from lpslam.camera import transform_points
from lpslam.config import EvaluationConfig
from lpslam.evaluation.signs import TrueSign, Vector3
from lpslam.text.remembering.similarity import comparison_key, similarity

Array = NDArray[np.float64]
_DEFAULTS = EvaluationConfig()


class NamedPlace(Protocol):
    """What of a landmark is scored: its name, place and facing in the map frame."""

    @property
    def id(self) -> int:
        """Identifies the landmark in reports."""
        ...

    @property
    def name(self) -> str:
        """The text it stands for."""
        ...

    @property
    def position(self) -> Array:
        """(3,) metres, map frame."""
        ...

    @property
    def normal(self) -> Array:
        """(3,) unit, out of the text's surface, map frame."""
        ...


@dataclass(frozen=True, slots=True)
class Match:
    """A landmark and the sign that it is.

    Attributes:
        landmark, name: the landmark.
        sign, text: the sign.
        similarity: Eq. 3, of the name with the sign's text or an alias.
        distance: metres, to the middle of the line or lines of the sign that the name says.
        exact: whether the name is the text or an alias but for case and spaces.
        angle: degrees between the normals; None where the sign's is not known.
        whole: of a sign of several lines that could all be read, whether the name has them all; else None.
    """

    landmark: int
    name: str
    sign: int | str
    text: str
    similarity: float
    distance: float
    exact: bool
    angle: float | None
    whole: bool | None


@dataclass(frozen=True, slots=True)
class Stray:
    """A landmark that is no sign, or one that another landmark already is.

    Attributes:
        landmark, name: the landmark.
        position: metres, in the true frame.
        duplicate_of: the id of the sign that another landmark already is; None if it is no sign at all.
        likest: text of the sign whose text is likest, wherever it stands; empty without signs.
        similarity: with it.
        distance: metres to it.
    """

    landmark: int
    name: str
    position: Vector3
    duplicate_of: int | str | None
    likest: str
    similarity: float
    distance: float


@dataclass(frozen=True, slots=True)
class LandmarkScore:
    """The score of a map's landmarks.

    Attributes:
        recall: share of the readable signs that have a landmark; None without readable signs.
        precision: share of the landmarks that are a sign of their own; None without landmarks.
        median_position_error: metres, over the matches; None without matches.
        facing_share: share of the matches whose normal is right; None without any that is known.
        exact_name_share: share of the matches whose name is exact; None without matches.
        whole_name_share: share of the matched boards of several readable lines whose name has them all; None without.
        duplicates: pairs of expected signs of the same words that are far enough apart to be two places.
        duplicates_apart: how many of these pairs have two landmarks.
        readable_signs: signs that were readable long enough to be expected.
        landmarks: landmarks scored.
        matches: each landmark that is a sign, with it.
        misses: readable signs that have no landmark.
        strays: false and duplicate landmarks.
    """

    recall: float | None
    precision: float | None
    median_position_error: float | None
    facing_share: float | None
    exact_name_share: float | None
    whole_name_share: float | None
    duplicates: int
    duplicates_apart: int
    readable_signs: int
    landmarks: int
    matches: tuple[Match, ...]
    misses: tuple[TrueSign, ...]
    strays: tuple[Stray, ...]


def score_landmarks(
    landmarks: Sequence[NamedPlace],
    signs: Sequence[TrueSign],
    truth_from_map: Array,
    thresholds: EvaluationConfig = _DEFAULTS,
) -> LandmarkScore:
    """Match landmarks to signs, one to one, and count.

    Args:
        landmarks: of the map.
        signs: of the scene; those readable in too few frames may be matched but are not expected.
        truth_from_map: 4×4, as the alignment of the trajectories gives it.
        thresholds: what counts as a match.
    """
    positions = transform_points(
        truth_from_map, np.array([landmark.position for landmark in landmarks], dtype=np.float64).reshape(-1, 3)
    )
    normals = [truth_from_map[:3, :3] @ landmark.normal for landmark in landmarks]
    likeness, distances = _compared(landmarks, positions, signs, thresholds)
    possible = (likeness >= thresholds.name_similarity) & (distances <= thresholds.landmark_distance)
    # As many matches as can be; among those, the likest names and the nearest places.
    benefit = np.where(possible, 10.0 + likeness - distances / thresholds.landmark_distance, 0.0)
    rows, columns = linear_sum_assignment(benefit, maximize=True)
    sign_of = {int(row): int(column) for row, column in zip(rows, columns, strict=True) if possible[row, column]}
    matches = tuple(
        _matched(landmarks[row], signs[column], likeness[row, column], distances[row, column], normals[row], thresholds)
        for row, column in sign_of.items()
    )
    strays = tuple(
        _stray(landmarks[row], positions[row], signs, likeness[row], distances[row], possible[row])
        for row in range(len(landmarks))
        if row not in sign_of
    )
    return _counted(matches, strays, signs, set(sign_of.values()), thresholds)


def _compared(
    landmarks: Sequence[NamedPlace], positions: Array, signs: Sequence[TrueSign], thresholds: EvaluationConfig
) -> tuple[Array, Array]:
    """(landmarks, signs) how like their names are, and how far apart they are, metres."""
    shape = (len(landmarks), len(signs))
    said = [[_name_said(mark.name, sign) for sign in signs] for mark in landmarks]
    likeness = np.array([[like for _, like in row] for row in said]).reshape(shape)
    distances = np.array(
        [
            [
                sign.distance(name, position, _lines_said(mark, sign, thresholds))
                for (name, _), sign in zip(row, signs, strict=True)
            ]
            for mark, row, position in zip(landmarks, said, positions, strict=True)
        ]
    ).reshape(shape)
    return likeness, distances


def _matched(
    landmark: NamedPlace, sign: TrueSign, likeness: float, distance: float, normal: Array, thresholds: EvaluationConfig
) -> Match:
    return Match(
        landmark=landmark.id,
        name=landmark.name,
        sign=sign.id,
        text=sign.text,
        similarity=float(likeness),
        distance=float(distance),
        exact=bool(likeness == 1.0),
        angle=sign.angle(normal),
        whole=_is_whole(landmark, sign, thresholds),
    )


def _counted(
    matches: tuple[Match, ...],
    strays: tuple[Stray, ...],
    signs: Sequence[TrueSign],
    taken: set[int],
    thresholds: EvaluationConfig,
) -> LandmarkScore:
    """The score, where some of the signs have a landmark (`taken`)."""
    expected = [column for column, sign in enumerate(signs) if _is_expected(sign, thresholds.readable_frames)]
    angles = [match.angle for match in matches if match.angle is not None]
    wholes = [match.whole for match in matches if match.whole is not None]
    twins = [
        (first, second)
        for first, second in combinations(expected, 2)
        if _are_twins(signs[first], signs[second], thresholds.duplicate_distance)
    ]
    return LandmarkScore(
        recall=_share(sum(column in taken for column in expected), len(expected)),
        precision=_share(len(matches), len(matches) + len(strays)),
        median_position_error=float(np.median([match.distance for match in matches])) if matches else None,
        facing_share=_share(sum(angle <= thresholds.facing_angle for angle in angles), len(angles)),
        exact_name_share=_share(sum(match.exact for match in matches), len(matches)),
        whole_name_share=_share(sum(wholes), len(wholes)),
        duplicates=len(twins),
        duplicates_apart=sum(first in taken and second in taken for first, second in twins),
        readable_signs=len(expected),
        landmarks=len(matches) + len(strays),
        matches=matches,
        misses=tuple(signs[column] for column in expected if column not in taken),
        strays=strays,
    )


def _name_said(name: str, sign: TrueSign) -> tuple[str, float]:
    """Which of a sign's names a landmark's name is likest to, and how much."""
    key = comparison_key(name)
    if not key:
        return sign.text, 0.0
    return max(((text, similarity(key, comparison_key(text))) for text in sign.names), key=lambda each: each[1])


def _lines_said(landmark: NamedPlace, sign: TrueSign, thresholds: EvaluationConfig) -> set[str]:
    """Which lines of a sign are said by the lines of a landmark that has several."""
    keys = [comparison_key(line.text) for line in getattr(landmark, "lines", ())]
    return {
        line.text
        for line in sign.lines
        if len(keys) > 1
        and any(similarity(key, comparison_key(line.text)) >= thresholds.name_similarity for key in keys if key)
    }


def _is_whole(landmark: NamedPlace, sign: TrueSign, thresholds: EvaluationConfig) -> bool | None:
    """Whether a landmark says all lines of a sign; None where that has one line, or one that could not be read."""
    if len(sign.lines) < 2 or any((line.readable_frames or 0) < thresholds.readable_frames for line in sign.lines):
        return None
    painted = {line.text for line in sign.lines}
    said, like = _name_said(landmark.name, sign)
    in_one = like >= thresholds.name_similarity and said not in painted
    return in_one or _lines_said(landmark, sign, thresholds) == painted


def _are_twins(first: TrueSign, second: TrueSign, distance: float) -> bool:
    """Whether two signs say the same in two places."""
    same = {comparison_key(name) for name in first.names} == {comparison_key(name) for name in second.names}
    return same and float(np.linalg.norm(np.subtract(first.centre, second.centre))) >= distance


def _is_expected(sign: TrueSign, readable_frames: int) -> bool:
    return sign.readable_frames is None or sign.readable_frames >= readable_frames


def _stray(
    landmark: NamedPlace, position: Array, signs: Sequence[TrueSign], likeness: Array, distances: Array, possible: Array
) -> Stray:
    x, y, z = (float(value) for value in position)
    if not signs:
        return Stray(landmark.id, landmark.name, (x, y, z), None, "", 0.0, float("inf"))
    # Without this order a second sign of the same words elsewhere would hide how near the miss was.
    likest = int(np.lexsort((distances, -likeness))[0])
    duplicate_of = (
        signs[int(np.argmax(np.where(possible, likeness - distances, -np.inf)))].id if possible.any() else None
    )
    return Stray(
        landmark=landmark.id,
        name=landmark.name,
        position=(x, y, z),
        duplicate_of=duplicate_of,
        likest=signs[likest].text,
        similarity=float(likeness[likest]),
        distance=float(distances[likest]),
    )


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
