"""Answers to questions, as text in the language of the question and as JSON."""

from dataclasses import asdict
from typing import Any

from lpslam.language.questions.phrasing import Phrases, answer_language, phrases_in
from lpslam.language.wishes.form import LISTED
from lpslam.mapfile.export import landmark_record
from lpslam.navigation.asking import Answer
from lpslam.text.types import Landmark
from lpslam.views.drawable import printable

_INSTEAD = " (instead of "


def answer_text(
    answer: Answer, language: str | None = None, *, is_further: bool = False, understood: bool = False
) -> str:
    """A few lines: where to go, how far and in which direction it is, why, and what else there is.

    Args:
        answer: to say.
        language: tag of the language to say it in; the question's without.
        is_further: whether something else was named before.
        understood: whether to say first what was understood of the question.
    """
    phrases = phrases_in(language or answer_language(answer.question))
    why = printable(phrases.reasons(answer.choice.evidence), longest=300)
    others = phrases.join([_other(mark, answer, phrases) for mark in answer.alternatives])
    embedded, _, absent = answer.choice.model.partition(_INSTEAD)
    if answer.landmark is not None and answer.wish.stops[-1].ask in LISTED:
        shown = [_other(mark, answer, phrases) for mark in (answer.landmark, *answer.alternatives)]
        lines, others, more = [f"- {each}" for each in shown], "", ""
    elif answer.landmark is None:
        nothing = phrases.say("no_further") if is_further else phrases.say("nothing", why=why)
        lines = [nothing]
        more = "nothing_near"
    else:
        x, y, z = (f"{value:.2f}" for value in answer.landmark.position)
        direction = _direction(answer.landmark, answer, phrases)
        name = printable(answer.landmark.name)
        lines = [phrases.say("found", name=name, x=x, y=y, z=z, distance=f"{answer.distance:.1f}", direction=direction)]
        if answer.same_name > 1:
            lines.append("  " + phrases.say("same_name", count=answer.same_name))
        sure = phrases.say("confidence", sure=f"{answer.choice.confidence:.2f}", model=printable(embedded, longest=100))
        lines.append(f"  {phrases.say('because', why=why)} ({sure})")
        more = "alternatives"
    if len(answer.stops) > 1:
        lines[0] = f"{len(answer.stops)}. {lines[0]}"
    lines = [*_stops_before(answer), *lines]
    if understood:
        lines.insert(0, f"? {printable(str(answer.wish), longest=400)}")
    if absent:
        lines.append("  " + phrases.say("instead", model=printable(absent.removesuffix(")"), longest=100)))
    return "\n".join([*lines, "  " + phrases.say(more, others=others)] if others else lines)


def _stops_before(answer: Answer) -> list[str]:
    """The stops of a plan before its last, one a line."""
    earlier = zip(answer.wish.stops, answer.stops, strict=True) if len(answer.stops) > 1 else ()
    lines = [
        f"{at}. {printable(stop.what)}: {'-' if mark is None else printable(mark.name)}"
        + ("" if mark is None else " ({:.2f}, {:.2f}, {:.2f})".format(*mark.position))
        for at, (stop, mark) in enumerate(earlier, 1)
    ]
    return lines[:-1]


def _other(mark: Landmark, answer: Answer, phrases: Phrases) -> str:
    return phrases.say(
        "near",
        name=printable(mark.name),
        distance=f"{answer.distance_to(mark):.1f}",
        direction=_direction(mark, answer, phrases),
    )


def _direction(mark: Landmark, answer: Answer, phrases: Phrases) -> str:
    degrees = answer.direction_to(mark)
    return (
        phrases.direction(degrees) if answer.heading is not None else phrases.say("bearing", degrees=f"{degrees:.0f}")
    )


def answer_record(answer: Answer) -> dict[str, Any]:
    """The answer as JSON can hold it; metres, degrees counter-clockwise."""
    is_relative = answer.heading is not None
    return {
        "question": answer.question,
        "landmark": landmark_record(answer.landmark) if answer.landmark is not None else None,
        "distance": answer.distance,
        "direction": round(answer.direction_to(answer.landmark), 1) if answer.landmark is not None else None,
        "direction_is_from": "heading" if is_relative else "map x axis",
        "asked_from": [round(float(value), 4) for value in answer.here],
        "choice": asdict(answer.choice),
        "wish": answer.wish.to_document(),
        "stops": [None if mark is None else mark.id for mark in answer.stops],
        "alternatives": [mark.name for mark in answer.alternatives],
        "alternative_ids": [mark.id for mark in answer.alternatives],
    }
