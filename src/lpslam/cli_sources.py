"""The commands about recordings, and the options that say which part of one is used."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from lpslam.config import PairingConfig
    from lpslam.sources.open import SourceOptions

Color = Annotated[str | None, typer.Option("--color", metavar="TOPIC", help="Of a bag: its colour pictures.")]
Depth = Annotated[str | None, typer.Option("--depth", metavar="TOPIC", help="Of a bag: its depth pictures.")]
Info = Annotated[str | None, typer.Option("--info", metavar="TOPIC", help="Of a bag: the colour camera's CameraInfo.")]
From = Annotated[float | None, typer.Option("--from", metavar="SECONDS", help="Begin so long after the first frame.")]
To = Annotated[float | None, typer.Option("--to", metavar="SECONDS", help="End so long after the first frame.")]


_RECORDED_BACKLOG = 90
"""Frames that wait while the disk is busy: three seconds, 140 MB."""


def topics_and_span(
    color: str | None,
    depth: str | None,
    info: str | None,
    start: float | None,
    end: float | None,
    pairing: "PairingConfig | None" = None,
) -> "SourceOptions":
    """What was asked for, as recordings are opened with it."""
    from lpslam.config import PairingConfig
    from lpslam.sources.bags.topics import TopicChoice
    from lpslam.sources.open import SourceOptions

    return SourceOptions(TopicChoice(color, depth, info), start, end, pairing or PairingConfig())


def sources() -> None:
    """List the formats of recordings, and by what each is known."""
    from lpslam.sources.open import FORMATS
    from lpslam.views.printed import print_table

    bags = {
        "ROS 1 bag, RealSense .bag": "NAME.bag",
        "ROS 2 sqlite3, RealSense .db3": "NAME.db3, or a folder with some",
        "MCAP": "NAME.mcap, or a folder with some",
    }
    cameras = {"RealSense camera, live": "realsense: or realsense:SERIAL"}
    print_table(bags | {each.name: each.sign for each in FORMATS} | cameras)


def record(
    camera: Annotated[str, typer.Argument(metavar="CAMERA", help="realsense: or realsense:SERIAL.")],
    output: Annotated[Path, typer.Argument(metavar="OUT", help="NAME.mcap, or a new folder (TUM RGB-D).")],
    max_frames: Annotated[int | None, typer.Option("--max-frames", min=1, help="End after N frames.")] = None,
) -> None:
    """Record a connected camera, without loss, until Ctrl-C."""
    from lpslam.errors import UserError
    from lpslam.sources.live.opening import addresses, is_camera, open_camera
    from lpslam.sources.writing.recordings import written
    from lpslam.views.printed import print_table
    from lpslam.views.run_progress import InterruptFlag, counting

    if not is_camera(camera):
        raise UserError(f"{camera} is no camera; there are {addresses()}")
    source = open_camera(camera, max_frames, backlog=_RECORDED_BACKLOG)
    with InterruptFlag() as interrupted, counting("recording") as progress:
        source.stop_when(interrupted.is_set)
        count = written(source, output, progress, keeps_part=True)
    print_table({"written": str(output), "frames": str(count), "dropped": str(source.dropped)})


def convert(
    source: Annotated[
        Path, typer.Argument(metavar="SOURCE", help="A recording; see 'lpslam sources'.", show_default=False)
    ],
    output: Annotated[
        Path, typer.Argument(metavar="OUT", help="NAME.mcap, or a new folder (TUM RGB-D).", show_default=False)
    ],
    camera: Annotated[
        Path | None, typer.Option("--camera", metavar="FILE", help="Calibration to use instead of the recording's.")
    ] = None,
    max_frames: Annotated[int | None, typer.Option("--max-frames", min=1, help="Only the first N frames.")] = None,
    foxglove: Annotated[bool, typer.Option("--foxglove", help="MCAP with Foxglove's messages in JSON.")] = False,
    start: From = None,
    end: To = None,
    color: Color = None,
    depth: Depth = None,
    info: Info = None,
) -> None:
    """Write a recording as a TUM RGB-D folder or as MCAP (ROS 2 messages), without loss."""
    from lpslam.sources.open import open_source
    from lpslam.sources.writing.recordings import written
    from lpslam.views.notes import fault_notes
    from lpslam.views.printed import print_table, say
    from lpslam.views.run_progress import counting

    frames = open_source(source, camera, max_frames, options=topics_and_span(color, depth, info, start, end))
    with counting("writing") as progress:
        count = written(frames, output, progress, foxglove=foxglove)
    for note in fault_notes(frames.faults):
        say(note)
    print_table({"written": str(output), "frames": str(count)})
