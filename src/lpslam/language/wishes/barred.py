"""Which boards say that not everybody may go in, in any language (`data/wishes/barred.json`)."""

import re
from collections.abc import Sequence
from functools import lru_cache

from lpslam.language.languages import LATIN
from lpslam.language.model import Candidate
from lpslam.language.tables.lexicon import read_table


def barred(landmarks: Sequence[Candidate]) -> frozenset[int]:
    """Return the landmarks of which a line keeps people out: “Staff only”, 立入禁止."""
    pattern = _pattern()
    return frozenset(
        mark.id for mark in landmarks if any(pattern.search(text) is not None for text in (mark.name, *mark.lines))
    )


@lru_cache(maxsize=1)
def _pattern() -> re.Pattern[str]:
    said: dict[str, str] = read_table("wishes/barred.json")
    rows = (rf"(?<!\w)(?:{row})" if language in LATIN else row for language, row in said.items())
    return re.compile("|".join(rows), re.IGNORECASE)
