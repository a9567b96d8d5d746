"""A question as every face takes it, and the answer as `lpslam ask --json` gives it."""

import json
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError
from lpslam.language.model import LanguageModel
from lpslam.language.offline import OfflineModel, embedded_model
from lpslam.language.questions.phrasing import FollowUp, follow_up, phrases_in
from lpslam.language.wishes.form import Wish
from lpslam.navigation.asking import answer
from lpslam.navigation.directory import Directory
from lpslam.views.answers import answer_record, answer_text


@dataclass(frozen=True, slots=True)
class Asked:
    """A question, and by whom.

    Attributes:
        question: in any language.
        before: the question before it, where it may mean more of the same.
        position: metres, map frame, (x, y) or (x, y, z), where the asker stands; where the camera was last without.
        heading: degrees counter-clockwise from the map's x axis, which way the asker looks.
        excluded: ids of landmarks that were named before.
        wish: what the question means, where the asker has corrected what was understood: JSON, as `wish_text` gives it.
        before_wish: what the question before it means, where the asker has corrected that; counts where more of
            the same is asked.
    """

    question: str
    before: str | None = None
    position: tuple[float, ...] | None = None
    heading: float | None = None
    excluded: tuple[int, ...] = ()
    wish: str | None = None
    before_wish: str | None = None


class Known(Protocol):
    """What an answer needs of a served map."""

    @property
    def name(self) -> str:
        """Under which it is served."""
        ...

    @property
    def version(self) -> str:
        """Of its file."""
        ...

    @property
    def directory(self) -> Directory:
        """Its landmarks."""
        ...

    @property
    def view(self) -> tuple[NDArray[np.float64], float]:
        """Where the camera was last, (3,) map frame, and its heading in radians."""
        ...


_MOST_STOPS = 24  # of a wish that somebody sends, those within others among them: no question has as many


def wish_text(document: Any) -> str:
    """A wish that was sent, as `Asked` has it.

    Raises:
        UserError: it is none, or has too many stops.
    """
    try:
        wish = Wish.from_document(document)
    except ValueError as error:
        raise UserError(f"wish: {' '.join(str(error).split())[:200]}; send one as an answer has it") from error
    if not len(wish.stops) > 0 or _stops(document) > _MOST_STOPS:
        raise UserError(f"wish: it may have 1 to {_MOST_STOPS} stops, those within others among them")
    return json.dumps(wish.to_document(), separators=(",", ":"))


def _stops(tree: Any) -> int:
    """How many stops there are in a part of a wish."""
    if isinstance(tree, dict):
        return ("what" in tree) + sum(map(_stops, tree.values()))
    return sum(map(_stops, tree)) if isinstance(tree, list | tuple) else 0


def _wish_of(asked: Asked, read: FollowUp) -> Wish | None:
    """What the asker has said that is meant; None where the question is to be read."""
    said = asked.wish or (asked.before_wish if read.keeps else None)
    return None if said is None else Wish.from_document(json.loads(said))


def _kinds_said(wish: Wish, language: str) -> dict[str, str]:
    """What the kinds that are wanted and refused are called in a language."""
    kinds = dict.fromkeys(kind for stop in wish.stops for kind in (*stop.kinds, *stop.refused))
    return {kind: phrases_in(language).things([kind]) for kind in kinds}


def understood(asked: Asked, language: LanguageModel) -> dict[str, Any]:
    """What is understood of a question, before any map is looked at."""
    model = language if isinstance(language, OfflineModel) else embedded_model()
    read = follow_up(asked.question, asked.before)
    wish = _wish_of(asked, read) or model.read_wish(read.question)
    return {"wish": wish.to_document(), "words": str(wish)}


def answered(asked: Asked, served: Known, language: LanguageModel, longest: int) -> dict[str, Any]:
    """The answer, with its words in the question's language.

    Args:
        asked: the question.
        served: the map.
        language: says which names serve.
        longest: letters of a question that are read.

    Raises:
        UserError: the question is empty.
    """
    read = follow_up(asked.question, asked.before)
    named = frozenset(asked.excluded) if read.keeps else frozenset()
    found = answer(
        read.question,
        served.directory,
        served.view,
        language,
        None if asked.position is None else np.array(asked.position, dtype=np.float64),
        None if asked.heading is None else float(np.radians(asked.heading)),
        named,
        wish=_wish_of(asked, read),
    )
    notes = []
    if len(asked.question) > longest:
        notes.append(f"the question has {len(asked.question):,} letters; its first {longest} are read")
    return {
        "map": served.name,
        "version": served.version,
        "text": answer_text(found, read.language, is_further=bool(named)),
        "understood": str(found.wish),
        "kinds": _kinds_said(found.wish, read.language),
        "notes": notes,
        "answer": answer_record(found),
    }
