"""Which landmarks may be answered with: none that speaks to a machine, and those that warn only where that is asked."""

import re
from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.languages import LATIN
from lpslam.language.model import Candidate
from lpslam.language.signs.distrust import commands
from lpslam.language.tables.lexicon import read_table
from lpslam.language.wishes.form import Ask, Stop
from lpslam.language.wishes.served import Served


class Trust:
    """What may be trusted of one set of landmarks."""

    def __init__(self, landmarks: Sequence[Candidate], index: LandmarkIndex) -> None:
        self._landmarks, self._index = landmarks, index
        self._by_id = {mark.id: mark for mark in landmarks}
        self._heard: set[int] = set()
        self._commanding: set[int] = set()

    def of(self, scores: Mapping[int, float]) -> dict[int, float]:
        """Return those that do not speak to a machine."""
        # Sets that only grow: threads that ask at the same time add the same.
        for id_ in () if self._heard.issuperset(scores) else scores.keys() - self._heard:
            if commands(self._by_id[id_].name) is not None:
                self._commanding.add(id_)
            self._heard.add(id_)
        if self._commanding.isdisjoint(scores):
            return dict(scores)
        return {id_: score for id_, score in scores.items() if id_ not in self._commanding}

    def any_place(self, stop: Stop) -> Served:
        """Return what serves a stop that names no kind: any place, or what warns or keeps people out."""
        if stop.ask is Ask.FORBIDDEN:
            return Served(stop, dict.fromkeys(sorted(self._warning), 1.0), "what warns or forbids", 0.9)
        if stop.ask is Ask.BARRED:
            return Served(stop, dict.fromkeys(sorted(barred(self._landmarks)), 1.0), "its board keeps people out", 0.9)
        return Served(stop, self._places, "any place", 0.9)

    @cached_property
    def _warning(self) -> frozenset[int]:
        return frozenset(id_ for id_, sign in self._index.signs.items() if sign.warns)

    @cached_property
    def _places(self) -> Mapping[int, float]:
        """All places that neither warn nor speak to a machine."""
        places = [mark.id for mark in self._landmarks if mark.id not in self._warning]
        return self.of(dict.fromkeys(places, 1.0))


def barred(landmarks: Sequence[Candidate]) -> frozenset[int]:
    """Return the landmarks of which a line keeps people out, in any language: “Staff only”, 立入禁止."""
    pattern = _barring()
    return frozenset(
        mark.id for mark in landmarks if any(pattern.search(text) is not None for text in (mark.name, *mark.lines))
    )


@lru_cache(maxsize=1)
def _barring() -> re.Pattern[str]:
    said: dict[str, str] = read_table("wishes/barred.json")
    rows = (rf"(?<!\w)(?:{row})" if language in LATIN else row for language, row in said.items())
    return re.compile("|".join(rows), re.IGNORECASE)
