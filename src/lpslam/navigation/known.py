"""What questions are answered from: a map's landmarks, and where its camera was last.

Both follow from what the map file holds, and take longer to derive than many questions to answer: a millisecond a
landmark. They are kept in the user's cache, so that a process that asks a map once more need not read it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

import lpslam
from lpslam.config import NavigationConfig
from lpslam.language.kept import kept
from lpslam.language.model import Judgement
from lpslam.mapfile.container import identity_of
from lpslam.navigation.directory import Directory
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.types import Landmark, LandmarkLine

if TYPE_CHECKING:
    from lpslam.mapfile.language_map import LanguageMap

_PACKAGE = Path(lpslam.__file__).parent

View = tuple[NDArray[np.float64], float]
"""Where a camera was last, (3,) map frame, and its heading in radians."""


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known of a map by whoever asks it.

    Attributes:
        landmarks: by id, whatever their judgement.
        view: where the camera was last, (3,) map frame, and its heading in radians.
    """

    landmarks: tuple[Landmark, ...]
    view: View


def known_of(world: "LanguageMap", landmarks: Sequence[Landmark] | None = None) -> Known:
    """What is known of a map at hand; its landmarks are derived where they are not."""
    marks = world.landmarks() if landmarks is None else landmarks
    return Known(tuple(marks), last_view(world.frame_poses().world_from_camera))


def directory_of(world: "LanguageMap", config: NavigationConfig | None = None) -> tuple[Directory, View]:
    """The landmarks of a map at hand, made ready for questions, and its last view; kept for as long as it is the same.

    Deriving landmarks takes a millisecond each, and to see that the map is still the same a thousandth of that.
    """
    poses = world.keyframe_poses()
    state = (world.text.state(), poses.timestamps.tobytes(), poses.world_from_camera.tobytes(), len(world.trajectory))
    before = _asked.get(world)
    if before is None or before[0] != state:
        known = known_of(world)
        before = _asked[world] = state, known.view, Directory(known.landmarks, config)
    _, view, directory = before
    if directory.config != (config or NavigationConfig()):
        directory = Directory(directory.landmarks, config)
        _asked[world] = state, view, directory
    return directory, view


_asked: "WeakKeyDictionary[LanguageMap, tuple[object, View, Directory]]" = WeakKeyDictionary()
"""Maps that were asked: their state then, and what was made of it."""


def last_view(poses: NDArray[np.float64]) -> View:
    """Where the camera was last, (3,) map frame, and its heading in radians; the origin before any of (n, 4, 4)."""
    if not len(poses):
        return np.zeros(3), 0.0
    forward = poses[-1][:3, 2]
    return poses[-1][:3, 3], float(np.arctan2(forward[1], forward[0]))


def known_in(path: Path) -> Known:
    """What is known of a map in a file, from the user's cache where this program has read the same before.

    Raises:
        UserError: there is no map, or it is damaged, or of a newer version.
    """

    def make() -> dict[str, Any]:
        from lpslam.mapfile.language_map import LanguageMap

        return _packed(known_of(LanguageMap.load(path)))

    return _unpacked(kept("landmarks", identity_of(path), make, _PACKAGE))


def remember(world: "LanguageMap", identity: bytes, landmarks: Sequence[Landmark] | None = None) -> None:
    """Keep what is known of a map in the user's cache: its file is not read, and its landmarks not derived, to ask it.

    Args:
        world: as it was saved.
        identity: what `save` returned.
        landmarks: of it, where they are at hand.
    """
    kept("landmarks", identity, lambda: _packed(known_of(world, landmarks)), _PACKAGE)


def _packed(known: Known) -> dict[str, Any]:
    marks = known.landmarks
    lines = [line for mark in marks for line in mark.lines]
    by_number = {each.number: each for mark in marks for each in mark.corrections}
    corrections = Corrections(
        0, tuple(by_number[number] for number in sorted(by_number)), max(by_number, default=0) + 1
    )
    return {
        "view": (known.view[0].tolist(), float(known.view[1])),
        "vectors": [
            _bytes(vectors) for vectors in ([mark.position for mark in marks], [mark.normal for mark in marks])
        ],
        "marks": [_fields_of(mark) for mark in marks],
        "line_positions": _bytes([line.position for line in lines]),
        "lines": [
            (ln.text, ln.role, float(ln.confidence), float(ln.width), float(ln.height), int(ln.observations))
            for ln in lines
        ],
        "corrections": corrections.to_document(),
    }


def _fields_of(mark: Landmark) -> tuple[Any, ...]:
    # NumPy's numbers are no plain values.
    sizes = (float(mark.spread), float(mark.width), float(mark.height), int(mark.observations), float(mark.confidence))
    variants = {text: int(count) for text, count in mark.variants.items()}
    judgements = {
        question: (each.question, bool(each.answer), float(each.confidence), each.evidence, each.model)
        for question, each in mark.judgements.items()
    }
    answer = None if mark.is_landmark is None else bool(mark.is_landmark)
    numbers = [each.number for each in mark.corrections]
    return (mark.id, mark.name, variants, *sizes, judgements, answer, len(mark.lines), mark.role, numbers)


def _unpacked(packed: dict[str, Any]) -> Known:
    corrections = {each.number: each for each in Corrections.from_document(packed["corrections"]).entries}
    positions, normals = map(_vectors, packed["vectors"])
    lines = [
        LandmarkLine(text, role, confidence, position, width, height, observations)
        for (text, role, confidence, width, height, observations), position in zip(
            packed["lines"], _vectors(packed["line_positions"]), strict=True
        )
    ]
    marks, first = [], 0
    for row, position, normal in zip(packed["marks"], positions, normals, strict=True):
        id_, name, variants, spread, width, height, observations, confidence, judgements, answer, count, role, said = (
            row
        )
        marks.append(
            Landmark(
                *(id_, name, variants, position, normal, spread, width, height, observations, confidence),
                {question: Judgement(*judged) for question, judged in judgements.items()} if judgements else {},
                answer,
                tuple(lines[first : first + count]),
                role,
                tuple(corrections[number] for number in said),
            )
        )
        first += count
    position, heading = packed["view"]
    return Known(tuple(marks), (np.array(position), heading))


def _bytes(vectors: Iterable[NDArray[np.float64]]) -> bytes:
    return np.array(list(vectors), np.float64).tobytes()


def _vectors(packed: bytes) -> list[NDArray[np.float64]]:
    """(3,) each."""
    return list(np.frombuffer(packed, np.float64).reshape(-1, 3).copy())
