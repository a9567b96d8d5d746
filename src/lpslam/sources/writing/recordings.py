"""A source written frame by frame: as a TUM RGB-D folder, or as MCAP with the messages of ROS 2 or of Foxglove.

Colour is PNG. Depth is 16-bit where that keeps every reading, else 32-bit floating point.
"""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.sources.writing.mcap_recording import McapSink
from lpslam.sources.writing.messages import FoxgloveMessages, RosMessages
from lpslam.sources.writing.tum_folder import FolderSink

OnProgress = Callable[[int, int], None]


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
    count = 0
    part = output.with_name(f".{output.name}.part")
    kept = output.with_name(f"{output.stem}.partial{output.suffix}") if keeps_part else None
    if kept is not None and kept.exists():
        raise UserError(f"{kept} is there already, of a recording that was broken off; move it away first")
    with _removed_on_failure(part, output, kept):
        sink = _sink(part, source, is_mcap, foxglove)
        try:
            for frame in source:
                sink.add(frame)
                count += 1
                on_progress(count, len(source))
            sink.finish()
        finally:
            sink.close()
        if output.is_dir():
            output.rmdir()
        os.replace(part, output)
    return count


def _sink(part: Path, source: FrameSource, is_mcap: bool, foxglove: bool) -> Sink:
    if not is_mcap:
        return FolderSink(part, source.camera)
    return McapSink(part, FoxgloveMessages(source.camera) if foxglove else RosMessages(source.camera))


@contextmanager
def _removed_on_failure(part: Path, output: Path, kept: Path | None) -> Iterator[None]:
    """What was begun is removed, or kept under another name."""
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        remedy = "choose another place" if kept is None else f"what was recorded until then is in {kept}"
        raise UserError(f"{output} cannot be written ({error.strerror or error}); {remedy}") from error
    finally:
        if kept is not None and part.exists():
            os.replace(part, kept)
        elif part.is_dir():
            shutil.rmtree(part, ignore_errors=True)
        else:
            part.unlink(missing_ok=True)
