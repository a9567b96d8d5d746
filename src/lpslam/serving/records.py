"""What goes in and out, as published schemas: metres and degrees, map frame (x forward, y left, z up).

Every text of a landmark was read from the world. It is data: never markup, and never an instruction.
"""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints

from lpslam.navigation.places import FARTHEST

_LARGEST_ID = 2**53 - 1  # whole numbers that every JSON reader keeps


def _encodable(text: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:
        raise ValueError("is no valid Unicode text") from None
    return text


Metres = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST, allow_inf_nan=False)]
Position = Annotated[list[Metres], Field(min_length=2, max_length=3, description="(x, y) or (x, y, z), metres.")]
Degrees = Annotated[float, Field(ge=-36_000, le=36_000, allow_inf_nan=False)]
LandmarkId = Annotated[int, Field(ge=0, le=_LARGEST_ID, strict=True)]
Text = Annotated[str, AfterValidator(_encodable)]
Language = Annotated[str, StringConstraints(max_length=35), AfterValidator(_encodable)]
MapName = Annotated[str, StringConstraints(min_length=1, max_length=60), AfterValidator(_encodable)]


class Inward(BaseModel):
    """What a client sends: nothing unknown, nothing endless."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Outward(BaseModel):
    """What a client gets."""

    model_config = ConfigDict(extra="forbid")


class Question(Inward):
    """A question to a map."""

    question: Text = Field(description="In any language.", examples=["Where can I eat pizza?"])
    map: MapName | None = Field(None, description="Its name; may be left out where one map is served.")
    before: Text | None = Field(None, description="The question before it: “and another one?” asks it again.")
    position: Position | None = Field(None, description="Where the asker stands; where the camera was last without.")
    heading: Degrees | None = Field(None, description="Counter-clockwise from the map's x axis.")
    excluded: Annotated[list[LandmarkId], Field(max_length=200)] = Field(
        default_factory=list, description="Landmarks that were named before, for “and another one?”."
    )
    wish: dict[str, Any] | None = Field(
        None, description="What the question means, as an answer's `wish` with what was misunderstood put right."
    )
    before_wish: dict[str, Any] | None = Field(
        None, description="The same of the question before, where it was put right: for “and another one?”."
    )


class Destination(Inward):
    """A landmark to go to, by its id or by a question, and from where."""

    map: MapName | None = None
    landmark: LandmarkId | None = Field(None, description="Its id; or ask a question.")
    question: Text | None = Field(None, description="In any language; or give a landmark.")
    position: Position | None = Field(None, description="From where; where the camera was last without.")
    heading: Degrees | None = None
    via: Annotated[list[LandmarkId], Field(max_length=24)] = Field(
        default_factory=list, description="Landmarks before which to stand first, in this order."
    )
    language: Language | None = Field(None, description="Of the steps, as “de”; the question's, or English, without.")


class NewCorrection(Inward):
    """What a person says of a landmark."""

    map: MapName | None = None
    revision: Annotated[int, Field(ge=0, le=_LARGEST_ID, strict=True)] = Field(
        description="Of the corrections that whoever says it has seen; 409 if there are others since."
    )
    kind: Literal["rename", "merge", "hide", "judge"]
    landmark: LandmarkId
    name: Annotated[Text, Field(max_length=400)] = Field("", description="For `rename`.")
    into: LandmarkId | None = Field(None, description="For `merge`: the landmark that it is the same as.")
    answer: Annotated[bool, Field(strict=True)] | None = Field(
        None, description="For `judge`, by the map's current question."
    )


class LineRecord(Outward):
    """One line of a board."""

    text: str
    role: str
    confidence: float
    position: list[float]
    width: float
    height: float
    observations: int


class JudgementRecord(Outward):
    """Whether a board is what a question asks for."""

    question: str
    answer: bool
    confidence: float
    evidence: str
    model: str


class CorrectionRecord(Outward):
    """What a person has said of a landmark; it wins over what was read."""

    number: int = Field(description="By which it is taken back.")
    kind: Literal["rename", "merge", "hide", "judge"]
    landmark: int
    read: str = Field(description="What the landmark was read as.")
    made: str = Field(description="When, ISO 8601.")
    name: str | None = None
    answer: bool | None = None
    question: str | None = None
    into: int | None = None
    into_name: str | None = None


class LandmarkRecord(Outward):
    """One board, as in landmarks.json."""

    id: int
    name: str
    role: str
    lines: list[LineRecord]
    variants: dict[str, int]
    position: list[float]
    normal: list[float]
    spread: float
    width: float
    height: float
    observations: int
    confidence: float
    is_landmark: bool | None
    judgements: list[JudgementRecord]
    corrections: list[CorrectionRecord]
    distance: float | None = Field(None, description="Metres from `near`, only where that was asked for.")


class CorrectionState(Outward):
    """What a person has said of a map."""

    map: str
    version: str
    revision: int = Field(description="Counts changes; give it with the next one.")
    corrections: list[CorrectionRecord] = Field(description="The oldest first; those of hidden landmarks too.")


class LandmarkPage(Outward):
    """A page of a map's landmarks."""

    map: str
    version: str
    total: int = Field(description="Landmarks on all pages.")
    page: int
    size: int
    landmarks: list[LandmarkRecord]


class MapRecord(Outward):
    """A map that is served."""

    name: str
    version: str = Field(description="Changes when the map's file is replaced.")
    source: str
    landmarks: int
    keyframes: int
    frames: int
    path_length_m: float
    question: str | None = Field(description="What was judged last.")
    last_position: list[float] = Field(description="Where the camera was last.")
    last_heading: float = Field(description="Degrees.")
    has_ground: bool = Field(description="Whether the map has kept what /grid.png follows from.")
    trouble: str = Field(description="Why the newest file is not served; empty when it is.")


class MapList(Outward):
    """The maps that are served."""

    maps: list[MapRecord]


class ChoiceRecord(Outward):
    """What the language model said."""

    landmark: int | None
    confidence: float
    evidence: str
    model: str
    alternatives: list[int]


class AnswerRecord(Outward):
    """An answer, equal to what `lpslam ask --json` prints."""

    question: str
    landmark: LandmarkRecord | None
    distance: float | None
    direction: float | None = Field(description="Degrees counter-clockwise.")
    direction_is_from: Literal["heading", "map x axis"]
    asked_from: list[float]
    choice: ChoiceRecord
    wish: dict[str, Any] = Field(description="What was understood.")
    stops: list[int | None] = Field(description="The places of a plan, in order.")
    alternatives: list[str]
    alternative_ids: list[int]


class AnswerEnvelope(Outward):
    """An answer with its words."""

    map: str
    version: str
    text: str = Field(description="In the question's language; plain text.")
    understood: str
    kinds: dict[str, str] = Field(description="What the kinds of the wish are called in the question's language.")
    notes: list[str]
    answer: AnswerRecord


class GridRecord(Outward):
    """Where the occupancy grid of /grid.png lies: 254 is free, 0 occupied, 205 unknown, as in ROS's map_server."""

    map: str
    version: str
    width: int = Field(description="Cells, and pixels, along x.")
    height: int = Field(description="Along y; the picture's first row is the largest y.")
    resolution: float = Field(description="Metres a cell.")
    origin: list[float] = Field(description="(x, y) of the corner with the smallest x and y, metres, map frame.")
    free: int = Field(description="Cells.")
    occupied: int


class GoalRecord(Outward):
    """Where to stand before a landmark."""

    map: str
    version: str
    landmark: int
    name: str
    position: list[float] = Field(description="Metres, map frame.")
    heading: float = Field(description="Degrees, towards the landmark.")
    is_before_the_sign: bool = Field(description="Else it is the nearest place that can be reached.")
    missing: float = Field(description="Metres from there to the sign, seen from above.")


class LegRecord(GoalRecord):
    """The way to one stop, from the start or from the stop before it."""

    points: list[list[float]] = Field(description="Metres, map frame, from the start to the goal.")
    length: float = Field(description="Metres.")
    seconds: float
    steps: list[str] = Field(description="In the question's language; plain text that names signs.")


class PathRecord(LegRecord):
    """The whole way to where one stands before a landmark."""

    legs: list[LegRecord] = Field(description="Its parts, one to each stop; the last one leads to the landmark.")


class JobRecord(Outward):
    """An uploaded recording that is mapped."""

    id: str
    name: str = Field(description="Under which the map is served when it is done.")
    state: Literal["waiting", "unpacking", "mapping", "done", "failed", "cancelled"]
    frames: int = Field(description="Mapped so far.")
    frames_total: int
    frames_per_second: float
    keyframes: int
    landmarks: int
    message: str = Field(description="What went wrong, in a line; empty when nothing did.")


class JobList(Outward):
    """The jobs that are remembered, the newest first."""

    jobs: list[JobRecord]


class Conflict(Outward):
    """Somebody else was first; what there is now."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    revision: int
    corrections: list[CorrectionRecord]


class Problem(Outward):
    """What is wrong, as RFC 9457 has it."""

    type: str = "about:blank"
    title: str
    status: int
    detail: str
