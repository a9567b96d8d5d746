"""Corrections in a map file: one editor at a time, and nobody's readings or corrections lost."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from lpslam.errors import UserError
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
def editing(path: Path) -> Iterator[None]:
    """Keep other editors of a map's file waiting.

    Raises:
        UserError: no lock can be made beside the map.
    """
    lock = path.with_name(f".{path.name}.lock")
    try:
        handle = os.open(lock, os.O_CREAT | os.O_RDWR | getattr(os, "O_NOFOLLOW", 0), 0o600)
    except OSError as error:
        raise UserError(f"{path} cannot be corrected: its folder cannot be written ({error.strerror})") from error
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
