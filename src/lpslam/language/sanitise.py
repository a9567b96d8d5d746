"""Make a string that was read in the world safe to keep, to compare, to show and to quote."""

import unicodedata

# Other, not assigned, private and surrogate code points; `Cf` holds the bidirectional overrides and zero-width joins.
_UNSEEN = frozenset({"Cc", "Cf", "Cn", "Co", "Cs"})

# NFKC makes at most 18 code points out of one; reading further than this could not fill the limit sooner.
_READ_AHEAD = 4


def clean_text(text: str, limit: int = 500) -> str:
    """Return `text` in NFKC, on one line, without unseen characters and at most `limit` code points long.

    Control, bidirectional and zero-width characters go, every run of white space becomes one space. Case, script and
    punctuation stay as painted. What a system whose locale knows no letters but ASCII's passes on byte by byte
    (`surrogateescape`) is read as UTF-8. The function is idempotent; the result may be empty.
    """
    head = text[: max(limit, 0) * _READ_AHEAD]
    if not head.isascii() and not head.isprintable():
        head = _of_bytes(head)
    # Nearly every string is printable as it is.
    seen = (
        head
        if head.isprintable()
        else "".join(
            " " if ch.isspace() else ch for ch in head if ch.isspace() or unicodedata.category(ch) not in _UNSEEN
        )
    )
    composed = " ".join(unicodedata.normalize("NFKC", seen).split())
    return composed[: max(limit, 0)].strip()


def _of_bytes(text: str) -> str:
    """The same with letters for the bytes of letters, PEP 383."""
    try:
        return text.encode("utf-8", "surrogateescape").decode("utf-8", "ignore")
    except UnicodeEncodeError:
        return text
