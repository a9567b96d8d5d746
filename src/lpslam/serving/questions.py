"""A question as every face takes it, and the answer as `lpslam ask --json` gives it."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lpslam.language.model import LanguageModel
from lpslam.language.offline import OfflineModel, embedded_model
from lpslam.language.questions.follow_up import follow_up
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
    """

    question: str
    before: str | None = None
    position: tuple[float, ...] | None = None
    heading: float | None = None
    excluded: tuple[int, ...] = ()


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


def understood(asked: Asked, language: LanguageModel) -> dict[str, Any]:
    """What is understood of a question, before any map is looked at."""
    model = language if isinstance(language, OfflineModel) else embedded_model()
    wish = model.read_wish(follow_up(asked.question, asked.before).question)
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
    )
    notes = []
    if len(asked.question) > longest:
        notes.append(f"the question has {len(asked.question):,} letters; its first {longest} are read")
    return {
        "map": served.name,
        "version": served.version,
        "text": answer_text(found, read.language, is_further=bool(named)),
        "understood": str(found.wish),
        "notes": notes,
        "answer": answer_record(found),
    }
