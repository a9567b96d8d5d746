"""Files of maps, as they are served: under which name, and in which version."""

import hashlib
import re
from collections.abc import Sequence
from pathlib import Path

from lpslam.errors import UserError
from lpslam.mapfile.container import read_manifest
from lpslam.mapfile.language_map import LanguageMap

_LONGEST_NAME = 60  # letters


def map_name(path: Path) -> str:
    """The name under which a map's file is served: its own, of letters that need no quoting in an address."""
    return re.sub(r"[^\w.-]+", "-", path.stem)[:_LONGEST_NAME].strip(".-") or "map"


def file_version(path: Path) -> str:
    """What changes when a file is replaced or written.

    Raises:
        OSError: there is none.
    """
    at = path.stat()
    return hashlib.sha256(f"{at.st_ino} {at.st_size} {at.st_mtime_ns}".encode()).hexdigest()[:12]


def read_version(path: Path) -> tuple[str, LanguageMap]:
    """A map and the version of its file, which belong together.

    Raises:
        UserError: it cannot be read.
    """
    while True:
        try:
            version = file_version(path)
        except OSError as error:
            raise UserError(f"map {path} cannot be read ({error.strerror or error})") from error
        world = LanguageMap.load(path)
        try:
            if file_version(path) == version:
                return version, world
        except OSError:
            # It was read whole, and is gone since.
            return version, world


def refuse_no_maps(paths: Sequence[Path]) -> None:
    """Look at maps before anything slow is loaded for them.

    Raises:
        UserError: one cannot be read, or is no map.
    """
    for path in paths:
        read_manifest(path)
