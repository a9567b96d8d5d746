"""The value types of reading: what was seen in a frame, where it stands, and what the map makes of it."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lpslam.frames import RgbdFrame
from lpslam.language.model import LINES_APART, Judgement, Slots
from lpslam.text.correcting.corrections import Correction

Vector3 = tuple[float, float, float]
Rows = NDArray[np.intp] | NDArray[np.bool_]

NOWHERE = -1
"""Keyframe of what was read while the camera was lost: such texts stand in the camera's own frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A frame and where it was taken: its reference keyframe, its 4×4 pose in that, and that one's in the world.

    The last is None where it is not known, or no evidence of what stands where.
    """

    frame: RgbdFrame
    keyframe: int
    keyframe_from_camera: NDArray[np.float64]
    world_from_keyframe: NDArray[np.float64] | None

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """Where it was taken in the world, which must be known."""
        assert self.world_from_keyframe is not None
        return self.world_from_keyframe @ self.keyframe_from_camera


class Recognition(NamedTuple):
    """What a recogniser makes of one box.

    Attributes:
        text: perhaps empty.
        confidence: mean probability of its letters, 0 to 1.
        slots: what each letter may be instead; empty where the recogniser does not say.
        sharpness: steepest edge of the rectified line, share of its contrast a pixel; None where nobody looked.
        has_hole: whether there is room for one more between two of its ideographs, which stand evenly.
    """

    text: str
    confidence: float
    slots: Slots = ()
    sharpness: float | None = None
    has_hole: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class SpottedText:
    """One text read in one image.

    Attributes:
        text: as painted: case, spaces and punctuation kept; control characters stripped.
        confidence: mean probability of its letters, 0 to 1.
        box: (4, 2) raw pixels, ordered top left, top right, bottom right, bottom left.
        letter_height: pixels, mean of the box's two upright sides.
        slots, sharpness, has_hole: as of its `Recognition`.
    """

    text: str
    confidence: float
    box: NDArray[np.float64]
    letter_height: float
    slots: Slots = ()
    sharpness: float | None = None
    has_hole: bool = False


class BoxFate(StrEnum):
    """What became of a detected box (Fig. 11)."""

    KEPT = "kept"
    BORDER = "border"
    SMALL = "small"
    HIDDEN = "hidden"
    KNOWN = "known"
    ORNAMENT = "ornament"
    UNREAD = "unread"


@dataclass(frozen=True, slots=True)
class Placement:
    """Where a text box stands, in the frame of its reference keyframe's camera (III-F).

    Attributes:
        position: metres, centre of the box on its surface.
        normal: unit, towards the viewer.
        baseline: unit, the direction of reading.
        width, height: metres, of the box.
        uncertainty: metres, standard deviation of the position.
    """

    position: Vector3
    normal: Vector3
    baseline: Vector3
    width: float
    height: float
    uncertainty: float


@dataclass(frozen=True, eq=False)
class PlacedTexts:
    """n texts of one frame and where they stand, column by column; `texts[rows]` are some of them, in that order.

    Iterating gives each text with its placement.

    Attributes:
        spotted: as they were read.
        placements: one a text; None where its depth does not say.

    Raises:
        ValueError: there are not as many placements as texts.
    """

    spotted: tuple[SpottedText, ...] = ()
    placements: tuple[Placement | None, ...] = ()

    def __post_init__(self) -> None:
        if len(self.spotted) != len(self.placements):
            raise ValueError(f"{len(self.spotted)} texts have {len(self.placements)} placements")

    @classmethod
    def of(cls, pairs: Iterable[tuple[SpottedText, Placement | None]]) -> "PlacedTexts":
        """Of texts, each with its placement."""
        listed = tuple(pairs)
        return cls(tuple(text for text, _ in listed), tuple(placement for _, placement in listed))

    def __len__(self) -> int:
        return len(self.spotted)

    def __iter__(self) -> Iterator[tuple[SpottedText, Placement | None]]:
        return zip(self.spotted, self.placements, strict=True)

    def __getitem__(self, rows: Rows) -> "PlacedTexts":
        chosen = np.arange(len(self))[rows]
        return PlacedTexts(tuple(self.spotted[row] for row in chosen), tuple(self.placements[row] for row in chosen))

    def standing(self) -> Iterator[tuple[SpottedText, Placement]]:
        """Those whose place is known, each with it."""
        return ((text, placement) for text, placement in self if placement is not None)

    @cached_property
    def spellings(self) -> tuple[str, ...]:
        """As painted."""
        return tuple(text.text for text in self.spotted)

    @cached_property
    def confidences(self) -> NDArray[np.float64]:
        """(n,) 0 to 1."""
        return np.array([text.confidence for text in self.spotted], np.float64)

    @cached_property
    def boxes(self) -> NDArray[np.float64]:
        """(n, 4, 2) raw pixels, ordered as those of `SpottedText`."""
        return np.array([text.box for text in self.spotted], np.float64).reshape(-1, 4, 2)


@dataclass(frozen=True, slots=True, eq=False)
class FrameReading:
    """All that reading one frame gave: the boxes, what became of each, and the texts kept.

    Attributes:
        frame: index of the frame.
        boxes: (n, 4, 2) raw pixels.
        fates: one a box.
        texts: the texts read and where they stand, in the order of the boxes that were kept.
        observations: the texts that could be placed.
        parts: what was read of texts that may go on where the view ends; all of them stand somewhere.
        patterns: where the boxes stand that were refused as ornaments.
    """

    frame: int
    boxes: NDArray[np.float64]
    fates: tuple[BoxFate, ...]
    texts: PlacedTexts = PlacedTexts()
    observations: tuple["TextObservation", ...] = ()
    parts: PlacedTexts = PlacedTexts()
    patterns: tuple["Placement", ...] = ()


@dataclass(frozen=True, slots=True)
class Bearing:
    """In which directions the corners of a text's box were seen, in the frame of its reference keyframe's camera.

    Attributes:
        origin: metres, where the camera was.
        corners: unit, ordered top left, top right, bottom right, bottom left.
    """

    origin: Vector3
    corners: tuple[Vector3, Vector3, Vector3, Vector3]


@dataclass(frozen=True, slots=True)
class TextObservation:
    """One sighting of a text, hung on its reference keyframe so that it moves when the keyframe is corrected.

    Attributes:
        frame: index of the frame; sightings with the same frame were seen together.
        timestamp: seconds.
        keyframe: id of the reference keyframe.
        text, confidence: as read.
        placement: in the frame of that keyframe's camera, by depth; None where depth does not say.
        letter_height: pixels, as it was seen.
        ground: (red, green, blue) of the surface around the letters, 0 to 255; None where it is not known.
        bearing: in the same frame; None in older maps.
        right: probability, 0 to 1, that the reading is exactly what is painted; None in maps of older programs.
        ink, bare: (red, green, blue) of the letters, and of the ground between them where it is least like them; None
            in maps of older programs.
        clear: how far the ground goes on above, right of, below and left of the box, as shares of its shorter side;
            None in maps of older programs.
        whole: probabilities, 0 to 1, that nothing more is painted before it, and behind it; None in maps of older
            programs.
    """

    frame: int
    timestamp: float
    keyframe: int
    text: str
    confidence: float
    placement: Placement | None
    letter_height: float
    ground: tuple[int, int, int] | None = None
    bearing: Bearing | None = None
    right: float | None = None
    ink: tuple[int, int, int] | None = None
    clear: tuple[float, float, float, float] | None = None
    whole: tuple[float, float] | None = None
    bare: tuple[int, int, int] | None = None

    @property
    def place(self) -> Placement:
        """Its placement.

        Raises:
            ValueError: it has none.
        """
        if self.placement is None:
            raise ValueError(f"{self.text!r} in frame {self.frame} was not placed")
        return self.placement


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkLine:
    """One line of a board.

    Attributes:
        text: its most reasonable spelling.
        role: primary, secondary, contact or list.
        confidence: 0 to 1, how surely the text is exactly what is painted.
        position: (3,) metres, map frame, its middle.
        width, height: metres.
        observations: how many sightings stand behind it.
    """

    text: str
    role: str
    confidence: float
    position: NDArray[np.float64]
    width: float
    height: float
    observations: int


@dataclass(frozen=True, slots=True, eq=False)
class Landmark:
    """One board of the map: what it is called by, and all that it says.

    Attributes:
        id: stable across calls and across saving: class id times 1000 plus the place's number.
        name: its primary line, in the most reasonable spelling; of a menu the first entry.
        variants: spellings of all lines and how often each was read here.
        position: (3,) metres, map frame.
        normal: (3,) unit, map frame, from the surface to where it was seen from.
        spread: metres, root mean square distance of the kept observations from the position.
        width, height: metres, of all lines together.
        observations: how many sightings stand behind it.
        confidence: 0 to 1, how surely the name is exactly what is painted.
        judgements: by question.
        is_landmark: the answer to the map's current question; None while nobody has judged.
        lines: all of them in the order of reading, the name's among them.
        role: of the line that it is called by: primary, or list of a menu, or contact of a number that stands alone.
        corrections: what a person has said of it, the oldest first; it holds in all else.
    """

    id: int
    name: str
    variants: Mapping[str, int]
    position: NDArray[np.float64]
    normal: NDArray[np.float64]
    spread: float
    width: float
    height: float
    observations: int
    confidence: float
    judgements: Mapping[str, Judgement] = field(default_factory=dict)
    is_landmark: bool | None = None
    lines: tuple[LandmarkLine, ...] = ()
    role: str = "primary"
    corrections: tuple[Correction, ...] = ()

    @property
    def telling_lines(self) -> tuple[str, ...]:
        """What it says of itself: the name and the lines that say more of it, but no numbers and no menu."""
        told = tuple(line.text for line in self.lines if line.role in ("primary", "secondary"))
        return told if self.role == "primary" and told else (self.name,)

    @property
    def wording(self) -> str:
        """The same as one text, by which judgements are kept."""
        return " ".join(self.telling_lines)

    @property
    def wording_by_line(self) -> str:
        """The same with its lines apart, as it is judged."""
        return LINES_APART.join(self.telling_lines)

    @property
    def other_lines(self) -> tuple[str, ...]:
        """What else can be asked for: all lines but the name, in the order of reading."""
        return tuple(line.text for line in self.lines if line.text != self.name)


@dataclass(slots=True)
class TextStatistics:
    """What reading has cost and what was lost on the way: counts, milliseconds, and the first error's words."""

    frames_seen: int = 0
    frames_read: int = 0
    frames_untracked: int = 0
    frames_blurred: int = 0
    boxes_detected: int = 0
    boxes_at_border: int = 0
    boxes_too_small: int = 0
    boxes_hidden: int = 0
    boxes_known: int = 0
    boxes_ornamental: int = 0
    texts_rejected: int = 0
    texts_read: int = 0
    observations: int = 0
    observations_without_depth: int = 0
    reader_errors: int = 0
    first_reader_error: str = ""
    language_errors: int = 0
    reader_processor_ms: float = 0.0
    detection_ms: float = 0.0
    recognition_ms: float = 0.0
    mapping_ms: float = 0.0
    second_looks: int = 0
    second_readings: int = 0
    second_look_ms: float = 0.0

    def count(self, fates: Sequence[BoxFate], without_depth: int) -> None:
        """Add what became of an image's boxes; so many of the texts that were read gave no place by depth."""
        became = Counter(fates)
        self.boxes_detected += len(fates)
        self.boxes_at_border += became[BoxFate.BORDER]
        self.boxes_too_small += became[BoxFate.SMALL]
        self.boxes_hidden += became[BoxFate.HIDDEN]
        self.boxes_known += became[BoxFate.KNOWN]
        self.boxes_ornamental += became[BoxFate.ORNAMENT]
        self.texts_rejected += became[BoxFate.UNREAD]
        self.texts_read += became[BoxFate.KEPT]
        self.observations_without_depth += without_depth
