"""The command `lpslam run`, by which maps are made."""

from pathlib import Path
from typing import Annotated

import typer

from lpslam.cli_checks import (
    config_of,
    refuse_old_map,
    refuse_overwriting,
    refuse_with_localize,
)
from lpslam.cli_options import ConfigFile, Json, Llm
from lpslam.cli_runs import keep, localise_recording, map_for, partial_name, say_usage
from lpslam.cli_serving import unwatched, watched
from lpslam.cli_sources import Color, Depth, From, Info, To, topics_and_span
from lpslam.cli_watching import Foxglove, Mcap, Rerun, each_of, refuse_watching, watchers_of
from lpslam.interruption import INTERRUPTED
from lpslam.views.printed import print_facts, say


def run(
    source: Annotated[
        Path,
        typer.Argument(metavar="SOURCE", help="A bag, a folder or a camera; see 'lpslam sources'.", show_default=False),
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="MAP.lpmap", help="Where the map goes.")
    ] = None,
    continued: Annotated[
        Path | None, typer.Option("--continue", metavar="MAP", help="Let this map grow; it is read, not overwritten.")
    ] = None,
    localize: Annotated[
        Path | None, typer.Option("--localize", metavar="MAP", help="Map nothing: find the camera in this map.")
    ] = None,
    trajectory: Annotated[
        Path | None, typer.Option("--trajectory", metavar="OUT.txt", help="Write the camera's poses (TUM format).")
    ] = None,
    camera: Annotated[
        Path | None, typer.Option("--camera", metavar="FILE", help="Calibration to use instead of the recording's.")
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="At the recording's pace, as from a camera: drops frames when late.")
    ] = False,
    sequential: Annotated[
        bool, typer.Option("--sequential", help="Read in step with tracking: slower, the same map every time.")
    ] = False,
    mcap: Mcap = None,
    rerun: Rerun = None,
    foxglove: Foxglove = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a map that is there already.")] = False,
    no_text: Annotated[bool, typer.Option("--no-text", help="Track and map only; read nothing.")] = False,
    max_frames: Annotated[int | None, typer.Option("--max-frames", min=1, help="Use only the first N frames.")] = None,
    view: Annotated[bool, typer.Option("--view", help="Show the map while it grows, on a page that answers.")] = False,
    port: Annotated[int, typer.Option(min=0, max=65535, help="Of the page of --view; 0 for any.")] = 8765,
    start: From = None,
    end: To = None,
    color: Color = None,
    depth: Depth = None,
    info: Info = None,
    llm: Llm = None,
    config: ConfigFile = None,
    as_json: Json = False,
) -> None:
    """Map a recording: track the camera, read the scene's text, remember it and place it.

    With --continue a map grows by another recording of the same camera; with --localize it is only read.
    """
    from lpslam.errors import UserError
    from lpslam.language.registry import language_model
    from lpslam.mapfile.container import refuse_foreign_file
    from lpslam.sources.in_order import InOrder
    from lpslam.sources.live.source import camera_in
    from lpslam.sources.open import open_source

    # A mistake shows before anything slow is loaded.
    if localize is not None:
        refuse_with_localize(output, continued, live, view, trajectory)
    elif output is None:
        raise UserError("where should the map go? give --output MAP.lpmap (or --localize MAP to use one as it is)")
    else:
        refuse_foreign_file(output)
    if live and sequential:
        raise UserError("--live and --sequential exclude each other: a camera does not wait for reading")
    refuse_overwriting(output, trajectory, continued or localize)
    if output is not None:
        refuse_old_map(output, force)
    refuse_watching(mcap, rerun, foxglove, force, localize, [source, output, continued, trajectory])
    settings = config_of(config)
    options = topics_and_span(color, depth, info, start, end, settings.pairing)
    frames = InOrder(open_source(source, camera, max_frames, settings.calibration, options), settings.times)
    base, frames = map_for(localize, continued, frames, settings)
    is_endless = camera_in(frames) is not None
    if localize is not None and trajectory is not None:
        localise_recording(
            frames, base, settings, localize, trajectory, text=not no_text, is_endless=is_endless, as_json=as_json
        )
        return
    assert output is not None
    language = language_model(llm, settings.language)

    from lpslam import pipeline
    from lpslam.views.notes import run_notes
    from lpslam.views.run_progress import InterruptFlag, RunProgress, prepare

    watch = watched(frames.name, len(frames), port, settings, llm) if view else unwatched()
    with (
        watch as feed,
        RunProgress(len(frames)) as progress,
        watchers_of(mcap, rerun, foxglove, frames) as watchers,
    ):
        # Until the first frame there is nothing to keep: Ctrl-C ends at once.
        prepare()
        with InterruptFlag() as interrupted:
            world = pipeline.run(
                frames,
                settings,
                language=language,
                text=not no_text,
                sequential=sequential,
                live=live,
                base=base,
                on_progress=progress.update,
                on_step=each_of(watchers.take, feed.on_step),
                should_stop=interrupted.is_set,
            )
            watchers.finish(world)
            if not world.trajectory.tracked_count:
                say("interrupted before anything was mapped; nothing is written")
                raise typer.Exit(INTERRUPTED)
            # A camera has no other end.
            is_broken_off = interrupted.is_set() and not is_endless
            if is_broken_off:
                output = partial_name(output)
            keep(world, output)
            feed.end(world, output.name)
    for note in run_notes(world, frames.faults, progress.first_untracked, language.model):
        say(note)
    say_usage(language)
    if trajectory is not None:
        world.frame_poses().to_tum_file(trajectory, ["camera optical frame in the map frame"])
    print_facts(world, output, as_json)
    if is_broken_off:
        say(f"interrupted; the map so far is in {output}")
        raise typer.Exit(INTERRUPTED)
