"""Numbers in words: cardinals below a thousand and the lower ordinals, in the languages that space words.

The words and how they are put together follow Unicode CLDR's rule-based number formats (spellout-cardinal and
spellout-ordinal); Chinese, Japanese and Korean numerals are read digit by digit. Any of the seven is also heard digit
by digit: “two oh four”, “zwo null vier”, 이공사호.
"""

import re
import unicodedata
from bisect import bisect_left
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import product
from typing import Any

from lpslam.language.kept import kept
from lpslam.language.languages import LATIN
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing

_ARTICLES = frozenset({"un", "una", "une", "ein", "eine", "einen", "einer"})
"""Numbers that are articles wherever more follows."""
_AT_FIRST = frozenset({"first", "erst", "primero"})  # they say when behind a thing: “the school office first”
_LONGEST = 6  # words of a number below a thousand: "quatre cent quatre vingt dix neuf"
_LONGEST_GROUP = 3  # words of a number below a hundred: "vingt et un"
_MOST_DIGITS = 4  # of a number that is said in groups
_HUNDRED = 100
_WORD = standing(r"[a-zß-ÿœ]+")
_BROKEN = standing(r"[^\w\s-]|_|\d")  # what does not stand within a number
_HAN = {ch: at for at, ch in enumerate("〇一二三四五六七八九")} | {"零": 0, "两": 2, "兩": 2}
_HANGUL = {ch: at for at, ch in enumerate("영일이삼사오육칠팔구")} | {"공": 0}
_STEPS = {"十": 10, "百": 100, "십": 10, "백": 100}
_POINT = standing(r"(?<!\w)(\w+) (?:point|dot|punkt|punto) (?=(\w+))")


@lru_cache(maxsize=1)
def _tables() -> Mapping[str, Mapping[str, Any]]:
    tables: Mapping[str, Mapping[str, Any]] = read_table("wishes/numerals.json")
    return tables


def _words(joined: str) -> list[list[str]]:
    """“un|une deux” → [[un, une], [deux]]: the forms of each number in turn."""
    return [forms.split("|") for forms in joined.replace("| ", "|").split(" ")]


@lru_cache(maxsize=1 << 12)
def _key(text: str) -> str:
    """A number as it is compared: its letters without accents."""
    if text.isascii() and text.isalpha():
        return text.casefold()
    bare = unicodedata.normalize("NFKD", text.casefold().replace("ß", "ss"))
    return "".join(ch for ch in bare if ch.isalpha())


@lru_cache(maxsize=1)
def _cardinals() -> Mapping[str, int]:
    """Every cardinal from 1 to 999 of the languages that space words, by its letters; kept, being 18,000."""
    made: dict[str, int] = kept("cardinals", b"", _made)
    return made


def _made() -> dict[str, int]:
    found: dict[str, int] = {}
    for language in LATIN:
        for number, spelled in _of_language(_tables()[language]):
            found.setdefault(_key(spelled), number)
    return found


def _of_language(table: Mapping[str, Any]) -> Iterator[tuple[int, str]]:
    below = dict(_below_hundred(table))
    yield from ((number, form) for number, forms in below.items() if number for form in forms)
    if "hundreds" in table:
        heads = {100 * (at + 1): forms for at, forms in enumerate(_words(table["hundreds"]))}
    else:
        hundred = table["hundred"].split("|")
        heads = {
            100 * count: [
                f"{one}{word}" for one in ([*below[1], ""] if count == 1 else below[count]) for word in hundred
            ]
            for count in range(1, 10)
        }
    for head, forms in heads.items():
        yield from ((head, form) for form in forms)
        for rest, rests in below.items():
            for form, link, other in product(forms, ("", table.get("and", "")), rests if rest else ()):
                yield head + rest, f"{form}{link}{other}"


def _below_hundred(table: Mapping[str, Any]) -> Iterator[tuple[int, list[str]]]:
    ones = _words(table["ones"])
    yield from enumerate(ones)
    link, is_reversed = table.get("link", ""), table.get("reversed", False)
    scores = table.get("scores", ())
    for at, forms in enumerate(_words(table["tens"])):
        ten = 20 + 10 * at
        # Seventy is sixty and ten in French, and ninety eighty and ten.
        extra = 10 if ten in scores else 0
        for one in range(10):
            if ten + one < len(ones):
                continue
            if not one and not extra:
                yield ten, forms
                continue
            parts = product(forms, ("", link), ones[one + extra])
            yield ten + one, [f"{o}{j}{t}" if is_reversed else f"{t}{j}{o}" for t, j, o in parts]


@lru_cache(maxsize=8)
def ordinals(language: str) -> Mapping[str, int]:
    """Return the ordinal numbers of a language by how they are written: zweiten, 2nd, 二."""
    table = _tables()[language]
    # A form of several words is written with its spaces: “두 번째”.
    spoken = [forms.split("|") for forms in re.split(r" (?!번째)", table["ordinals"])]
    found: dict[str, int] = {}
    for at, forms in enumerate(spoken):
        for form in forms:
            found |= dict.fromkeys([form + end for end in table.get("endings", "").split()] or [form], at + 1)
            found.setdefault(form, at + 1)
        if "suffixes" in table:
            found |= {f"{at + 1}{end}": at + 1 for end in table["suffixes"].replace("\\", "").split("|")}
        found.setdefault(str(at + 1), at + 1)
    return found


@lru_cache(maxsize=1)
def _ordinals() -> Mapping[str, int]:
    return {_key(word): at for language in LATIN for word, at in ordinals(language).items() if _key(word) == word}


@lru_cache(maxsize=1)
def digit_ordinal() -> re.Pattern[str]:
    """A pattern of ordinals in digits, of all languages: 3rd, 3., 3e, 3º; group 1 is the number."""
    ends = "|".join(_tables()[language]["suffixes"] for language in LATIN)
    return standing(rf"(?<![\w.-])(\d{{1,3}})(?:{ends})(?= )")


@lru_cache(maxsize=1)
def _digits() -> Mapping[str, str]:
    """The digits of the languages that space words, by how they are said one by one."""
    found: dict[str, str] = {}
    for language in LATIN:
        table = _tables()[language]
        for at, forms in enumerate(_words(table["ones"])[:10]):
            found |= {_key(form): str(at) for form in forms}
        found |= {_key(form): "0" for form in table.get("zeros", "").split("|") if form}
    return found


@lru_cache(maxsize=2)
def _letters(table: str) -> tuple[re.Pattern[str], Mapping[str, str]]:
    """A pattern of what letters are called, where a number comes next, and the letter of each name."""
    named = {name: letter for letter, names in _tables()[table].items() for name in names.split("|")}
    spoken = {form for language in LATIN for forms in _words(_tables()[language]["ones"]) for form in forms}
    spoken |= {form for language in LATIN for forms in _words(_tables()[language]["tens"]) for form in forms}
    number = "|".join(sorted(spoken, key=len, reverse=True))
    return standing(rf"(?<!\w)({'|'.join(named)})(?= (?:\d|(?:{number})\b))"), named


def with_letters(folded: str, follows: Callable[[str, int], bool]) -> str:
    """Return a text, without case, in which letters called by their names before a number are letters: “cee ten”.

    Names that are words as well are so only where something that is numbered stands before (`follows`): puerta be dos.
    """
    pattern, named = _letters("letters")
    folded = pattern.sub(lambda hit: named[hit.group()], folded)
    doubtful, letters = _letters("letters of things")
    folded = doubtful.sub(lambda hit: letters[hit.group()] if follows(hit.string, hit.start()) else hit.group(), folded)
    # “Hall bee” has no number; “be” and “té” are words.
    longer = {name: letter for name, letter in named.items() if len(name) > 2}
    return _WORD.sub(
        lambda hit: longer[hit[0]] if hit[0] in longer and follows(folded, hit.start()) else hit[0], folded
    )


@lru_cache(maxsize=1)
def _unspaced_letters() -> tuple[re.Pattern[str], Mapping[str, str]]:
    """A pattern of what Korean and Japanese call letters, as a word by itself, and the letter of each name."""
    joined = _tables()["letters of unspaced scripts"]
    named = {name: letter for letter, names in joined.items() for name in names.split("|")}
    names = "|".join(sorted(named, key=len, reverse=True))
    return standing(rf"(?<=[가-힣ァ-ヴー一-龥] )(?:{names})(?=$|[^가-힣ァ-ヴー]|[은는이가을를에로]|으로|까지)"), named


def with_unspaced_letters(folded: str, follows: Callable[[str, int], bool]) -> str:
    """Return a text in which letters as Korean and Japanese call them are letters: 회의실 비."""
    pattern, named = _unspaced_letters()
    return pattern.sub(lambda hit: named[hit.group()] if follows(folded, hit.start()) else hit.group(), folded)


def with_digits(folded: str, follows: Callable[[int], bool], leads: Callable[[int], bool]) -> str:
    """Return a text, without case, in which the numbers of things that are numbered are digits.

    Args:
        folded: without case.
        follows: whether what stands before a place in the text is something that is numbered (“terminal | two”).
        leads: whether what stands after it is (“second | floor”); only ordinals stand before it.
    """
    words = list(_WORD.finditer(folded))
    pieces: list[str] = []
    done = at = 0
    while at < len(words):
        if not _begins_number(_key(words[at].group())):
            at += 1
            continue
        number, end = _number_at(folded, words, at, follows(words[at].start()), leads)
        if number is not None:
            pieces += [folded[done : words[at].start()], number]
            done = words[end - 1].end()
        at = end
    return "".join(pieces) + folded[done:]


def with_points(folded: str) -> str:
    """Return a text in which points that are said between numbers are points: “one point oh seven” → “one.oh seven”."""
    return _POINT.sub(lambda hit: f"{_digits_of(hit[1])}." if all(map(_digits_of, hit.groups())) else hit[0], folded)


def _digits_of(word: str) -> str:
    """A word of a number as digits; "" where it is none."""
    return word if word.isdigit() else _digits().get(_key(word), "") or str(_cardinals().get(_key(word), ""))


def _number_at(
    folded: str, words: Sequence[re.Match[str]], at: int, follows: bool, leads: Callable[[int], bool]
) -> tuple[str | None, int]:
    """The digits of the number that begins at a word, and where the words after it begin."""
    for end in range(min(len(words), at + _LONGEST), at, -1):
        stretch = folded[words[at].start() : words[end - 1].end()]
        if _BROKEN.search(stretch):
            continue
        key = _key(stretch)
        if follows and end - at > 1 and key not in _cardinals() and key not in _ordinals():
            in_groups = _in_groups([_key(word.group()) for word in words[at:end]])
            if in_groups:
                return in_groups, end
        if follows and key in _cardinals() and not (key in _ARTICLES and folded[words[end - 1].end() :].strip(" .?!")):
            return str(_cardinals()[key]), end
        if key in _ordinals() and ((follows and key not in _AT_FIRST) or leads(words[end - 1].end())):
            return str(_ordinals()[key]), end
    return None, at + 1


@lru_cache(maxsize=1)
def _in_order() -> Sequence[str]:
    """The letters of all numbers in the order of the alphabet."""
    return sorted({*_cardinals(), *_ordinals(), *_digits()})


@lru_cache(maxsize=1 << 12)
def _begins_number(key: str) -> bool:
    """Whether the letters of any number begin with these."""
    numbers = _in_order()
    at = bisect_left(numbers, key)
    return at < len(numbers) and numbers[at].startswith(key)


def _in_groups(keys: Sequence[str]) -> str:
    """The digits of a number said in groups: “two ten” is 210, “twelve oh four” 1204; "" where it is none."""
    for size in range(min(len(keys), _LONGEST_GROUP), 0, -1):
        key = "".join(keys[:size])
        number = _cardinals().get(key, _HUNDRED)
        group = str(number) if number < _HUNDRED else _digits().get(key, "")
        rest = _in_groups(keys[size:]) if group else ""
        if group and (rest or size == len(keys)) and len(group + rest) <= _MOST_DIGITS:
            return group + rest
    return ""


def number_of(numeral: str) -> int:
    """Return the number that Chinese or Korean numerals say: 二十三, 一〇二, 이십삼."""
    digits = {**_HAN, **_HANGUL}
    if not any(ch in _STEPS for ch in numeral):
        return int("".join(str(digits[ch]) for ch in numeral if ch in digits) or "0")
    total, last = 0, None
    for ch in numeral:
        if ch in _STEPS:
            total += _STEPS[ch] * (1 if last is None else last)
            last = None
        elif ch in digits:
            last = digits[ch]
    return total + (last or 0)
