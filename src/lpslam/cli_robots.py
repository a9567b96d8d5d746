"""The command for robots: pictures in by ROS 2's topics, and what the map knows out."""

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lpslam.cli_checks import config_of, refuse_old_map
from lpslam.cli_options import Json
from lpslam.errors import MissingExtraError, UserError
from lpslam.views.printed import print_facts, say
from lpslam.whole_files import refuse_unwritable


def robot(
    output: Annotated[
        Path | None, typer.Option("--output", "-o", metavar="MAP.lpmap", help="Where the map goes at the end.")
    ] = None,
    domain: Annotated[int, typer.Option("--domain", min=0, max=232, help="ROS_DOMAIN_ID.")] = 0,
    network: Annotated[
        bool, typer.Option("--network", help="Send to other machines too, as CYCLONEDDS_URI says.")
    ] = False,
    color: Annotated[str | None, typer.Option("--color", metavar="TOPIC", help="Colour pictures.")] = None,
    depth: Annotated[
        str | None, typer.Option("--depth", metavar="TOPIC", help="Depth pictures, registered to the colour.")
    ] = None,
    info: Annotated[str | None, typer.Option("--info", metavar="TOPIC", help="The colour camera's CameraInfo.")] = None,
    odom_frame: Annotated[
        str | None,
        typer.Option(
            "--odom-frame", metavar="FRAME", help="Tell map→FRAME on tf; without, to the top of the camera's tree."
        ),
    ] = None,
    base_frame: Annotated[
        str | None, typer.Option("--base-frame", metavar="FRAME", help="Tell where this stands; the camera without.")
    ] = None,
    wait: Annotated[
        float, typer.Option("--wait", min=0.1, help="Seconds within which the first frame must come.")
    ] = 30,
    seconds: Annotated[float | None, typer.Option("--seconds", min=0.1, help="End after so long.")] = None,
    max_frames: Annotated[int | None, typer.Option("--max-frames", min=1, help="End after N frames.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace a map that is there already.")] = False,
    no_text: Annotated[bool, typer.Option("--no-text", help="Track and map only; read nothing.")] = False,
    llm: Annotated[str | None, typer.Option("--llm", metavar="MODEL", help="As for 'lpslam ask'.")] = None,
    config: Annotated[
        Path | None, typer.Option("--config", metavar="FILE", help="YAML overrides; topics are in 'robots'.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Map what a robot's camera publishes on ROS 2's topics, and tell it where it is and what signs say.

    Over DDS, without ROS being installed, to this machine alone; services ask and goal. Ctrl-C ends it.
    """
    from importlib.util import find_spec

    if find_spec("cyclonedds") is None:
        raise MissingExtraError("lpslam robot", "dds")
    settings = config_of(config)
    given = {
        "colour_topic": color,
        "depth_topic": depth,
        "info_topic": info,
        "odom_frame": odom_frame,
        "base_frame": base_frame,
    }
    topics = {name: value for name, value in given.items() if value is not None}
    if empty := [name for name, value in topics.items() if name.endswith("topic") and not value.strip("/ ")]:
        raise UserError(f"--{empty[0].partition('_')[0].replace('colour', 'color')} is empty; give a topic")
    settings = settings.model_copy(update={"robots": settings.robots.model_copy(update=topics)})
    if output is not None:
        refuse_unwritable(output)
        refuse_old_map(output, force)
    _run(settings, output, domain, network, wait, seconds, max_frames, not no_text, llm, as_json)


def _run(
    settings: Any,
    output: Path | None,
    domain: int,
    network: bool,
    wait: float,
    seconds: float | None,
    max_frames: int | None,
    text: bool,
    llm: str | None,
    as_json: bool,
) -> None:
    from lpslam.cli_runs import keep
    from lpslam.language.registry import language_model
    from lpslam.robots.dds import DdsBus
    from lpslam.robots.node import RobotNode
    from lpslam.session.session import Session
    from lpslam.views.run_progress import InterruptFlag, prepare

    language = language_model(llm, settings.language)
    prepare()
    node = RobotNode(
        DdsBus(domain, on_this_machine=not network),
        settings,
        lambda camera: Session(camera, settings, language=language, live=True, text=text, name="robot"),
        language,
        say,
    )
    robots = settings.robots
    say(f"listening to {robots.colour_topic} and {robots.depth_topic} in domain {domain}; Ctrl-C ends it")
    until = None if seconds is None else time.monotonic() + seconds
    with InterruptFlag() as interrupted:
        try:
            world = node.run(
                lambda: interrupted.is_set() or (until is not None and time.monotonic() > until),
                patience=wait,
                max_frames=max_frames,
            )
            if world is None:
                say("ended before a frame came; nothing is written")
                return
            if output is not None:
                keep(world, output)
        finally:
            node.close()
    if node.skipped:
        say(f"not used: {node.skipped}")
    if node.dropped:
        say(f"{node.dropped} frames came too fast and were dropped")
    print_facts(world, output or Path("(not kept: no --output)"), as_json)


COMMANDS: tuple[Any, ...] = (robot,)
