"""Errors that a user can mend.

Everything a user does wrong is raised as a `UserError` whose message is one line: what, where, remedy.
The command line prints that line and exits with code 2; a library caller catches `LpSlamError`.
"""


class LpSlamError(Exception):
    """Base class of every error that lpslam raises on purpose."""


class UserError(LpSlamError):
    """A mistake that the user can mend; its message is one line that says what, where and the remedy."""


class MissingExtraError(UserError):
    """An optional dependency is not installed; the message names the extra that brings it."""

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(f"{what} needs an optional part: pip install 'lp-slam[{extra}]'")
