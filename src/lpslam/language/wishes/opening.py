"""What is open when it is asked for, by the hours on boards."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from lpslam.language.model import Candidate
from lpslam.language.signs.hours import Hours, board_hours, told_hours
from lpslam.language.wishes.form import Ask
from lpslam.language.wishes.served import Served

_OPEN_SERVES = 0.8  # of the best score: what is known to be open and serves so well goes before what may be shut
_OFFERED = 5  # places that are told where none is known to be open


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
