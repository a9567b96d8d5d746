"""Known forms of words that no table lists: inflected, or mistyped by a letter.

Endings are cut the same way from both sides, so they need not be right, only the same.
"""

from collections.abc import Mapping
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

from lpslam.language.tables.knowledge import Knowledge, load_words

# Longest first. Accents are folded away before.
_ENDINGS = {
    "en": ("ingly", "ings", "ing", "edly", "ers", "er", "ed", "es", "ly", "s"),
    "de": ("eren", "erin", "chen", "ern", "est", "end", "en", "em", "er", "es", "et", "st", "e", "n", "s", "t"),
    "es": ("arme", "erme", "irme", "arlo", "arla", "ando", "iendo", "aron", "aste", "adas", "ados", "idas", "idos",
           "itos", "itas", "ada", "ado", "ida", "ido", "ito", "ita", "ar", "er", "ir", "amos", "emos", "as", "os", "es",
           "an", "en", "a", "o", "e", "s"),
    "fr": ("ements", "ement", "erons", "erais", "ions", "iez", "ées", "ees", "ent", "ons", "ais", "ait", "ez", "er",
           "ee", "es", "ir", "re", "e", "s", "x"),
}  # fmt: skip
_SHORTEST_STEM = 4
_SHORTEST_TYPED = 6


@lru_cache(maxsize=1 << 14)
def known_form(unit: str, language: str, knowledge: Knowledge) -> str | None:
    """Return the word of the language's table that `unit` is a form of; None where there is none."""
    if language not in _ENDINGS or not unit.isalpha():
        return None
    stems = _stems(language, knowledge)
    found = next((known for stem in _stems_of(unit, language) if (known := stems.get(stem))), None)
    if found is not None or len(unit) < _SHORTEST_TYPED or unit in load_words():
        return found
    near = process.extract(unit, set(stems.values()), scorer=OSA.distance, score_cutoff=1, limit=2)
    # A slip seldom falls on the first letter: “derrito” melts, and is no “perrito”.
    meant = [word for word, _, _ in near if word[0] == unit[0]]
    return meant[0] if len(meant) == 1 else None


def _stems_of(word: str, language: str) -> list[str]:
    """A word with one ending cut off, the longest first; as it is where it has none."""
    ends = [end for end in _ENDINGS[language] if word.endswith(end) and len(word) - len(end) >= _SHORTEST_STEM]
    return [word.removesuffix(end) for end in ends] or [word]


@lru_cache(maxsize=8)
def _stems(language: str, knowledge: Knowledge) -> Mapping[str, str]:
    """The words of a language's table that mean something by what each may be without its ending."""
    stems: dict[str, str] = {}
    words = [word for word, meaning in knowledge.spoken(language).items() if meaning.role == "means" and word.isalpha()]
    stems.update((word, word) for word in words)
    for word in words if language in _ENDINGS else ():
        for stem in _stems_of(word, language)[:1]:
            stems.setdefault(stem, word)
    return stems
