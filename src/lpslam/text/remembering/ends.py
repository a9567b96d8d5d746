"""Which spellings are words, and which end as words do: beyond such an end there need be nothing more."""

from lpslam.language.tables.knowledge import load_knowledge, load_words
from lpslam.language.tables.spelling import is_ideograph, words_of
from lpslam.text.remembering.similarity import is_short

_LEAST = 2
"""Letters of a word at an end: one by itself is a piece of any."""

_SAYING = 3
"""Letters of a word that is none by chance."""

_ALONE = frozenset("药藥薬当當押质質面麵麺医醫厕廁浴出入推拉停禁福")
"""Ideographs that chemists, pawn shops, kitchens, surgeries, baths, doors and roads bear by themselves, and that are no
words of the tables: within a wish they are parts of other words."""

_WORDS = 3
"""Words at an end that are looked up together."""


def ends_as_words_do(text: str) -> tuple[bool, bool]:
    """Whether a text begins with a known word or name, and whether it ends with one.

    An ideograph is a word, or a part of one that the tables need not know: it may end a text as well as any other.
    """
    knowledge = load_knowledge()
    words = [key for word in text.split() if (key := knowledge.folder.key(word))]
    if not words:
        return False, False
    counts = range(2, min(_WORDS, len(words)) + 1)
    first = [words[0], *("".join(words[:count]) for count in counts)]
    last = [words[-1], *("".join(words[-count:]) for count in counts)]
    return (
        is_ideograph(words[0][0]) or begins_by_case(text) or any(map(_is_word, first)),
        is_ideograph(words[-1][-1]) or any(map(_is_word, last)),
    )


def begins_by_case(text: str) -> bool:
    """Whether a text begins as words do: with a capital before a small letter, of those that differ in shape."""
    return text[:1] in _CAPITALS and text[1:2].islower()


_CAPITALS = frozenset("ABDEFGHJLMNQRTY")
"""Those of Latin that are no larger copies of their small letters, nor read for another one, as I is."""


def is_word(text: str) -> bool:
    """Whether a text is a known word or name, or a character that signs bear by itself."""
    return _is_known(load_knowledge().folder.key(text))


def says_a_word(text: str) -> bool:
    """Whether a text has a known word of three letters or two ideographs in it, or one in a script few are known of."""
    knowledge = load_knowledge()
    for word in words_of(knowledge.folder.fold(text), load_words()):
        key = knowledge.folder.key(word)
        if (len(key) >= _SAYING and _is_known(key)) or (len(key) >= _LEAST and not any(map(_is_of_tables, key))):
            return True
        pairs = (key[at : at + 2] for at in range(len(key) - 1) if is_ideograph(key[at]) and is_ideograph(key[at + 1]))
        if any(map(_is_known, pairs)):
            return True
    return False


def is_lone_character(text: str) -> bool:
    """Whether a text is one ideograph that signs do not bear by itself: as with letters, most are no text."""
    letters = [letter for letter in text if letter.isalnum()]
    return len(letters) == 1 and is_ideograph(letters[0]) and not (letters[0] in _ALONE or is_word(letters[0]))


def is_of_rings(text: str) -> bool:
    """Whether a text has nothing but zeros and Os: rings are read so, and no number is written so."""
    letters = "".join(letter for letter in text.casefold() if letter.isalnum())
    return bool(letters) and not letters.strip("0o") and not is_word(text)


def says_little(text: str) -> bool:
    """Whether a text is short, and no word of two ideographs, which says more than three letters do."""
    return is_short(text) and not (len(text) > 1 and is_ideograph(text[0]) and is_word(text))


def _is_of_tables(letter: str) -> bool:
    """Whether a letter is of a script in which the tables know most of what signs say."""
    return letter.isdigit() or letter < _LATIN_ENDS or is_ideograph(letter)


_LATIN_ENDS = "\u0250"
"""The first character beyond the Latin letters."""


def _is_word(key: str) -> bool:
    return len(key) >= _LEAST and _is_known(key)


def _is_known(key: str) -> bool:
    knowledge = load_knowledge()
    return key in load_words() or key in knowledge.painted or key in knowledge.known
