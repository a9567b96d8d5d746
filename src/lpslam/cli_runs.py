"""What commands of the command line do after their options have been checked."""

import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import typer

from lpslam.config import SimulationConfig
from lpslam.errors import LpSlamError, UserError
from lpslam.interruption import INTERRUPTED
from lpslam.interruption import end as end_at_once
from lpslam.views.printed import forget_output, print_json, print_table, say

_UsageError: Any = typer.BadParameter.__mro__[1]
"""What a mistake in the words of the command line is raised as; typer has had it from click, and has its own now."""


def call_to_its_end(work: Callable[[], object]) -> None:
    """Do what a command line says; each failure that is the user's or the system's becomes one line and exit code 2."""
    try:
        try:
            work()
        finally:
            sys.stdout.flush()
    except LpSlamError as error:
        say(str(error))
        raise SystemExit(2) from None
    except typer.Exit as end:
        if end.exit_code == INTERRUPTED:
            # What was told to stop has said how far it came.
            end_at_once(is_said=True)
        raise SystemExit(end.exit_code) from None
    except KeyboardInterrupt:
        end_at_once()
    except BrokenPipeError:
        forget_output()
        raise SystemExit(1) from None
    except MemoryError:
        say("there is not enough memory for that: ask for less, or for smaller values in --config")
        forget_output()
        raise SystemExit(2) from None
    except OSError as error:
        # Commands name the file that they cannot write; what is left is a full disk under all else.
        say(f"{error.filename or 'writing'}: {error.strerror or error}")
        forget_output()
        raise SystemExit(2) from None


class _AsItStands:
    """Takes a text, a path or a switch as it stands: typer's own way loads pydantic for it, a tenth of an answer."""

    def __init__(self, kind: type) -> None:
        self._kind = kind

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        return value if value is None or isinstance(value, self._kind) else self._kind(value)


def parse_and_call(app: typer.Typer) -> None:
    """Call what the words of the command line say.

    Raises:
        UserError: they say nothing that there is.
    """
    command: Any = typer.main.get_command(app)
    for each in (
        param for one in (command, *command.commands.values()) for param in one.get_params(typer.Context(one))
    ):
        kind = getattr(getattr(each, "type_descriptor", None), "annotation", None)
        if kind in (str, Path, bool) and each.nargs == 1 and not each.multiple:
            each._runtime_param = _AsItStands(kind)
    try:
        # `app()` would print a mistake as a box of five lines, and end the process by itself.
        with command.make_context("lpslam", sys.argv[1:]) as context:
            command.invoke(context)
    except _UsageError as error:
        reason = error.format_message().rstrip(".")
        where = error.ctx.command_path if error.ctx is not None else "lpslam"
        raise UserError(f"{reason[:1].lower()}{reason[1:]}; see '{where} --help'") from None


def partial_name(output: Path) -> Path:
    """Where the map of a run that was stopped goes: a whole one is not replaced by a part."""
    return output.with_name(f"{output.stem}.partial{output.suffix or '.lpmap'}")


def keep(world: Any, output: Path, is_held: bool = False, landmarks: Any = None) -> None:
    """Save a map; where that cannot be done any more, it goes to the folder for temporary files.

    Args:
        world: to save.
        output: where to; whoever changes a map there is waited for.
        is_held: whether the caller keeps others from it already.
        landmarks: of the map, where they are at hand; they go to the user's cache, for whoever asks the map.

    Raises:
        UserError: it is not where it should be; says where it is.
    """
    from lpslam.mapfile.correcting import editing
    from lpslam.navigation.known import remember

    try:
        with nullcontext() if is_held or not output.exists() else editing(output):
            identity = world.save(output)
    except UserError as error:
        rescue = Path(tempfile.mkdtemp(prefix="lpslam-")) / output.name
        try:
            world.save(rescue)
        except UserError:
            shutil.rmtree(rescue.parent, ignore_errors=True)
            raise error from None
        raise UserError(f"{error}; nothing is lost: the map is in {rescue}") from error
    remember(world, identity, landmarks)


def map_for(localize: Path | None, continued: Path | None, frames: Any, settings: Any) -> tuple[Any, Any]:
    """The saved map that a recording is localised in, or that it continues, and its frames as the map's camera sees.

    None without a map; the frames as they are then.
    """
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.pipeline import seen_by_map

    path = localize or continued
    if path is None:
        return None, frames
    world = LanguageMap.load(path)
    allowed = settings.same_camera if localize else settings.continued_camera
    frames, note = seen_by_map(frames, world, path, allowed)
    if note:
        say(note)
    return world, frames


def say_usage(language: Any) -> None:
    """What a hosted model has cost; nothing of one that costs nothing."""
    from lpslam.language.hosted.usage import usage_of

    usage = usage_of(language)
    if usage is not None and (usage.calls or usage.saved):
        say(f"{language.model}: {usage}")


def localise_recording(
    frames: Any,
    world: Any,
    settings: Any,
    map_file: Path,
    trajectory: Path,
    *,
    text: bool,
    is_endless: bool,
    as_json: bool,
) -> None:
    """Find a camera in a saved map, write its poses and print how many were found; an endless one ends by Ctrl-C."""
    from lpslam import pipeline
    from lpslam.views.notes import event_notes, fault_notes
    from lpslam.views.run_progress import InterruptFlag, RunProgress, prepare

    prepare()
    with InterruptFlag() as interrupted, RunProgress(len(frames)) as progress:
        found = pipeline.localise(
            frames,
            world,
            settings,
            text=text,
            on_progress=progress.update,
            should_stop=interrupted.is_set,
        )
        if not len(found.poses) and not interrupted.is_set():
            raise UserError(
                f"{frames.name}: none of {found.frames} frames is found in {map_file}; nothing is written: is it the"
                " same place?"
            )
        found.poses.to_tum_file(trajectory, [f"camera optical frame in the frame of {map_file.name}"])
    for note in fault_notes(frames.faults) + event_notes(found.events):
        say(note)
    facts = {
        "map": str(map_file),
        "trajectory": str(trajectory),
        "frames": found.frames,
        "frames_localised": len(found.poses),
        "milliseconds_a_frame": round(1000 * found.seconds_tracking / max(found.frames, 1), 1),
    }
    if as_json:
        print_json(facts)
    else:
        print_table({what.replace("_", " "): str(value) for what, value in facts.items()})
    if interrupted.is_set() and not is_endless:
        raise typer.Exit(INTERRUPTED)


def render_simulation(
    folder: Path,
    seed: int,
    frames: int | None,
    options: SimulationConfig,
    world: int | None,
    factors: list[str],
    *,
    as_json: bool,
) -> None:
    """Render a mall of `options`, or the world of a seed with some factors given as NAME=VALUE, and say what it has."""
    from lpslam.simulation.source import MallSource
    from lpslam.simulation.writer import refuse_recording, write_sequence
    from lpslam.views.run_progress import counting

    refuse_recording(folder)
    written: dict[str, Any] = {"written": str(folder)}
    if world is None:
        if factors:
            raise UserError("option --factor: malls have none; give --world SEED too")
        with counting("building the mall") as progress:
            mall = MallSource(seed, frames, options=options)
            write_sequence(mall, folder, progress)
        written |= {"frames": len(mall), "signs": len(mall.signs)}
    else:
        written |= _render_world(folder, world, frames, factors)
    if as_json:
        print_json(written)
    else:
        print_table({what: str(value) for what, value in written.items()})


def render_fronts(folder: Path, seed: int, fronts: Path, options: SimulationConfig, *, as_json: bool) -> None:
    """Render a walk past the labelled pictures of a folder, as many as hang on one wall, and say what it has."""
    from lpslam.simulation.boards.labels import read_labelled
    from lpslam.simulation.boards.street import StreetSource, write_distractors
    from lpslam.simulation.writer import refuse_recording, write_sequence
    from lpslam.views.run_progress import counting

    refuse_recording(folder)
    boards = read_labelled(fronts)
    with counting("building the street") as progress:
        street = StreetSource(seed, boards, options=options)
        write_sequence(street, folder, progress)
        write_distractors(folder, street.distractors)
    hung = f"{len(street.boards)} of {len(boards)}"
    written = {"written": str(folder), "frames": len(street), "signs": len(street.signs), "boards": hung}
    if as_json:
        print_json(written)
    else:
        print_table({what: str(value) for what, value in written.items()})


def _render_world(folder: Path, seed: int, frames: int | None, factors: list[str]) -> dict[str, Any]:
    from lpslam.simulation.worlds.factors import FACTORS, draw_world
    from lpslam.simulation.worlds.source import WorldSource
    from lpslam.simulation.worlds.writing import write_world
    from lpslam.views.run_progress import counting

    given = dict(factor.partition("=")[::2] for factor in factors)
    if unknown := set(given) - set(FACTORS):
        raise UserError(f"option --factor: {min(unknown)} is no factor; there are {', '.join(FACTORS)}")
    world = draw_world(seed, **given)
    if frames is not None:
        world = draw_world(seed, **given, seconds=frames / world.fps)
    with counting("building the world") as progress:
        source = WorldSource(world)
        write_world(source, folder, progress)
    return {"frames": len(source), "signs": len(source.signs), **world.factors()}
