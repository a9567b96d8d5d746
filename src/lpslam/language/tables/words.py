"""Text cut into units that compare alike in every script.

A unit is one word of a script that spaces its words, or one character of a script that does not (Han, kana, Hangul,
Thai). A phrase is a run of units; its key joins them with single spaces, so one table serves every language.
"""

import unicodedata
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Generic, Protocol, TypeVar

from lpslam.language.tables.patterns import standing

_UNSPACED = "\u0e00-\u0e7f\u1100-\u11ff\u3040-\u30ff\u3400-\u4dbf\u4e00-\u9fff\uac00-\ud7af\uf900-\ufaff"
_UNIT = standing(rf"[{_UNSPACED}]|[^\W_{_UNSPACED}]+|[^\w\s]")
_LETTERS_UNSPACED = standing("[\u3041-\u3096\u30a1-\u30fa\u30fc\u3400-\u4dbf\u4e00-\u9fff\uac00-\ud7a3]+")
_PLAIN = standing("[a-zA-Z0-9 ]+")
_CAMEL = standing(r"(?<=[a-zß-ÿ])(?=[A-ZÀ-Þ])")
_INNER_HYPHEN = standing(r"(?<=[^\W\d_])-(?=[^\W\d_])")
_ACCENT = standing("[\u0300-\u036f]")
_NOT_LETTER = standing(r"[\W_]+")
UNSPACED_RUN = standing(f"[{_UNSPACED}]+")
_BEGINS_UNSPACED = standing(f"[{_UNSPACED}]")
_FIRST_UNSPACED = _UNSPACED[0]

Value = TypeVar("Value")
Said = TypeVar("Said", covariant=True)

_KEPT = 64  # texts whose units are kept: a question, its parts, and the board that is held against it
_WRITTEN_OUT = {"n't": " not", "n’t": " not", "cannot": "can not", "&": " and ", "ß": "ss"}
_NO_SIZES: tuple[int, ...] = ()


class Phrases(Protocol[Said]):
    """A table of phrases that tells how long those are that may begin at a unit of a text."""

    def get(self, key: str, /) -> Said | None:
        """What a phrase says; None where it is none."""
        ...

    def sizes(self, units: Sequence[str], at: int, /) -> Collection[int]:
        """The lengths, in units, of all phrases that may begin at one of some units, and perhaps others."""
        ...


class PhraseTable(dict[str, Value]):
    """What phrases say; not to be changed once any was looked for in a text."""

    @cached_property
    def _sizes(self) -> Mapping[str, tuple[int, ...]]:
        # A bit a length: tables have 200,000 phrases, and all are gone through before the first answer.
        bits: dict[str, int] = {}
        for phrase in self:
            unit = phrase.partition(" ")[0]
            bits[unit] = bits.get(unit, 0) | 1 << phrase.count(" ")
        sizes = {
            each: tuple(at + 1 for at in range(each.bit_length()) if each >> at & 1) for each in set(bits.values())
        }
        return {unit: sizes[each] for unit, each in bits.items()}

    def sizes(self, units: Sequence[str], at: int, /) -> tuple[int, ...]:
        """The lengths of all phrases whose first unit that is."""
        return self._sizes.get(units[at], _NO_SIZES)


@dataclass(frozen=True, slots=True)
class Span(Generic[Value]):
    """A phrase found in a text: units `start` to `end` (exclusive), its key and what the table says of it."""

    start: int
    end: int
    key: str
    value: Value


class Folder:
    """Folds case, accents, width and traditional characters away; holds the tables of characters.

    `lookalikes` are pairs of letters that readers of signs confuse, separated by spaces ("0o 1l"); `both` are
    characters that are simplified forms of some traditional ones and traditional themselves.
    """

    def __init__(self, traditional: str = "", simplified: str = "", lookalikes: str = "", both: str = "") -> None:
        apostrophes = dict.fromkeys(map(ord, "’‘`´ʼ"), "'")
        # Turkish ı has no accent to lose.
        self._plain = str.maketrans(traditional, simplified) | apostrophes | {ord("ı"): "i"}
        self._traditional = {old: new for old, new in zip(traditional, simplified, strict=True) if old != new}
        # Of several traditional characters that became one, the commonest is listed first.
        self._simplified = {new: old for old, new in reversed(self._traditional.items()) if new not in both}
        self._alike = {ord(pair[0]): pair[1] for pair in lookalikes.split()}
        # One question is cut again and again.
        self._cut = lru_cache(maxsize=_KEPT)(lambda text: tuple(_units(self.fold(text))))

    def fold(self, text: str) -> str:
        """Return `text` as it is compared: NFKC, no case, no accents, simplified characters, `'` for apostrophes."""
        if text.isascii():
            return text.casefold()
        bare = _ACCENT.sub("", unicodedata.normalize("NFKD", text))
        return unicodedata.normalize("NFC", bare).translate(self._plain).casefold()

    def is_traditional(self, text: str) -> bool:
        """Whether a Chinese text is written in traditional characters: it has some, and none that is simplified."""
        return any(ch in self._traditional for ch in text) and not any(ch in self._simplified for ch in text)

    def is_mixed(self, text: str) -> bool:
        """Whether a Chinese text has characters that are only traditional beside some that are only simplified."""
        return any(ch in self._traditional for ch in text) and any(ch in self._simplified for ch in text)

    def traditional(self, text: str) -> str:
        """Return a simplified text in traditional characters, letter by letter."""
        return "".join(self._simplified.get(ch, ch) for ch in text)

    def key(self, text: str) -> str:
        """Return the letters and digits of `text` alone: what stays when spaces and punctuation were misread."""
        return _NOT_LETTER.sub("", self.fold(text))

    def skeleton(self, key: str) -> str:
        """Return what is left of a key when letters that look alike count as one."""
        return key.translate(self._alike).replace("vv", "w").replace("rn", "m")

    def units(self, text: str) -> list[str]:
        """Return the units of `text` in order; punctuation marks are units of their own."""
        return list(self._cut(text))

    def without(self, text: str, left_out: Collection[int]) -> str:
        """Return a text without some of its units: as it is written, or its units where writing hides them."""
        for short, long in _WRITTEN_OUT.items():
            text = text.replace(short, long)
        folded = self.fold(text)
        found = [each for each in _UNIT.finditer(folded) if each.group() != "'"]
        units = _units(folded)
        if len(found) != len(units) or len(folded) != len(text):
            joint = "" if is_unspaced(text) else " "
            return joint.join(unit for at, unit in enumerate(units) if at not in left_out)
        for at in sorted(left_out, reverse=True):
            text = f"{text[: found[at].start()]} {text[found[at].end() :]}"
        return " ".join(text.split())

    def word_starts(self, text: str) -> frozenset[int]:
        """Return which units of a text begin a word that a space sets apart."""
        folded = self.fold(text)
        starts = [found.start() for found in _UNIT.finditer(folded) if found.group() != "'"]
        if len(starts) != len(_units(folded)):
            return frozenset()
        return frozenset(at for at, start in enumerate(starts) if start and folded[start - 1].isspace())

    def sign_units(self, text: str) -> list[str]:
        """Return the units of a sign: a capital inside a word begins a new one, and so does a hyphen in it."""
        return self.units(_INNER_HYPHEN.sub(" ", _CAMEL.sub(" ", text)))

    def phrase(self, text: str) -> str:
        """Return the key under which `text` stands in a phrase table."""
        return self.phrase_and_key(text)[0]

    def phrase_and_key(self, text: str) -> tuple[str, str]:
        """Return `phrase` and `key` of a text; quicker together."""
        if _LETTERS_UNSPACED.fullmatch(text):
            folded = self.fold(text)
            return " ".join(folded), folded
        if _PLAIN.fullmatch(text) and "cannot" not in text:
            words = text.casefold().split()
            return " ".join(map(_stem, words)), "".join(words)
        folded = self.fold(text)
        return " ".join(unit for unit in _units(folded) if not is_mark(unit)), _NOT_LETTER.sub("", folded)


def _units(folded: str) -> list[str]:
    if folded.isalpha() and folded.isascii() and "cannot" not in folded:
        return [_stem(folded)]
    if "'" in folded or "&" in folded or "cannot" in folded:
        folded = folded.replace("n't", " not").replace("cannot", "can not").replace("&", " and ")
    return [_stem(unit) for unit in _UNIT.findall(folded) if unit != "'"]


def is_mark(unit: str) -> bool:
    """Whether a unit is punctuation."""
    return not (unit[0].isalnum() or unit[0] == "_")


def is_unspaced(text: str) -> bool:
    """Whether `text` begins in a script that writes no spaces between words."""
    return text >= _FIRST_UNSPACED and _BEGINS_UNSPACED.match(text) is not None


def longest_phrases(
    units: Sequence[str],
    tables: Iterable[Phrases[Value]],
    is_barred: Callable[[int, int, Value], bool] | None = None,
    longest: int = 12,
) -> list[Span[Value]]:
    """Return the phrases of `tables` found in `units`, from the left, longest first; earlier tables win a tie.

    Phrases do not overlap and do not reach over punctuation; `is_barred` says of (start, end, value) that it is none.
    """
    chain = tuple(tables)
    found: list[Span[Value]] = []
    at = 0
    while at < len(units):
        sizes: Collection[int] = ()
        for table in chain:
            # Most units begin no phrase, or phrases of one table.
            if of_table := table.sizes(units, at):
                sizes = {*sizes, *of_table} if sizes else of_table
        span = _phrase_at(units, at, chain, sizes, is_barred, longest) if sizes else None
        if span is not None:
            found.append(span)
        at = span.end if span is not None else at + 1
    return found


def _phrase_at(
    units: Sequence[str],
    at: int,
    chain: tuple[Phrases[Value], ...],
    sizes: Collection[int],
    is_barred: Callable[[int, int, Value], bool] | None,
    longest: int,
) -> Span[Value] | None:
    """The longest phrase of one of some sizes, in units, that begins at a place."""
    room = min(len(units) - at, longest)
    for size in sorted(sizes, reverse=True) if len(sizes) > 1 else sizes:
        if size > room:
            continue
        key = " ".join(units[at : at + size])
        for table in chain:
            value = table.get(key)
            if value is not None and not (is_barred and is_barred(at, at + size, value)):
                return Span(at, at + size, key, value)
    return None


@lru_cache(maxsize=1 << 14)
def _stem(unit: str) -> str:
    """Drop a plural ending; crude, but the same for the table and for the text."""
    if len(unit) <= 3 or not unit.isascii() or not unit.isalpha():
        return unit
    if unit.endswith("ies"):
        return unit[:-3] + "y"
    if unit.endswith(("sses", "shes", "ches", "xes")):
        return unit[:-2]
    return unit[:-1] if unit.endswith("s") and not unit.endswith(("ss", "us", "is")) else unit
