"""Which landmarks may be answered with: none that commands, those that warn where that is asked; which are open."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.languages import LATIN
from lpslam.language.model import Candidate
from lpslam.language.questions.phrasing import phrases_in
from lpslam.language.signs.distrust import commands
from lpslam.language.signs.hours import Hours, board_hours, told_hours
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.wishes.form import Ask, Stop
from lpslam.language.wishes.served import Served

_OPEN_SERVES = 0.8  # of the best score: what is known to be open and serves so well goes before what may be shut
_OFFERED = 5  # places that are told where none is known to be open


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
        return Served(
            stop,
            self._places,
            "any place" if self._landmarks else phrases_in(stop.language or "en").say("empty_map"),
            0.9,
        )

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
    return standing("|".join(rows), re.IGNORECASE)


class Opening:
    """The hours of one set of landmarks."""

    def __init__(self, landmarks: Sequence[Candidate]) -> None:
        self._landmarks = landmarks
        self._names = {mark.id: mark.name for mark in landmarks}

    @cached_property
    def _hours(self) -> Mapping[int, tuple[Hours, ...]]:
        """What boards say of their hours; those that say nothing are not in it."""
        said = {
            mark.id: tuple(hours for text in (mark.name, *mark.lines) for hours in board_hours(text))
            for mark in self._landmarks
        }
        return {id_: hours for id_, hours in said.items() if hours}

    def open(self, served: Served) -> Served:
        """Of what serves, what is open when it is asked for; where that is not said of any, what may be."""
        best = max(served.scores.values(), default=0.0)
        is_open = {
            id_: any(each.holds(minute) for each in self._hours[id_] for minute in served.stop.at)
            for id_ in served.scores
            if id_ in self._hours
        }
        sure = {
            id_: served.scores[id_] for id_ in is_open if is_open[id_] and served.scores[id_] >= _OPEN_SERVES * best
        }
        if sure or not served.scores:
            return replace(served, scores=sure)
        if is_open and served.stop.ask is Ask.WHETHER:
            # “Is the bar open at three?” is a question about the bar: it is answered by its hours.
            told = ", ".join(dict.fromkeys(told_hours(self._hours[id_]) for id_ in is_open))
            return replace(served, ignored=(*served.ignored, f"that it is shut then, by its board ({told})"))
        left = {
            id_: score for id_, score in served.scores.items() if id_ not in is_open and score >= _OPEN_SERVES * best
        }
        if left and served.stop.what:
            return replace(
                served, scores=left, ignored=(*served.ignored, "when it is open, which its board does not say")
            )
        shut = sorted(is_open, key=lambda id_: (-served.scores[id_], id_))
        told = "; ".join(f"{self._names[id_]}: {told_hours(self._hours[id_])}" for id_ in shut[:1])
        evidence = f"nothing that serves is known to be open then ({told})" if told else "no board says its hours"
        return replace(served, scores={}, evidence=evidence, confidence=0.9, others=tuple(shut[:_OFFERED]))
