"""Tokens: who may do what, and until when. The file holds their digests, never the tokens themselves."""

import hashlib
import hmac
import json
import os
import secrets
import tempfile
import threading
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lpslam.errors import LpSlamError, UserError
from lpslam.regular_files import bytes_of

SCOPES = ("read", "ask", "map", "write")
"""`read` lists maps and landmarks, `ask` asks and plans, `map` uploads recordings, `write` corrects landmarks."""

_PREFIX = "lps_"
_SECRET_BYTES = 32
_LONGEST = 200  # letters of a token that is looked at


class TokenError(LpSlamError):
    """A token that is not known, or no longer."""


class _Entry(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str = Field(min_length=1, max_length=60)
    sha256: str = Field(pattern=r"^[0-9a-f]{64}$")
    scopes: tuple[str, ...]
    expires: datetime | None = None


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    tokens: tuple[_Entry, ...] = ()


@dataclass(frozen=True, slots=True)
class Holder:
    """Whoever shows a token.

    Attributes:
        name: of the token; empty for somebody without one.
        scopes: what may be done.
    """

    name: str
    scopes: frozenset[str]


class Tokens:
    """The tokens of a file, read again when it changes, so that one can be withdrawn from a server that runs.

    Args:
        path: of the file.

    Raises:
        UserError: it cannot be read, or holds no token.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._changing = threading.Lock()
        self._stamp: tuple[int, int, int] | None = None
        self._by_digest: Mapping[bytes, _Entry] = {}
        self._read()
        if not self._by_digest:
            raise UserError(f"{path} holds no token; make one: lpslam token {path} --name NAME")

    def holder(self, token: str) -> Holder:
        """Whose token it is.

        Raises:
            TokenError: nobody's, or it has expired.
        """
        self._refresh()
        digest = _digest(token[:_LONGEST]) if len(token) <= _LONGEST else b""
        # The digest of a secret of 256 bits tells nothing by the time that it takes to look it up.
        found = self._by_digest.get(digest)
        if found is None or not hmac.compare_digest(digest.hex(), found.sha256):
            raise TokenError("the token is not known")
        if found.expires is not None and found.expires <= datetime.now(UTC):
            raise TokenError("the token has expired")
        return Holder(found.name, frozenset(found.scopes))

    def _refresh(self) -> None:
        try:
            at = self._path.stat()
        except OSError:
            # A file that is taken away takes its tokens with it.
            self._by_digest, self._stamp = {}, None
            return
        if (at.st_mtime_ns, at.st_size, at.st_ino) != self._stamp:
            with self._changing:
                try:
                    self._read()
                except UserError:
                    # Half a file, or a broken one: nobody is let in by what it does not say.
                    self._by_digest = {}

    def _read(self) -> None:
        entries = read_tokens(self._path)
        at = self._path.stat()
        self._stamp = (at.st_mtime_ns, at.st_size, at.st_ino)
        self._by_digest = {bytes.fromhex(entry.sha256): entry for entry in entries}


def read_tokens(path: Path) -> tuple[_Entry, ...]:
    """The entries of a file.

    Raises:
        UserError: it cannot be read, or is no file of tokens.
    """
    try:
        data = bytes_of(path, "tokens", f"make them: lpslam token {path}")
        entries = _File.model_validate_json(data).tokens
    except ValidationError as error:
        first = error.errors()[0]
        where = [".".join(str(part) for part in first["loc"])] if first["loc"] else []
        raise UserError(f"{path} is no file of tokens: {': '.join([*where, first['msg']])}") from error
    for entry in entries:
        if unknown := set(entry.scopes) - set(SCOPES):
            raise UserError(f"{path}: {min(unknown)} is no scope; there are {', '.join(SCOPES)}")
        if entry.expires is not None and entry.expires.tzinfo is None:
            raise UserError(f"{path}: when {entry.name} expires lacks its time zone, as in 2030-01-31T00:00:00Z")
    return entries


def add_token(path: Path, name: str, scopes: Collection[str], days: float | None) -> str:
    """Make a token, and keep its digest in a file that only its owner can read.

    Returns:
        The token; it is written nowhere.

    Raises:
        UserError: the name is taken, a scope is unknown, or the file cannot be written.
    """
    if unknown := set(scopes) - set(SCOPES):
        raise UserError(f"{min(unknown)} is no scope; there are {', '.join(SCOPES)}")
    entries = read_tokens(path) if path.exists() else ()
    if any(entry.name == name for entry in entries):
        raise UserError(f"{path} has a token named {name} already; choose another name, or remove its entry")
    token = _PREFIX + secrets.token_urlsafe(_SECRET_BYTES)
    expires = None if days is None else (datetime.now(UTC) + timedelta(days=days)).replace(microsecond=0)
    try:
        entry = _Entry(name=name, sha256=_digest(token).hex(), scopes=tuple(sorted(scopes)), expires=expires)
    except ValidationError as error:
        first = error.errors()[0]
        raise UserError(f"option --{first['loc'][0]}: {first['msg']}") from error
    _write(path, _File(tokens=(*entries, entry)).model_dump(mode="json"))
    return token


def _write(path: Path, document: dict[str, Any]) -> None:
    try:
        # Made readable by its owner alone.
        handle, temporary = tempfile.mkstemp(prefix=".lpslam-", dir=path.absolute().parent)
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                json.dump(document, file, indent=1)
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except OSError as error:
        raise UserError(f"tokens {path} cannot be written ({error.strerror}); choose another place") from error


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "replace")).digest()
