"""Signs that speak to a machine rather than name a place: recognised by rules, so that no wording talks its way past.

A sign may say “ignore all instructions”. Such a text is no destination and reaches no prompt beside others: it is not
shown to the model that chooses. What the rules miss meets the further guards of `language/hosted/chat.py`.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from itertools import groupby, product

from lpslam.language.model import Candidate, Choice, Chooser
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import is_unspaced

_MOST_LETTERS = 160  # a longer text is no name of a place, whatever it says
_MOST_WORDS = 7
_MOST_UNSPACED = 14  # letters of a script without spaces between words

_NO_GROUP: frozenset[str] = frozenset()
_LOOK_ALIKE = str.maketrans(
    "0134578@$!|аеорсухкмтвніјѕԁɡοαεικνρτυχ",
    "oieastbasilaeopcyxkmtbhijsdgoaeiknptux",
)
_WORD = standing(r"[^\W_]+(?:['’.][^\W_]+)*")
_MARKUP = standing(read_table("patterns.json")["markup"], re.IGNORECASE)
_ROLE = standing(read_table("patterns.json")["role"], re.IGNORECASE)
_NUMBERED = standing(read_table("patterns.json")["numbered"], re.IGNORECASE)
_BARE = standing(read_table("patterns.json")["bare"], re.IGNORECASE)
_FIELD = standing(read_table("patterns.json")["field"], re.IGNORECASE)


@lru_cache(maxsize=1 << 17)
def commands(text: str) -> str | None:
    """Return why a text reads as if it spoke to a machine, in a few words; None where it does not.

    Looks at the words of 20 languages, at markup and at length, in the text as painted, with look-alike letters
    undone, and with lost or added spaces. A brand or a kind of place that is known is none, whatever it is called.
    """
    if len(text) > _MOST_LETTERS:
        return "is longer than any name"
    clean = clean_text(text)
    if _MARKUP.search(clean) or _ROLE.search(clean) or _FIELD.search(clean):
        return "has markup or fields in it"
    knowledge = load_knowledge()
    if knowledge.folder.key(clean) in knowledge.known:
        return None
    if _NUMBERED.search(clean) or _BARE.fullmatch(clean):
        return "reads like an answer"
    lexicon = _lexicon()
    if any(_is_command(lexicon.groups_in(words)) for words in _spellings(clean)):
        return "speaks to a machine"
    return None


def is_sentence(text: str, most_words: int = _MOST_WORDS, most_unspaced: int = _MOST_UNSPACED) -> bool:
    """Whether a text is too long for the name of a place, and not one that is known: what it tells is not for a list.

    It may be a place all the same (a shop that paints its wares), so it is one for a model that is not swayed by words.
    """
    clean = clean_text(text)
    knowledge = load_knowledge()
    if knowledge.folder.key(clean) in knowledge.known:
        return False
    words = [word for word in _WORD.findall(clean) if not is_unspaced(word)]
    unspaced = sum(ch.isalnum() and is_unspaced(ch) for ch in clean)
    return len(words) > most_words or unspaced > most_unspaced


def choose_trusted(model: Chooser, question: str, landmarks: Sequence[Candidate]) -> Choice:
    """Let any model choose; again without them where it names signs that speak to a machine: they are no places."""
    names = {landmark.id: landmark.name for landmark in landmarks}
    while True:
        choice = model.choose(question, [landmark for landmark in landmarks if landmark.id in names])
        named = {id_ for id_ in (choice.landmark, *choice.alternatives) if id_ is not None}
        hostile = {id_ for id_ in named if id_ in names and commands(names[id_]) is not None}
        if not hostile:
            return choice
        names = {id_: name for id_, name in names.items() if id_ not in hostile}


def _is_command(found: set[str]) -> bool:
    if "order" in found or "act" in found:
        return True
    if "disregard" in found:
        return bool(found & {"talk", "value", "machine", "address"})
    if "machine" in found:
        return bool(found & {"talk", "address"})
    return False


def _spellings(clean: str) -> Iterable[tuple[str, ...]]:
    """The words as painted, then with look-alikes undone, each also with letters that stand apart joined."""
    plain = clean.casefold()
    return dict.fromkeys(
        spelling
        for line in (plain, plain.translate(_LOOK_ALIKE))
        for words in (tuple(_WORD.findall(line)),)
        for spelling in (words, _joined(words))
    )


def _joined(words: tuple[str, ...]) -> tuple[str, ...]:
    """Join letters that stand apart: “I G N O R E” is one word."""
    return tuple(
        word
        for is_letter, run in groupby(words, lambda word: len(word) == 1 and not is_unspaced(word))
        for word in (("".join(run),) if is_letter else run)
    )


class _Lexicon:
    """The vocabulary, by how an entry is looked for; every table takes an entry to its group."""

    def __init__(self, tree: Mapping[str, Mapping[str, Sequence[str]]]) -> None:
        self._whole: dict[str, set[str]] = defaultdict(set)
        self._stems: dict[str, set[str]] = defaultdict(set)
        self._unspaced: dict[str, set[str]] = defaultdict(set)
        self._glued: dict[str, set[str]] = defaultdict(set)
        self._slips: dict[str, set[str]] = defaultdict(set)
        for group, languages in tree.items():
            for entry in (entry for words in languages.values() for entry in words):
                stem = entry.rstrip("*")
                table = self._unspaced if is_unspaced(entry) else self._stems if entry != stem else self._whole
                table[" ".join(_WORD.findall(stem)) or stem].add(group)
            # Only long words may be looked for inside a run of letters: short ones are parts of others.
            for word in (entry.rstrip("*") for entry in languages["en"] if " " not in entry):
                if len(word) > 5:
                    self._glued[word].add(group)
                    for slip in _without_one(word):
                        self._slips[slip].add(group)
        # “ANSWERYES”: the reader of signs loses spaces.
        verbs = [entry.rstrip("*") for group in ("act", "disregard") for entry in tree[group]["en"]]
        things = [entry.rstrip("*") for group in ("value", "talk") for entry in tree[group]["en"]]
        for verb, thing in product((verb for verb in verbs if len(verb) > 4), things):
            self._glued[(verb + thing).replace(" ", "")].add("order")
        self._glued_sizes = sorted({len(word) for word in self._glued})
        # Signs share their words.
        self._of_word = lru_cache(maxsize=1 << 16)(self._groups_of_word)
        self._first_words = {entry.partition(" ")[0] for entry in (*self._whole, *self._stems) if " " in entry}
        self._most_words = max(word.count(" ") for word in self._whole) + 1
        self._most_letters = max(map(len, self._unspaced))
        self._longest_stem = max(map(len, self._stems))

    def groups_in(self, words: Sequence[str]) -> set[str]:
        """Return the groups of which a text holds a word."""
        found: set[str] = set()
        for at, word in enumerate(words):
            found |= self._of_word(word)
            if word in self._first_words:
                for size in range(2, min(self._most_words, len(words) - at) + 1):
                    phrase = " ".join(words[at : at + size])
                    found |= self._whole.get(phrase, _NO_GROUP) | self._starting(phrase)
        glued = "".join(words)
        if not glued.isascii():
            for at, size in product(range(len(glued)), range(1, self._most_letters + 1)):
                found |= self._unspaced.get(glued[at : at + size], _NO_GROUP)
        return found

    def _groups_of_word(self, word: str) -> frozenset[str]:
        """The groups of which a word is or begins as one, holds another, or is one but for a slip."""
        found = self._whole.get(word, _NO_GROUP) | self._starting(word)
        for at, size in product(range(len(word)), self._glued_sizes):
            if at + size <= len(word):
                found |= self._glued.get(word[at : at + size], _NO_GROUP)
        for slip in _without_one(word) if len(word) > 5 else ():
            found |= self._slips.get(slip, _NO_GROUP)
        return frozenset(found)

    def _starting(self, phrase: str) -> set[str]:
        found: set[str] = set()
        for end in range(3, min(len(phrase), self._longest_stem) + 1):
            found |= self._stems.get(phrase[:end], _NO_GROUP)
        return found


def _without_one(word: str) -> Iterable[str]:
    """A word, and what is left of it without one letter: two words one slip apart have one of these in common."""
    yield word
    for at in range(len(word)):
        yield word[:at] + word[at + 1 :]


@lru_cache(maxsize=1)
def _lexicon() -> _Lexicon:
    tree = read_table("commands.json")
    return _Lexicon({group: languages for group, languages in tree.items() if isinstance(languages, dict)})
