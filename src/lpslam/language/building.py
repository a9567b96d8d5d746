"""Building tables of many small objects without the garbage collector going through them over and over."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def building() -> Iterator[None]:
    """Let the garbage collector wait: nothing built here is garbage yet (a fifth of the first answer's time)."""
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()
