"""The options that write down a run while it goes."""

from collections.abc import Callable, Sequence
from os.path import realpath
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lpslam.errors import MissingExtraError, UserError
from lpslam.views.printed import say
from lpslam.whole_files import refuse_unwritable

if TYPE_CHECKING:
    from lpslam.frames import FrameSource
    from lpslam.watching.watchers import Watchers

Mcap = Annotated[
    Path | None, typer.Option("--mcap", metavar="FILE.mcap", help="Write the run for Foxglove while it goes.")
]
Rerun = Annotated[
    Path | None, typer.Option("--rerun", metavar="FILE.rrd", help="The same for Rerun's viewer; extra 'rerun'.")
]
Foxglove = Annotated[
    int | None,
    typer.Option(
        "--foxglove",
        metavar="PORT",
        min=0,
        max=65535,
        help="Serve the run to Foxglove's viewer on this machine while it goes; 0 for any port; extra 'foxglove'.",
    ),
]


def refuse_watching(
    mcap: Path | None,
    rerun: Path | None,
    foxglove: int | None,
    force: bool,
    localize: Path | None,
    others: Sequence[Path | None],
) -> None:
    """What is written while a run goes replaces nothing unasked, and no other file of the run."""
    from importlib.util import find_spec

    taken = [realpath(path) for path in others if path is not None]
    for option, path in (("--mcap", mcap), ("--rerun", rerun)):
        if path is None:
            continue
        if localize is not None:
            raise UserError(f"--localize and {option} exclude each other: nothing is mapped")
        refuse_unwritable(path)
        if realpath(path) in taken:
            raise UserError(f"{option} {path} is another file of this run; choose another name")
        if path.exists() and not force:
            raise UserError(f"{path} is there already; choose another name, or give --force to replace it")
        taken.append(realpath(path))
    if rerun is not None and find_spec("rerun") is None:
        raise MissingExtraError("--rerun", "rerun")
    if foxglove is not None and localize is not None:
        raise UserError("--localize and --foxglove exclude each other: nothing is mapped")
    if foxglove is not None and find_spec("foxglove") is None:
        raise MissingExtraError("--foxglove", "foxglove")


def each_of(*takers: Callable[..., Any]) -> Callable[..., None]:
    """One call for several, in their order."""

    def take(*told: Any) -> None:
        for taker in takers:
            taker(*told)

    return take


def watchers_of(mcap: Path | None, rerun: Path | None, foxglove: int | None, frames: "FrameSource") -> "Watchers":
    """Who watches the run, as was asked for."""
    from lpslam.watching.watchers import Watcher, Watchers

    watchers: list[Watcher] = []
    if mcap is not None:
        from lpslam.watching.mcap_file import McapWatcher

        watchers.append(McapWatcher(mcap, frames.camera))
    if rerun is not None:
        from lpslam.watching.rerun_file import RerunWatcher

        watchers.append(RerunWatcher(rerun, frames.camera, frames.name))
    if foxglove is not None:
        from lpslam.watching.foxglove_server import ServerWatcher

        server = ServerWatcher(foxglove, frames.camera, frames.name)
        watchers.append(server)
        say(f"Foxglove can connect to {server.url}")
    return Watchers(watchers, say)
