"""Known forms of words that no table lists: inflected, compounded or mistyped.

Endings are cut the same way from both sides, so they need not be right, only the same. A form that is a word of its
own (`load_words`) is never taken for a slip of another.
"""

from collections.abc import Mapping
from functools import lru_cache

from rapidfuzz import process
from rapidfuzz.distance import OSA

from lpslam.language.tables.knowledge import Knowledge, load_words
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.nearest import OfLength

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
_SHORTEST_COMPOUND, _SHORTEST_HEAD = 7, 4
# Three letters are enough for these heads of German compounds; others of that length are endings.
_SHORT_HEADS = frozenset({"eis", "tee", "uhr", "bus", "rad", "hut", "bar", "zug", "arzt"})
_SHORTEST_TYPED = 6
_LONG = 11  # letters of a word that may have two slips: asiatique is not aquatique


@lru_cache(maxsize=1 << 14)
def known_form(unit: str, language: str, knowledge: Knowledge) -> str | None:
    """Return the word of the language's table that `unit` is a form of; None where there is none."""
    if language not in _ENDINGS or not unit.isalpha():
        return None
    table = knowledge.spoken(language)
    for ending in _ENDINGS[language]:
        if unit.endswith(ending) and len(unit) - len(ending) >= _SHORTEST_STEM:
            meaning = table.get(unit[: -len(ending)])
            if meaning is not None and meaning.role == "means":
                return unit[: -len(ending)]
    stem = _stem(unit, language)
    if len(stem) >= _SHORTEST_STEM:
        form = _stems(language, knowledge).get(stem)
        if form is not None:
            return form
    if language == "de":
        head = _head_of_compound(unit, table)
        if head is not None:
            return head
    return _untyped(unit, language, knowledge)


def _stem(word: str, language: str) -> str:
    for ending in _ENDINGS[language]:
        if word.endswith(ending) and len(word) - len(ending) >= _SHORTEST_STEM:
            stem = word[: -len(ending)]
            # “shopping” has a letter twice that “shop” has once.
            return stem[:-1] if language == "en" and stem[-1] == stem[-2] and len(stem) > _SHORTEST_STEM else stem
    return word


@lru_cache(maxsize=8)
def _stems(language: str, knowledge: Knowledge) -> Mapping[str, str]:
    stems: dict[str, str] = {}
    for word in _single_words(language, knowledge):
        stems.setdefault(_stem(word, language), word)
    return stems


@lru_cache(maxsize=8)
def _single_words(language: str, knowledge: Knowledge) -> tuple[str, ...]:
    """Words of one language's table that mean something, those written by hand first."""
    table = knowledge.spoken(language)
    return tuple(
        phrase for phrase, meaning in table.items() if meaning.role == "means" and len(phrase) > 3 and phrase.isalpha()
    )


@lru_cache(maxsize=8)
def _words_by_length(language: str, knowledge: Knowledge) -> OfLength:
    return OfLength(_single_words(language, knowledge))


def _head_of_compound(word: str, table: Mapping[str, Meaning]) -> str | None:
    """The longest known word that a German compound ends with: it says what the whole is."""
    if len(word) < _SHORTEST_COMPOUND:
        return None
    for cut in range(3, len(word) - 2):
        tail = word[cut:]
        if len(tail) < _SHORTEST_HEAD and tail not in _SHORT_HEADS:
            continue
        for ending in ("", *(ending for ending in ("en", "n", "e", "s", "er") if tail.endswith(ending))):
            head = tail[: len(tail) - len(ending)]
            meaning = table.get(head)
            if (
                meaning is not None
                and meaning.role == "means"
                and (len(head) >= _SHORTEST_HEAD or head in _SHORT_HEADS)
            ):
                return head
    return None


def _untyped(word: str, language: str, knowledge: Knowledge) -> str | None:
    """The one known word that a mistyped one is a single slip away from."""
    if len(word) < _SHORTEST_TYPED or word in load_words():
        return None
    slips = 1 if len(word) < _LONG else 2
    words, _ = _words_by_length(language, knowledge).within(len(word), slips)
    near = process.extract(word, words, scorer=OSA.distance, score_cutoff=slips, limit=2)
    # A slip seldom falls on the first letter: “derrito” melts, and is no “perrito”.
    near = [match for match in near if len(match[0]) >= _SHORTEST_TYPED and match[0][0] == word[0]]
    if not near or (len(near) > 1 and near[0][1] == near[1][1]):
        return None
    return str(near[0][0])
