"""The form of what is meant: an ordered list of stops, frozen, typed, as JSON and in words.

Language says what is meant, the map says where and which: nothing here holds a coordinate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from enum import StrEnum
from typing import Annotated, Any

from annotated_types import Ge, Lt

_DEEPEST = 15  # levels of a document; an anchor is two below its stop


class Ask(StrEnum):
    """What is asked of a stop."""

    WHERE = "where"
    LIST = "list"
    HOW_FAR = "how far"
    IS_THERE = "is there"
    WHICH = "which"
    WHETHER = "whether"
    HERE = "what is here"
    FORBIDDEN = "forbidden here"
    BARRED = "closed to the public"


OF_ANY_PLACE = (Ask.HERE, Ask.FORBIDDEN, Ask.BARRED)
"""What is asked of places whatever they are."""

LISTED = (Ask.LIST, *OF_ANY_PLACE)
"""What several places answer at once."""


class Which(StrEnum):
    """Which of several places that serve."""

    ANY = "any"
    ALL = "all"
    NEAREST = "nearest"
    FARTHEST = "farthest"
    LARGEST = "largest"


class Relation(StrEnum):
    """How a place stands to its anchor."""

    NEXT_TO = "next to"
    OPPOSITE = "opposite"
    LEFT_OF = "left of"
    RIGHT_OF = "right of"
    BETWEEN = "between"
    ON_THE_WAY = "on the way to"
    NEAR = "near"
    THIS_SIDE = "on this side of"
    BEFORE = "before"
    BEHIND = "behind"


class Counting(StrEnum):
    """From where floors are counted."""

    ABOVE_GROUND = "above ground"
    FROM_ONE = "from the ground floor, which is 1"
    FROM_HERE = "from here"
    TOP = "the top floor"


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor that is named: its number, and from where it is counted."""

    counting: Counting
    number: int

    def __str__(self) -> str:
        """As it is told: "floor 2 above ground"."""
        return str(self.counting.value) if self.counting is Counting.TOP else f"floor {self.number} {self.counting}"


class Sort(StrEnum):
    """What sort of identity a place must have."""

    NAME = "name"
    CODE = "code"
    PERSON = "person"


@dataclass(frozen=True, slots=True)
class Identity:
    """A hard constraint: a place whose board does not bear it is none.

    Attributes:
        sort: what it is.
        value: as it is compared: "b31", "203", "schneider".
        of: what is numbered, where that is said: "gate", "room"; a word may stand for several.
    """

    sort: Sort
    value: str
    of: tuple[str, ...] = ()

    def __str__(self) -> str:
        """As it is told: "gate b31"."""
        return f"{'/'.join(self.of)} {self.value}".strip()


@dataclass(frozen=True, slots=True)
class Stop:
    """One place of a wish.

    Attributes:
        what: the words that say what is wanted; empty is any place.
        kinds: what the words mean, as the tables call it.
        refused: kinds and names that are refused.
        without: places that are left out, as stops: “not the nearest one”, “not the north exit”.
        identity: names, codes and persons that must stand on the board.
        which: of several places; `rank` 2 is the second of that order.
        relation: to the anchor or, for BETWEEN, to both; None without one.
        anchor: stops themselves. PREVIOUS is the stop before.
        among: alternatives that are named, as stops: it is one of these, by the order: “the bank or the café”.
        same_side: whether it must hang on the anchor's side: “the second shop from the entrance, on that side”.
        start: where a way begins that does not begin here.
        ask: what is asked of it.
        contradiction: what cannot hold together, in words; empty where nothing is against anything.
        at: minutes of the day at one of which it must be open: “after 22:00”; empty where no time is said.
        floor: where it must lie, if that is said.
        unplaced: the words of `what` with those that name the floor, for maps of which no floors are known.
        whole: all words of the stop, its relation among them: what it says where the anchor turns out to be none.
        language: of the question that it is a part of, where that is known; a few words may be of any.
    """

    what: str
    kinds: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()
    without: tuple["Stop", ...] = ()
    identity: tuple[Identity, ...] = ()
    which: Which = Which.ANY
    rank: Annotated[int, Ge(1)] = 1
    relation: Relation | None = None
    anchor: tuple["Stop", ...] = ()
    start: "Stop | None" = None
    ask: Ask = Ask.WHERE
    whole: str = ""
    contradiction: str = ""
    at: tuple[Annotated[int, Ge(0), Lt(24 * 60)], ...] = ()
    floor: Floor | None = None
    unplaced: str = ""
    same_side: bool = False
    among: tuple["Stop", ...] = ()
    language: str | None = None


PREVIOUS = Stop("the stop before")
"""The anchor “it” of “then a café near it”."""


@dataclass(frozen=True, slots=True)
class Wish:
    """What a question means.

    Attributes:
        stops: in order.
        language: in which it was asked; None where that is not known.
        notes: what is not sure of it.
        instead: what it is where the map has not all of its stops: “before I go to the meeting, a coffee” is one then.
    """

    stops: tuple[Stop, ...]
    language: str | None = None
    notes: tuple[str, ...] = field(default=())
    instead: "Wish | None" = None

    def to_document(self) -> dict[str, Any]:
        """Return the wish as JSON."""
        return asdict(self)

    @classmethod
    def from_document(cls, tree: Mapping[str, Any]) -> "Wish":
        """Read a wish from JSON.

        Raises:
            ValueError: it is none.
        """
        if not _ends_within(tree, _DEEPEST):
            raise ValueError("this is no wish: anchors of anchors of anchors")
        # Loaded only here: it takes as long as many an answer.
        from pydantic import TypeAdapter, ValidationError

        try:
            return TypeAdapter(cls).validate_python(tree)
        except ValidationError as error:
            first = error.errors()[0]
            raise ValueError(f"this is no wish: {'.'.join(map(str, first['loc']))}: {first['msg']}") from error

    def __str__(self) -> str:
        """What was understood, in a line: "toilet, nearest, near (exit)"."""
        return "; then ".join(told(stop) for stop in self.stops) or "nothing"


def told(stop: Stop) -> str:
    """One stop in words."""
    if stop == PREVIOUS:
        return stop.what
    said = f"one of ({' or '.join(told(each) for each in stop.among)})" if stop.among else "any place"
    parts = [f"“{stop.what}”" if stop.what else said]
    if stop.kinds:
        parts.append(f"[{', '.join(stop.kinds)}]")
    if stop.identity:
        parts.append("must be " + " and ".join(map(str, stop.identity)))
    if stop.refused:
        parts.append("not " + ", ".join(stop.refused))
    if stop.without:
        parts.append("without " + " and ".join(f"({told(each)})" for each in stop.without))
    if stop.which is not Which.ANY:
        parts.append(stop.which.value if stop.rank == 1 else f"{stop.which.value} no. {stop.rank}")
    if stop.relation is not None:
        parts.append(f"{stop.relation.value} ({' and '.join(told(each) for each in stop.anchor)})")
        parts += [f"no. {stop.rank}"] if stop.rank > 1 and stop.which is Which.ANY else []
        parts += ["on its side"] if stop.same_side else []
    if stop.start is not None:
        parts.append(f"from ({told(stop.start)})")
    if stop.floor is not None:
        parts.append(f"on {stop.floor}")
    if stop.at:
        parts.append("open at " + " or ".join(f"{each // 60:02d}:{each % 60:02d}" for each in stop.at))
    if stop.contradiction:
        parts.append(f"contradicts itself: {stop.contradiction}")
    if stop.ask is not Ask.WHERE:
        parts.append(f"asks: {stop.ask.value}")
    return ", ".join(parts)


def _ends_within(tree: object, levels: int) -> bool:
    """Whether a part of a document holds no more than so many levels of others."""
    inner = tree.values() if isinstance(tree, Mapping) else tree if isinstance(tree, list | tuple) else ()
    return levels > 0 and all(_ends_within(each, levels - 1) for each in inner)


def with_meaning(stop: Stop, kinds: Sequence[str], refused: Sequence[str]) -> Stop:
    """Return the stop with what the tables make of its words."""
    return replace(stop, kinds=tuple(kinds), refused=tuple(refused))
