"""Which landmarks are listed: by words, by judgement, by where they stand, page by page."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from lpslam.language.sanitise import clean_text
from lpslam.serving.atlas import ServedMap
from lpslam.text.types import Landmark

Judged = Literal["yes", "no", "unjudged"]


@dataclass(frozen=True, slots=True)
class Filter:
    """What is wanted of a list of landmarks; all of it must hold.

    Attributes:
        text: stands on the board, whatever its case.
        role: of the line that it is called by.
        judged: the map's current judgement.
        near: metres, map frame, (x, y) or (x, y, z): nearest first.
        within: metres from there.
        least_confidence: 0 to 1, of the name.
        page: counted from 1.
        size: landmarks a page.
    """

    text: str = ""
    role: str | None = None
    judged: Judged | None = None
    near: tuple[float, ...] | None = None
    within: float | None = None
    least_confidence: float = 0.0
    page: int = 1
    size: int = 50


@dataclass(frozen=True, slots=True, eq=False)
class Listed:
    """A page of landmarks, as JSON has them.

    Attributes:
        total: landmarks on all pages.
        records: of this page; with `distance` in metres where the filter says near what.
    """

    total: int
    records: list[dict[str, Any]]


_LONGEST = 200  # letters of a text that is looked for
_JUDGED: dict[Judged, bool | None] = {"yes": True, "no": False, "unjudged": None}


def listed(served: ServedMap, wanted: Filter) -> Listed:
    """The landmarks of a map that a filter leaves, a page of them."""
    marks = served.directory.landmarks
    text = clean_text(wanted.text, _LONGEST).casefold()
    kept = [at for at, mark in enumerate(marks) if text in served.words[at] and _fits(mark, wanted)]
    apart = distances(marks, kept, wanted.near) if wanted.near is not None else None
    if apart is not None:
        order = np.argsort(apart, kind="stable")
        if wanted.within is not None:
            order = order[apart[order] <= wanted.within]
        kept, apart = [kept[at] for at in order.tolist()], apart[order]
    first = (wanted.page - 1) * wanted.size
    shown = range(len(kept))[first : first + wanted.size]
    records = [
        served.records[kept[at]] | ({} if apart is None else {"distance": round(float(apart[at]), 3)}) for at in shown
    ]
    return Listed(len(kept), records)


def _fits(mark: Landmark, wanted: Filter) -> bool:
    if wanted.role is not None and mark.role != wanted.role:
        return False
    if wanted.judged is not None and mark.is_landmark is not _JUDGED[wanted.judged]:
        return False
    return mark.confidence >= wanted.least_confidence


def distances(marks: Sequence[Landmark], rows: Sequence[int], point: tuple[float, ...]) -> NDArray[np.float64]:
    """(n,) metres from a point to some landmarks: on the floor plan where the point has two numbers, else in space."""
    places = np.array([marks[row].position for row in rows]).reshape(-1, 3)[:, : len(point)]
    return np.asarray(np.linalg.norm(places - np.array(point), axis=1), dtype=np.float64)
