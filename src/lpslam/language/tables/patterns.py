"""Patterns made ready once for all processes: what `re` makes of each is kept in the user's cache.

To make a language's patterns ready takes a tenth of a second, as long as to answer. What is kept is of this very
Python (`kept`); where that does not fit, or is not to be had, a pattern is made ready as usual.
"""

import re
from array import array
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any, cast

from lpslam.language.kept import kept

_OTHERWISE = (AttributeError, ImportError, RuntimeError, TypeError, ValueError)
_made: dict[tuple[str, int], tuple[Any, ...]] = {}
_standing: list[tuple[str, int]] = []


class _Standing:
    """A pattern of a module, made ready when it is first looked for, with all that stand there by then."""

    def __init__(self, pattern: str, flags: int) -> None:
        self._pattern, self._flags = pattern, flags
        _standing.append((pattern, flags))

    def __getattr__(self, name: str) -> Any:
        if _standing:
            patterns = tuple(_standing)
            _standing.clear()
            keep_ready("own", patterns, repr(patterns).encode())
        found = getattr(ready(self._pattern, self._flags), name)
        setattr(self, name, found)
        return found


def standing(pattern: str, flags: int = 0) -> re.Pattern[str]:
    """Return a pattern that a module holds: what is imported need not be made ready."""
    return cast(re.Pattern[str], _Standing(pattern, int(flags)))


def keep_ready(name: str, patterns: Iterable[tuple[str, int]], made_of: bytes = b"") -> None:
    """Have some patterns, each with its flags, ready from the cache; `name` is a word for all of them."""
    with suppress(*_OTHERWISE):
        _made.update(
            kept(f"patterns-{name}", made_of, lambda: {(text, int(flag)): _of(text, flag) for text, flag in patterns})
        )


@cache
def ready(pattern: str, flags: int = 0) -> re.Pattern[str]:
    """Return a pattern that can be looked for."""
    made = _made.get((pattern, int(flags)))
    if made is not None:
        with suppress(*_OTHERWISE):
            found: re.Pattern[str] = import_module("_sre").compile(
                pattern, made[0], memoryview(made[1]).cast("I").tolist(), *made[2:]
            )
            return found
    return re.compile(pattern, flags)


def _of(pattern: str, flags: int) -> tuple[Any, ...]:
    """What `re.compile` gives to the engine."""
    parsed = import_module("re._parser").parse(pattern, flags)
    names = dict(parsed.state.groupdict)
    of_number = {number: name for name, number in names.items()}
    code = array("I", import_module("re._compiler")._code(parsed, flags)).tobytes()
    groups = tuple(of_number.get(number) for number in range(parsed.state.groups))
    return int(flags | parsed.state.flags), code, parsed.state.groups - 1, names, groups
