"""The embedded model's names: the posterior over whole strings, what is known being its prior (III-E)."""

from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from math import exp, log

from rapidfuzz.distance import Levenshtein

from lpslam.language.model import Naming, Reading
from lpslam.language.naming.channel import Seen, evidence_of, paint_key
from lpslam.language.naming.lost_letters import LostLetters
from lpslam.language.naming.marks import ODD_MARK, is_in_a_word, odd_marks, with_gaps, words_in
from lpslam.language.naming.posterior import ELSE, doubted, posterior, put_together
from lpslam.language.naming.voting import cased_like, painted_like, vote
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.reader import SignReader
from lpslam.language.tables.knowledge import Knowledge, load_short_words, load_words
from lpslam.language.tables.painted import Known
from lpslam.language.tables.spelling import LEAST_RESPELLED, is_ideograph, respelled, words_of
from lpslam.language.tables.words import is_unspaced

# What a known name is ahead of an unknown one, in logarithms of odds: a letter, and a letter of a word in any name;
# chosen on drawn lettering, once with every name known and once with it hidden.
_ADVANCE_LETTER, _ADVANCE_IDEOGRAPH, _ADVANCE_WORD = 1.5, 3.0, 1.5
# What a word is behind for being one of many: short ones are near anything. Of pairs of common ideographs one in four
# hundred is a word.
_CHOICE_OF_WORDS, _CHOICE_OF_PAIRS = 3.0, 1.0
# Where nothing that was read is like it, the share of that; and at most: what is known decides between near-equals.
_ADVANCE_UNREAD, _MOST_AHEAD = 0.5, 10.0
# What a string is behind in which traditional and simplified characters stand beside each other: few signs mix them.
_MIXED = 4.0
# What another form of a known name is behind the form that is listed: traditional, simplified or Japanese characters.
_OTHER_FORM = 2.0
_READINGS_WEIGHED = 24  # spellings, the weightiest; what many readings explain, all do
_READINGS_LOOKED_UP = 8  # spellings whose known neighbours are tried
_READINGS_RESPELLED = 8  # spellings of which one word is tried as the known one a slip away

# Log odds that a name is exactly right: bias, and what they grow by with the posterior's.
# python benchmarks/text_calibration.py names --rows DIR
_CERTAINTY = (-0.711, 0.570)
_SUREST = 9.0  # of log odds that are believed


@dataclass(frozen=True, slots=True)
class Certain:
    """A name, why, and what its certainty rests on.

    Attributes:
        name, evidence: as of a `Naming`.
        terms: one, and the posterior's log odds.
    """

    name: str
    evidence: str
    terms: tuple[float, float]

    @property
    def certainty(self) -> float:
        """How surely the name is exactly right, 0 to 1."""
        odds = sum(a * b for a, b in zip(_CERTAINTY, self.terms, strict=True))
        return 1.0 / (1.0 + exp(ODD_MARK * bool(odd_marks(self.name)) - odds))


class Namer:
    """Names classes of misread strings."""

    def __init__(self, knowledge: Knowledge, signs: SignReader) -> None:
        self._fold = knowledge.folder
        self._signs = signs
        self._knowledge = knowledge

    @cached_property
    def _vocabulary(self) -> frozenset[str]:
        """Common words, and rarer ones of signs: an answer that names nothing does not wait for them."""
        painted = {key for key in self._knowledge.painted if key.isascii() and key.isalpha()}
        of_signs = _words_of_signs(self._knowledge) | painted
        return load_words() | {word for word in of_signs if len(word) >= LEAST_RESPELLED}

    @cached_property
    def _lost(self) -> LostLetters:
        names = [known.painted for known in self._knowledge.known.values()]
        return LostLetters(self._vocabulary, load_short_words() | _words_of_signs(self._knowledge), names)

    def name(self, readings: Sequence[Reading], model: str) -> Naming:
        """Name a class; where nothing with a letter in it was read, without any certainty."""
        if not evidence_of(readings):
            text = vote(readings).text
            return Naming(text, 0.0, "no reading has a letter in it" if text else "no reading has a character", model)
        best = self.most_certain(readings)
        return Naming(best.name, best.certainty, best.evidence, model)

    def most_certain(self, readings: Sequence[Reading]) -> Certain:
        """Take the string that is most probable, all readings being given; known names are likelier than others."""
        seen = evidence_of(readings, self._lost.spaces)
        doubtful = list(doubted(seen, self._makes_a_word))
        forms = self._candidates(seen, readings, doubtful)
        read_words = {word for each in readings for word in self._words(each.text)}
        words = {key: self._words_ahead(text, read_words) for key, text in forms.items()}
        for each in readings:
            if (own := paint_key(each.text)) in words:
                words[own] = max(words[own], self._words_ahead(each.text, read_words))
        known = {key: self._known(key) for key in forms}
        read = {each.key for each in seen}
        alike = {self._looks(key) for key in read}
        # What the reader held for possible is read as well: its own odds say how surely.
        possible = {key for key in doubtful if any(map(is_ideograph, key))}
        alike |= {self._looks(key) for key in possible}
        keys = {self._fold.key(key) for key in read | possible}
        words = {key: ahead + self._words_unspaced(self._fold.key(key), keys) for key, ahead in words.items()}
        priors = {key: self._advance(key, known[key], words[key], self._looks(key) in alike) for key in forms}
        probabilities = posterior(priors, seen, self._looks)
        # On a tie the weightiest reading stays.
        best = max((key for key in forms if key != ELSE), key=lambda key: (probabilities[key], -list(forms).index(key)))
        name, evidence = self._painted(best, forms[best], known[best], readings, best in read)
        return Certain(name, evidence, (1.0, _log_odds(probabilities[best])))

    def _looks(self, text: str) -> str:
        return self._fold.skeleton(self._fold.fold(text))

    def _candidates(self, seen: Sequence[Seen], readings: Sequence[Reading], doubtful: Sequence[str]) -> dict[str, str]:
        """The keys that may be painted, each with a form of it; those that were read come first, then the doubtful."""
        texts: dict[str, str] = {}
        for each in sorted(readings, key=lambda each: -each.count * (each.right or each.confidence)):
            texts.setdefault(paint_key(each.text), clean_text(each.text))
        forms = {each.key: texts[each.key] for each in seen[:_READINGS_WEIGHED]}
        read = set(texts)
        template = forms[seen[0].key]
        voted = vote(readings).text
        forms.setdefault(paint_key(voted), voted)
        for first, second in put_together(seen):
            forms.setdefault(first + second, f"{texts[first]} {texts[second]}")
        for key in doubtful:
            if key:
                forms.setdefault(key, respaced(key, template))
        for key in list(forms)[:_READINGS_LOOKED_UP]:
            for _, known in self._signs.nearest(self._fold.key(key)) if key else []:
                self._add_known(forms, known.painted, forms[key])
        for near in [voted, *(forms[each.key] for each in seen[:_READINGS_RESPELLED])]:
            for text in respelled(self._fold.fold(near), self._vocabulary):
                if paint_key(text) not in read:
                    forms[paint_key(text)] = cased_like(text, near)
            for text in self._lost.filled(near):
                forms.setdefault(paint_key(text), text)
        forms.pop(ELSE, None)
        return forms

    def _add_known(self, forms: dict[str, str], painted: str, like: str) -> None:
        """Add a known name in the script of what was read; a consistent form that was read is the same name already."""
        key = self._fold.key(painted)
        if any(self._fold.key(other) == key and not self._fold.is_mixed(other) for other in forms):
            return
        text = self._fold.traditional(painted) if self._fold.is_traditional(like) else painted
        forms.setdefault(paint_key(text), cased_like(text, like))

    def _known(self, key: str) -> Known | None:
        folded = self._fold.key(key)
        return next(
            (known for edits, known in self._signs.nearest(folded) if self._fold.key(known.painted) == folded), None
        )

    def _words(self, text: str) -> Iterator[str]:
        return words_of(self._fold.fold(text), self._vocabulary)

    def _words_ahead(self, text: str, read: Set[str]) -> float:
        known = [word for word in self._words(text) if word in self._vocabulary]
        return sum(
            max(_ADVANCE_WORD * len(word) - _CHOICE_OF_WORDS, 0.0) * (1.0 if word in read else _ADVANCE_UNREAD)
            for word in known
        )

    def _words_unspaced(self, key: str, read: Set[str]) -> float:
        """What common Chinese words put a folded key ahead, and a known name that it begins or ends with."""
        tail = self._signs.known_tail(key)
        head = min(self._signs.brand_head(key), len(key) - tail)
        letter = _ADVANCE_IDEOGRAPH if is_unspaced(key) else _ADVANCE_LETTER
        # “必胜客欢乐餐厅” is no listed name, but begins with one; “鸿达茶餐厅” ends with what it is.
        parts = _ADVANCE_UNREAD * (letter * head + _ADVANCE_IDEOGRAPH * tail)
        return parts + sum(
            (_ADVANCE_IDEOGRAPH * len(word) - _CHOICE_OF_PAIRS)
            * (1.0 if any(word in each for each in read) else _ADVANCE_UNREAD)
            for word in words_in(key[head : len(key) - tail])
        )

    def _makes_a_word(self, key: str, at: int, letter: str) -> bool:
        """Whether an ideograph in place `at` of a key makes a word with those beside it where there is none."""
        if not is_ideograph(letter) or is_in_a_word(self._fold.key(key), at):
            return False
        return is_in_a_word(self._fold.key(key[:at] + letter + key[at + 1 :]), at)

    def _advance(self, key: str, known: Known | None, words: float, is_read: bool) -> float:
        letter = _ADVANCE_IDEOGRAPH if is_unspaced(key) else _ADVANCE_LETTER
        if known is not None:
            # A known name is no worse than one of which only some words are known; brands of one word are as many as
            # words are.
            is_one_word = known.source == "brand" and known.painted.isascii() and known.painted.isalpha()
            of_letters = letter * len(key) - _CHOICE_OF_WORDS * is_one_word
            advance = max(of_letters * (1.0 if is_read else _ADVANCE_UNREAD), words)
            advance = min(advance, _MOST_AHEAD) - _OTHER_FORM * (paint_key(known.painted) != key)
        else:
            advance = words
        return min(advance, _MOST_AHEAD) - _MIXED * self._fold.is_mixed(key)

    def _painted(
        self, key: str, form: str, known: Known | None, readings: Sequence[Reading], is_read: bool
    ) -> tuple[str, str]:
        """The name with its case, spaces and marks as most readings have them, and why."""
        if not is_read:
            return form, f"the readings are nearest to {known.painted}" if known else "the readings are a slip away"
        same = [each for each in readings if paint_key(each.text) == key]
        text = with_gaps(vote(same).text, self._vocabulary)
        if known is None:
            return text, "most of what was read well says so"
        # Only spaces and punctuation may differ: a warning's words are set apart, a brand stays as it is painted; a
        # mark that it has, and that was read even once, was there.
        evidence = f"the readings agree on {known.painted}"
        if known.source == "brand":
            # A shop may be called like a brand and have a mark that this has not (FOSTER'S).
            is_marked_more = bool(_marks_of(text) - _marks_of(known.painted))
            marked = [each.text for each in same if each.text.casefold() == known.painted.casefold()]
            return text if is_marked_more or not marked else marked[0], evidence
        is_same_form = paint_key(known.painted) == key
        return painted_like(known.painted, text) if is_same_form else text, evidence


def _words_of_signs(knowledge: Knowledge) -> frozenset[str]:
    """Words that signs are painted with by themselves, rarer than common ones: florist, optician, haberdashery."""
    return frozenset(
        key
        for key, known in knowledge.known.items()
        if known.source != "brand" and key.isascii() and " " not in known.painted
    )


def respaced(key: str, text: str) -> str:
    """Write a key with the case, spaces and marks of a text that is like it."""
    places = [at for at, ch in enumerate(text) if ch.isalnum()]
    letters = list(text)
    own = "".join(text[at] for at in places).casefold()
    if len(own) != len(places):
        return key
    for step in Levenshtein.editops(own, key):
        at = places[min(step.src_pos, len(places) - 1)]
        new = "" if step.tag == "delete" else key[step.dest_pos]
        new = new.upper() if text[at].isupper() else new
        if step.tag == "insert":
            letters[at] = new + letters[at] if step.src_pos < len(places) else letters[at] + new
        else:
            letters[at] = new
    return clean_text("".join(letters))


def _marks_of(text: str) -> Counter[str]:
    return Counter(ch for ch in text if not ch.isalnum() and not ch.isspace())


def _log_odds(probability: float) -> float:
    odds = max(probability, 1e-6) / max(1.0 - probability, 1e-6)
    return min(max(log(odds), -_SUREST), _SUREST)
