"""What a user should know of a run or an answer besides its result: one line each, for standard error."""

from collections.abc import Iterable, Sequence

from lpslam.frames import FrameFault
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.state import EventKind, SlamEvent, TrackedFrame
from lpslam.text.types import Landmark


def run_notes(
    world: LanguageMap, faults: Sequence[FrameFault], first_untracked: TrackedFrame | None, model: str
) -> list[str]:
    """Frames that were skipped, not tracked or not read, and names that another model gave than the one wanted.

    Args:
        world: the map that the run made.
        faults: of the source.
        first_untracked: the first frame without a pose; it says why.
        model: the language model that was asked for.
    """
    notes = fault_notes(faults)
    untracked = world.trajectory.frame_count - world.trajectory.tracked_count
    if first_untracked is not None and untracked:
        notes.append(
            f"{_frames(untracked)} not tracked; the first, frame {first_untracked.index}: {first_untracked.reason}"
        )
    unread = int(world.statistics["run"]["frames_unread_for_lack_of_time"])
    if unread:
        notes.append(f"{_frames(unread)} not read for lack of time; --sequential reads all that are due")
    abandoned = int(world.statistics["run"].get("keyframes_abandoned", 0))
    if abandoned:
        notes.append(f"{abandoned} keyframes left as they were: the machine was too slow to work them into the map")
    reading = world.statistics["reading"]
    if reading.get("reader_errors"):
        notes.append(f"text not read in {_frames(int(reading['reader_errors']))}; {reading['first_reader_error']}")
    later = [f"{note}; 'lpslam distill' asks for names again" for note in naming_notes(world, model)]
    return notes + event_notes(world.events) + later


def fault_notes(faults: Sequence[FrameFault]) -> list[str]:
    """How many frames were skipped, and why the first."""
    if not faults:
        return []
    return [f"{_frames(len(faults))} skipped; the first, frame {faults[0].index}: {faults[0].reason}"]


_WORTH_SAYING = {EventKind.LOST, EventKind.RELOCALISED, EventKind.NEW_SUBMAP, EventKind.MERGE}
_MOST_EVENTS = 8


def event_notes(events: Sequence[SlamEvent]) -> list[str]:
    """What happened to tracking and to the map that its user should know; the first few, and how many more."""
    said = [event for event in events if event.kind in _WORTH_SAYING]
    notes = [f"frame {event.frame}: {event.kind}, {event.reason}" for event in said[:_MOST_EVENTS]]
    more = len(said) - len(notes)
    return [*notes, f"{more} more such events; 'lpslam info MAP --json' lists all"] if more > 0 else notes


def naming_notes(world: LanguageMap, model: str) -> list[str]:
    """Say so when names in long-term memory are not by the language model that was asked for."""
    namings = [each.naming for each in world.text.long_term if each.naming is not None]
    return _instead("names", [(each.model, each.evidence) for each in namings], model)


def judging_notes(landmarks: Sequence[Landmark], question: str, model: str) -> list[str]:
    """Say so when judgements are not by the language model that was asked for."""
    given = [mark.judgements[question] for mark in landmarks if question in mark.judgements]
    if given and all(not each.answer and each.confidence == 0.0 for each in given):
        return [f"“{question}”: {given[0].evidence}"]
    return _instead("judgements", [(each.model, each.evidence) for each in given], model)


def _instead(what: str, given: Iterable[tuple[str, str]], model: str) -> list[str]:
    given = list(given)
    others = [(other, evidence) for other, evidence in given if other != model]
    if not others:
        return []
    return [f"{len(others)} of {len(given)} {what} are not by {model} but by {others[0][0]}: {others[0][1]}"]


def _frames(count: int) -> str:
    return "1 frame" if count == 1 else f"{count} frames"
