"""What a run tells the process that serves its page: one message after the other through a pipe.

Both ends are this program, of one version: what comes through is trusted as the run itself is.
"""

import pickle
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.slam.state import SlamEvent
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.types import Landmark

_HEAD = struct.Struct("<Q")


@dataclass(frozen=True, slots=True)
class Begin:
    """What the page is of, where it is served, and who answers.

    Attributes:
        title: the recording.
        port: 0 for any that is free.
        config: limits and thresholds.
        llm: which language model answers questions; the embedded one without.
        total: frames that will come; 0 where that is not known.
    """

    title: str
    port: int
    config: Config
    llm: str | None = None
    total: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Where the run stands after a frame.

    Attributes:
        frames, keyframes, texts: counts.
        rate: frames a second.
        tracking: what tracking says of the frame.
        reason: why there is no pose, or a weak one; empty when all is well.
        submaps: parts of the map that are not joined, 1 when all is one.
        dropped: frames that were over before they could be taken.
        pose: `world_from_camera`, 4×4; None where it is not known.
    """

    frames: int
    keyframes: int
    texts: int
    rate: float
    tracking: str
    reason: str
    submaps: int
    dropped: int
    pose: NDArray[np.float64] | None


@dataclass(frozen=True, slots=True)
class Happened:
    """What has happened to tracking and to the map.

    Attributes:
        events: the newest, in order of time.
        count: of all so far.
        start: timestamp of the first frame, seconds.
    """

    events: tuple[SlamEvent, ...]
    count: int
    start: float


@dataclass(frozen=True, slots=True, eq=False)
class Signs:
    """All landmarks as known now, and what a person has said of them."""

    landmarks: tuple[Landmark, ...]
    corrections: Corrections
    question: str | None


@dataclass(frozen=True, slots=True)
class Corrected:
    """What became of something that a person said.

    Attributes:
        request: its number.
        status: as of HTTP.
        detail: what is wrong; empty when nothing is.
        corrections: as they are now.
    """

    request: int
    status: int
    detail: str
    corrections: Corrections


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """The camera's way, and what its keyframes saw.

    Attributes:
        camera: of the frames.
        poses, keyframes, scans: as of `session.growth.Growth`.
    """

    camera: PinholeCamera
    poses: NDArray[np.float64]
    keyframes: Mapping[int, NDArray[np.float64]]
    scans: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class End:
    """The run has ended.

    Attributes:
        map_file: where its map is; empty where there is none.
    """

    map_file: str


Message = Begin | State | Happened | Signs | Corrected | Ground | End


def send(pipe: IO[bytes], message: Message) -> None:
    """Send a message.

    Raises:
        OSError: nobody listens any more.
    """
    body = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    try:
        pipe.write(_HEAD.pack(len(body)) + body)
        pipe.flush()
    except ValueError as error:
        # The run has ended, and closed it, while this was told.
        raise BrokenPipeError(*error.args) from error


def receive(pipe: IO[bytes]) -> Message | None:
    """The next message; None where the run has gone."""
    head = pipe.read(_HEAD.size)
    if len(head) < _HEAD.size:
        return None
    (size,) = _HEAD.unpack(head)
    body = pipe.read(size)
    return pickle.loads(body) if len(body) == size else None
