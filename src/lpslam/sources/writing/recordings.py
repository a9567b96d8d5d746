"""A source written frame by frame: as a TUM RGB-D folder, or as MCAP with the messages of ROS 2 or of Foxglove.

Colour is PNG. Depth is 16-bit where that keeps every reading, else 32-bit floating point.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.sources.writing.messages import FoxgloveMessages, RosMessages
from lpslam.sources.writing.tum_folder import FolderSink
from lpslam.whole_files import refuse_unwritable_folder, written_whole

OnProgress = Callable[[int, int], None]

_NOT_WRITTEN = (".bag", ".db3", ".mkv", ".r3d", ".sens", ".lpmap", ".zip", ".tar")
"""Ends of names that promise a file: a folder of that name would be taken for a broken one."""


class Sink(Protocol):
    """Where frames go."""

    def add(self, frame: RgbdFrame) -> None:
        """Write a frame."""
        ...

    def finish(self) -> None:
        """Write what makes it whole."""
        ...

    def close(self) -> None:
        """Let go of the file, whole or not."""
        ...


def written(
    source: FrameSource,
    output: Path,
    on_progress: OnProgress = lambda done, of: None,
    *,
    foxglove: bool = False,
    keeps_part: bool = False,
) -> int:
    """Write every frame of a source; how many there were.

    Args:
        source: the recording.
        output: NAME.mcap, or a folder that is not there or empty.
        on_progress: called with frames written and frames in all.
        foxglove: whether an MCAP has Foxglove's messages in JSON, which its viewer knows; else ROS 2's.
        keeps_part: whether what was written stays when no more can be, as NAME.partial.mcap: it cannot be had again.

    Raises:
        UserError: the output is there already, or cannot be written; what was begun is removed.
    """
    is_mcap = output.suffix.lower() == ".mcap"
    if output.exists() and (is_mcap or not output.is_dir() or any(output.iterdir())):
        raise UserError(f"{output} is there already and is not overwritten; choose another name")
    if foxglove and not is_mcap:
        raise UserError(f"{output} is no .mcap; Foxglove's messages are written to that alone")
    if not is_mcap and output.suffix.lower() in _NOT_WRITTEN:
        raise UserError(f"{output}: {output.suffix} is not written; end the name in .mcap, or give that of a folder")
    refuse_unwritable_folder(output.parent)
    kept = output.with_name(f"{output.stem}.partial{output.suffix}") if keeps_part else None
    if kept is not None and kept.exists():
        raise UserError(f"{kept} is there already, of a recording that was broken off; move it away first")
    remedy = "choose another place" if kept is None else f"what was recorded until then is in {kept}"
    count = 0
    with written_whole(output, remedy=remedy, kept=kept) as part:
        part.parent.mkdir(parents=True, exist_ok=True)
        sink = _sink(part, source, is_mcap, foxglove)
        try:
            for frame in source:
                sink.add(frame)
                count += 1
                on_progress(count, len(source))
            sink.finish()
        finally:
            sink.close()
    return count


def _sink(part: Path, source: FrameSource, is_mcap: bool, foxglove: bool) -> Sink:
    if not is_mcap:
        return FolderSink(part, source.camera)
    return McapSink(part, FoxgloveMessages(source.camera) if foxglove else RosMessages(source.camera))
