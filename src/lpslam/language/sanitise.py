"""Make a string that was read in the world safe to keep, to compare, to show and to quote."""

import unicodedata

# Other, not assigned, private and surrogate code points; `Cf` holds the bidirectional overrides and zero-width joins.
_UNSEEN = frozenset({"Cc", "Cf", "Cn", "Co", "Cs"})

# NFKC makes at most 18 code points out of one; reading further than this could not fill the limit sooner.
_READ_AHEAD = 4


def clean_text(text: str, limit: int = 500) -> str:
    """Return `text` in NFKC, on one line, without unseen characters and at most `limit` code points long.

    Control, bidirectional and zero-width characters go, every run of white space becomes one space. Case, script and
    punctuation stay as painted. The function is idempotent; the result may be empty.
    """
    head = text[: max(limit, 0) * _READ_AHEAD]
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
