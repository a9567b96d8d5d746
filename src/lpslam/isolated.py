"""Python processes of our own, which run nothing that happens to lie in the folder where they are started."""

import os
import sys
from pathlib import Path


def can_start() -> bool:
    """Whether another Python can be started: not where it is built into another program."""
    return bool(sys.executable) and not getattr(sys, "frozen", False)


def python_command(code: str, *arguments: str) -> list[str]:
    """The command of a process that runs `code` with the packages that this process has.

    `python -c` and `python -m` look for modules in the current folder first, before Python's own: a `random.py` beside
    a recording would run. So the process starts isolated (`-I`: neither that folder nor Python's environment variables
    count; all other variables do) and is told where to look.

    Args:
        code: statements; they find `arguments` in `sys.argv[1:]`.
        arguments: as they are.
    """
    options = ["-I"]
    if sys.dont_write_bytecode:
        options.append("-B")
    if sys.pycache_prefix:
        options += ["-X", f"pycache_prefix={sys.pycache_prefix}"]
    # Its own places come last: what was left out here may be where its packages are installed.
    look = f"import sys; sys.path[:] = dict.fromkeys({search_path()!a} + sys.path)"
    return [sys.executable, *options, "-c", f"{look}\n{code}", *arguments]


def search_path() -> list[str]:
    """Where this process looks for modules, as absolute paths, without the current folder.

    That one stays only if it holds this package, as for somebody who works on it.
    """
    home = os.path.realpath(Path(__file__).parents[1])
    try:
        current = os.path.realpath(Path.cwd())
        entries = [str(Path(entry).absolute()) for entry in sys.path]
    except OSError:
        # The current folder was removed: nothing is found relative to it.
        current, entries = "", [entry for entry in sys.path if Path(entry).is_absolute()]
    places = {entry: os.path.realpath(entry) for entry in entries}
    kept = [entry for entry, place in places.items() if place != current or place == home]
    return kept if home in places.values() else [*kept, home]
