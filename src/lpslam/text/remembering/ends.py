"""Which spellings are words, and which end as words do: beyond such an end there need be nothing more."""

from lpslam.language.tables.knowledge import load_knowledge, load_words
from lpslam.language.tables.spelling import is_ideograph

_LEAST = 2
"""Letters of a word at an end: one by itself is a piece of any."""

_WORDS = 3
"""Words at an end that are looked up together."""

_IDEOGRAPHS = 6
"""Characters at an end that are looked up together, where no space parts words."""


def ends_as_words_do(text: str) -> tuple[bool, bool]:
    """Whether a text begins with a known word or name, and whether it ends with one."""
    knowledge = load_knowledge()
    words = [key for word in text.split() if (key := knowledge.folder.key(word))]
    if not words:
        return False, False
    first = [words[0], *("".join(words[:count]) for count in range(2, min(_WORDS, len(words)) + 1))]
    last = [words[-1], *("".join(words[-count:]) for count in range(2, min(_WORDS, len(words)) + 1))]
    if is_ideograph(words[0][0]):
        first += [words[0][:count] for count in range(_LEAST, min(_IDEOGRAPHS, len(words[0])))]
    if is_ideograph(words[-1][-1]):
        last += [words[-1][-count:] for count in range(_LEAST, min(_IDEOGRAPHS, len(words[-1])))]
    return any(map(_is_word, first)), any(map(_is_word, last))


def is_word(text: str) -> bool:
    """Whether a text is a known word or name, or a character that signs bear by itself."""
    return _is_known(load_knowledge().folder.key(text))


def _is_word(key: str) -> bool:
    return len(key) >= _LEAST and _is_known(key)


def _is_known(key: str) -> bool:
    knowledge = load_knowledge()
    return key in load_words() or key in knowledge.painted or key in knowledge.known
