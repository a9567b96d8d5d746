"""The process of a job: unpacks an upload, maps it, and says how far it is, a line of JSON at a time."""

import json
import logging
import os
import sys
import threading
import time
from pathlib import Path
from typing import Any

from lpslam.config import Config
from lpslam.errors import LpSlamError, UserError
from lpslam.serving.jobs.fences import kernel_places, limit_resources, read_only_inside
from lpslam.sources.archives import unpack
from lpslam.views.drawable import printable

RECORDING, MAP = "recording", "map.lpmap"
_EVERY = 0.5  # seconds between two lines


def main() -> None:
    """Map the upload `sys.argv[2]` in the folder `sys.argv[1]`; the configuration comes as a line on standard input."""
    folder, upload = Path(sys.argv[1]), Path(sys.argv[2])
    config = Config.model_validate_json(sys.stdin.readline())
    threading.Thread(target=_end_with_server, daemon=True).start()
    logging.getLogger().addHandler(logging.NullHandler())
    lines = os.fdopen(os.dup(sys.stdout.fileno()), "w", encoding="utf-8")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())

    def say(**facts: Any) -> None:
        print(json.dumps(facts), file=lines, flush=True)

    try:
        limit_resources(config.serving.jobs)
        say(state="unpacking")
        _map(folder, _recording(folder, upload, config), config, say)
    except MemoryError:
        say(state="failed", message="the recording needs more memory than a job may have")
        raise SystemExit(2) from None
    except (LpSlamError, OSError) as error:
        # What is said of the recording goes to its sender, who knows no folder of the server.
        words = str(error) if isinstance(error, LpSlamError) else error.strerror or "it cannot be read"
        say(state="failed", message=printable(words.replace(f"{folder}{os.sep}", ""), longest=400))
        raise SystemExit(2) from None


def _end_with_server() -> None:
    """A server that is gone, however it ended, leaves no job behind."""
    sys.stdin.read()
    os._exit(1)


def _recording(folder: Path, upload: Path, config: Config) -> Path:
    """The recording that was sent: a file as it is, an archive unpacked."""
    if upload.suffix != ".archive":
        return upload
    place = folder / RECORDING
    place.mkdir()
    unpack(upload, place, config.serving.jobs)
    upload.unlink()
    # Archives mostly hold one folder, which holds the recording.
    while len(inside := [each for each in place.iterdir() if each.name != "__MACOSX"]) == 1 and inside[0].is_dir():
        place = inside[0]
    return place


def _map(folder: Path, recording: Path, config: Config, say: Any) -> None:
    from lpslam import pipeline
    from lpslam.sources.in_order import InOrder
    from lpslam.sources.open import SourceOptions, open_source

    read_only_inside(folder, kernel_places())
    options = SourceOptions(pairing=config.pairing)
    frames = InOrder(open_source(recording, checks=config.calibration, options=options), config.times)
    total, last = len(frames), 0.0
    say(state="mapping", frames_total=total)

    def tell(progress: pipeline.Progress) -> None:
        nonlocal last
        if (now := time.monotonic()) - last >= _EVERY or progress.frames == total:
            last = now
            say(
                state="mapping",
                frames=progress.frames,
                frames_per_second=round(progress.frames_per_second, 1),
                keyframes=progress.keyframes,
                landmarks=progress.landmarks,
            )

    world = pipeline.run(frames, config, sequential=True, on_progress=tell)
    if not world.trajectory.tracked_count:
        raise UserError("nothing of the recording could be mapped")
    world.save(folder / MAP)
    say(state="done", landmarks=len(world.landmarks()))
