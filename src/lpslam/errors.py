"""Errors that a user can mend.

Everything a user does wrong is raised as a `UserError` whose message is one line: what, where, remedy.
The command line prints that line and exits with code 2; a library caller catches `LpSlamError`.
"""

_LONGEST = 1000
"""Characters of a line that somebody reads."""


class LpSlamError(Exception):
    """Base class of every error that lpslam raises on purpose."""


class UserError(LpSlamError):
    """A mistake that the user can mend; its message is one line that says what, where and the remedy.

    Args:
        message: what it quotes of a file may be longer than a line; it is cut to one of a thousand characters.
    """

    def __init__(self, message: str) -> None:
        line = " ".join(message.splitlines())
        super().__init__(line if len(line) <= _LONGEST else f"{line[: _LONGEST - 3]}...")


class MissingExtraError(UserError):
    """An optional dependency is not installed; the message names the extra that brings it."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs an optional part: pip install 'lp-slam[{extra}]'")
