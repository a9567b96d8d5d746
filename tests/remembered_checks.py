"""What opening finds out about a recording of pictures, kept for whoever opens the same pictures again."""

import hashlib
import os
import pickle
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from lpslam.sources import open as opening
from lpslam.sources.image_pairs import ImagePairSource

Found = TypeVar("Found")


class RememberedChecks:
    """Follows pictures and compares contours of a recording once for all tests and workers: most open the same walk.

    Recordings are the same where all that is listed is: times, calibration, and every byte of every picture.

    Args:
        folder: where what was found is kept.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._pairs_of = opening.pairs_of
        self._registration = opening._doubts_about_registration

    def pairs_of(self, read: Any, times: Any, config: Any) -> Any:
        """As `followed_pairs.pairs_of`."""
        source = getattr(read, "__self__", None)
        return self._remembered(source, f"pairs {config}", lambda: self._pairs_of(read, times, config))

    def doubts_about_registration(self, source: Any, checks: Any) -> Any:
        """As in `open`."""
        return self._remembered(source, f"registration {checks}", lambda: self._registration(source, checks))

    def _remembered(self, source: object, asked: str, find: Callable[[], Found]) -> Found:
        if type(source) is not ImagePairSource or not all(_is_file(pair.colour, pair.depth) for pair in source._pairs):
            return find()
        path = self._folder / hashlib.sha256(f"{asked} {_content(source)}".encode()).hexdigest()
        if path.exists():
            kept: Found = pickle.loads(path.read_bytes())
            return kept
        found = find()
        unfinished = path.with_suffix(f".{os.getpid()}.{threading.get_ident()}")
        unfinished.write_bytes(pickle.dumps(found))
        unfinished.rename(path)
        return found


def _is_file(*places: object) -> bool:
    return all(place is None or (isinstance(place, Path) and place.is_file()) for place in places)


def _content(source: ImagePairSource) -> list[object]:
    how = (source.camera, source.displacement, source._may_displace, source.is_scale_assumed)
    is_along_rays = source._along_axis is not None
    pairs = [(pair.timestamp, pair.fault, _digest_of(pair.colour), _digest_of(pair.depth)) for pair in source._pairs]
    return [*how, is_along_rays, *pairs]


def _digest_of(file: Any) -> str:
    if file is None:
        return ""
    status = file.stat()
    return _digest(file, status.st_ino, status.st_mtime_ns, status.st_size)


@cache
def _digest(file: Path, *status: int) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
