"""Corrections in a map file: one editor at a time, and nobody's readings or corrections lost."""

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from lpslam.errors import UserError
from lpslam.mapfile.container import read_manifest
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.text_map import TextMap

try:
    import fcntl
except ImportError:  # pragma: no cover
    # Where there are no such locks, the revision alone keeps editors apart.
    fcntl = None  # type: ignore[assignment]


def change_corrections(path: Path, change: Callable[[TextMap, LanguageMap], None], world: LanguageMap) -> LanguageMap:
    """Change what a person has said in a map, and write its file anew.

    Args:
        path: of the map.
        change: gets a copy of the text map, and changes its corrections; raises where it cannot.
        world: as its file has it now; is not changed.

    Returns:
        The changed map.

    Raises:
        UserError: it cannot be written, or `change` raised one; the file is as it was.
    """
    text = world.text.copy()
    change(text, world)
    changed = replace(world, text=text)
    changed.save(path)
    return changed


@contextmanager
def editing(path: Path, must_lock: bool = True) -> Iterator[None]:
    """Keep others who change a map's file waiting.

    Args:
        path: of a map that is there.
        must_lock: whether to raise where no lock can be made beside the map; whoever saves it then learns of it anyway.

    Raises:
        UserError: there is no map, no lock can be made beside it, or another program does not let go of it.
    """
    read_manifest(path)
    lock = path.with_name(f".{path.name}.lock")
    try:
        handle = os.open(lock, os.O_CREAT | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0), 0o600)
    except OSError as error:
        if must_lock:
            raise UserError(f"{path} cannot be changed: its folder cannot be written ({error.strerror})") from error
        yield
        return
    try:
        if fcntl is not None:
            _wait_for(handle, path)
        yield
    finally:
        os.close(handle)


def _wait_for(handle: int, path: Path) -> None:
    """Take the lock once whoever holds it has let go."""
    end = time.monotonic() + _PATIENCE
    while True:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return
        except BlockingIOError:
            if time.monotonic() > end:
                raise UserError(f"{path} is being changed by another program; try again when that has ended") from None
            time.sleep(_PAUSE)


_PATIENCE, _PAUSE = 20.0, 0.02
"""Seconds: how long another program is waited for, which corrects in one and distils in many; between two looks."""
