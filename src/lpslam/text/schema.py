"""What must hold of the document of a map of words before anything is made of it: types, ranges and lengths."""

from typing import Annotated, Any, NotRequired

from annotated_types import Ge, Le, MaxLen, MinLen
from pydantic import ConfigDict, FiniteFloat, Strict, TypeAdapter, ValidationError, with_config
from typing_extensions import TypedDict

_LARGEST = 2**31 - 1
_LONGEST_TEXT = 4096
"""Letters: more than any reading, name or reason has."""
_FARTHEST = 1e7
"""Metres: farther than anything is mapped from its origin."""
_LATEST = 1e12
"""Seconds: beyond any clock."""

Text = Annotated[str, Strict(), MaxLen(_LONGEST_TEXT)]
Whole = Annotated[int, Strict(), Ge(-_LARGEST), Le(_LARGEST)]
Count = Annotated[int, Strict(), Ge(0), Le(_LARGEST)]
"""Also ids and row numbers."""
Number = Annotated[FiniteFloat, Strict()]
Share = Annotated[FiniteFloat, Strict(), Ge(0.0), Le(1.0 + 1e-6)]
Seconds = Annotated[FiniteFloat, Strict(), Ge(-_LATEST), Le(_LATEST)]
_Size = Annotated[FiniteFloat, Strict(), Ge(0.0), Le(_FARTHEST)]
_Metres = Annotated[FiniteFloat, Strict(), Ge(-_FARTHEST), Le(_FARTHEST)]
_Cosine = Annotated[FiniteFloat, Strict(), Ge(-1.0 - 1e-6), Le(1.0 + 1e-6)]
_Point = tuple[_Metres, _Metres, _Metres]
_Direction = tuple[_Cosine, _Cosine, _Cosine]
_Shade = Annotated[int, Strict(), Ge(0), Le(255)]
_Colour = tuple[_Shade, _Shade, _Shade]
_History = list[tuple[Seconds, Number]]

_known = with_config(ConfigDict(extra="forbid"))


@_known
class _Placement(TypedDict):
    position: _Point
    normal: _Direction
    baseline: _Direction
    width: _Size
    height: _Size
    uncertainty: _Size


@_known
class _Bearing(TypedDict):
    origin: _Point
    corners: tuple[_Direction, _Direction, _Direction, _Direction]


@_known
class _Observation(TypedDict):
    frame: Count
    timestamp: Seconds
    keyframe: Count
    text: Text
    confidence: Share
    placement: _Placement | None
    letter_height: _Size
    ground: NotRequired[_Colour | None]
    bearing: NotRequired[_Bearing | None]
    right: NotRequired[Share | None]
    ink: NotRequired[_Colour | None]
    bare: NotRequired[_Colour | None]
    clear: NotRequired[tuple[Number, Number, Number, Number] | None]
    whole: NotRequired[tuple[Share, Share] | None]


@_known
class _Look(TypedDict):
    text: Text
    view: tuple[Whole, Whole, Whole]
    count: Annotated[Count, Ge(1)]
    confidence: Number
    odds: Number
    best: Number
    slots: list[Annotated[list[tuple[Text, Share]], MinLen(1)]]


@_known
class _Variant(TypedDict):
    count: Annotated[Count, Ge(1)]
    confidence: Number


@_known
class _Naming(TypedDict):
    name: Text
    confidence: Share
    evidence: Text
    model: Text


@_known
class _TextClass(TypedDict):
    id: Count
    first_seen: Seconds
    last_seen: Seconds
    variants: Annotated[dict[Text, _Variant], MinLen(1)]
    score: Number
    pool: Text
    promoted_at: Seconds | None
    history: _History
    observations: list[_Observation]
    looks: NotRequired[list[_Look]]
    visits: NotRequired[Count]
    naming: _Naming | None
    named_at_count: Count


@_known
class _Forgotten(TypedDict):
    id: Count
    name: Text
    history: _History


@_known
class _Memory(TypedDict):
    clock: Seconds | None
    next_id: Count
    forgotten_count: Count
    forgotten: list[_Forgotten]
    classes: list[_TextClass]


@_known
class _Judgement(TypedDict):
    question: Text
    answer: Annotated[bool, Strict()]
    confidence: Share
    evidence: Text
    model: Text


@_known
class _Document(TypedDict):
    config: dict[str, Any]
    memory: _Memory
    judgements: dict[Text, dict[Text, _Judgement]]
    question: Text | None


_DOCUMENT = TypeAdapter(_Document)


def refuse_other_document(document: Any) -> None:
    """Refuse what is no document of a map of words.

    Raises:
        ValueError: one line; where the first fault is, and what.
    """
    refuse_unlike(_DOCUMENT, document)
    memory = document["memory"]
    ids = [each["id"] for each in memory["classes"]]
    if len(set(ids)) != len(ids) or any(each >= memory["next_id"] for each in ids):
        raise ValueError("two classes of texts have one id, or one is yet to be given")


def refuse_unlike(schema: TypeAdapter[Any], value: Any) -> None:
    """Refuse a value that is not as a schema says.

    Raises:
        ValueError: one line; where the first fault is, and what.
    """
    try:
        schema.validate_python(value)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        place = ".".join(str(each)[:40] for each in first["loc"])
        raise ValueError(f"{place or 'the document'}: {first['msg']}") from None
