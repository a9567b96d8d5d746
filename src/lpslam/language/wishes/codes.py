"""Numbers and codes: what a question asks for and what a board bears, with ranges (gate B31 lies in B20–B38).

A code is a number, a letter with one (B31, 3.14, 2-105), or a letter that stands beside what is numbered (Zone C).
"""

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache

from lpslam.language.sanitise import clean_text
from lpslam.language.signs.hours import without_hours
from lpslam.language.tables.knowledge import load_chinese_words
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.code import Code, code_in, range_of
from lpslam.language.wishes.form import Identity, Sort
from lpslam.language.wishes.numerals import (
    digit_ordinal,
    number_of,
    with_digits,
    with_letters,
    with_points,
    with_unspaced_letters,
)

_AMOUNTS: Mapping[str, str] = read_table("wishes/quantities.json")
_KEPT = 64  # texts as codes are looked for in them: a question and its parts
_UNSPACED_NUMBER = standing(_AMOUNTS["number of unspaced scripts"])
_NUMERAL = standing(
    r"[〇零一二三四五六七八九两兩十百]+|(?<![가-힣])(?P<hangul>[일이삼사오육칠팔구십백]+)|(?<=제)[일이삼사오육칠팔구십백]+"
)
_ENDS_NUMERAL = standing(r"$|[^\u4e00-\u9fff가-힣]|[在怎吗嗎呢去哪远遠往等的吧那은는이가을를에로]|까지")
_FEWEST_TOGETHER = 3  # characters of a numeral and of what it numbers right behind it: 四病棟, but 이동
_THIS_ONE = standing(r"(?<![가-힣])([일이삼사오육칠팔구])(?=번 (?!정류장)(\S+))")  # “이번 정류장” is this stop
_ONE = r"(?:[a-z]{1,2}[-.]?|[b-z] )?\d{1,4}(?:[-.]\d{1,4}){0,2}(?:-?[a-z]| [a-z](?=[\u2e80-\uffff]))?|[a-z]"
_CODE = standing(rf"(?<![a-zà-ÿ0-9'’])({_ONE})(?![^\W_\u2e80-\uffff])(?!['’-][^\W\d_])")
_END = r"([a-z]{0,2}[-.]?\d{1,4}(?:\.\d{1,3})?[a-z]?|[a-z]{1,2})"
_RANGE = standing(rf"(?<![a-zà-ÿ0-9])(?<!\d\.){_END} ?(?:{_AMOUNTS['to']}) ?{_END}(?![a-z0-9])")
_QUANTITY = standing(
    rf"\d+(?:[.,:h]\d+)? ?(?:{_AMOUNTS['times']}|{_AMOUNTS['measures']})(?![a-z])|\d{{1,2}}:\d{{2}}|[$€£¥]\d+"
    rf"|(?<!\w)(?:{_AMOUNTS['years']}) (?:1[5-9]|20)\d\d(?!\w)|(?:{_AMOUNTS['sizes']}) ?\d+",
    re.IGNORECASE,
)
_AGES = standing(
    rf"(?:\d+ ?(?:{_AMOUNTS['to']}) ?)?\d+ ?(?:years?|años|ans|jahren?|岁|歳|才|살|세)(?![^\W\d_\u2e80-\uffff])"
)
_PLURAL = "es|s|x"
_SHORTEST_HEAD = 4  # letters of the head of a compound
_BEFORE, _AFTER = 26, 8  # letters around a code in which the word for what is numbered is looked for
_FEWEST_SPOKEN = 3  # digits of a number in words that is a room's where nothing says so
_NUMBER_WORD = standing(r"(?<!\w)(?:number|nummer|numéro|número|the|die|den|der|das|el|la|le|les|los|las)(?!\w)")
_FEW_WORDS, _SHORT = 2, 16  # words and letters of a question that may be no more than a number
_COUNTERS = " 号號番번-の"
_COUNTED = standing("^호 ?(?=[가-힣])")  # 2호 엘리베이터 is a lift, 203호 a room
_LISTED = standing(r"^(?:[・·、]\d{1,4})+")  # further numbers of the same: 3・4番線
_LETTER_BEFORE = standing(r"(?<![^\W_])[b-df-hj-np-tv-xz]$")  # no word of any language: “B seven”
_BETWEEN = standing(_AMOUNTS["between"])
"""What may stand between “gates” and a number: other numbers, “no.”, “and”."""
_LEVELS = frozenset({"floor"})
_ORDINAL_BEFORE = standing(r"\d(?:st|nd|rd|th|\.|er|e|ère|ème|º|ª|°)? $")  # “3rd floor: 301–312”
_NUMBERED_ONE = standing(r"(?<![\w.,:])(\d{3,4})er(?!\w)")  # “der 117er”
_NUMBER_SIGN = standing(r"(?<!\w)(?:n\.? ?°|n\.?[or]s?\.?) ?(?=\d)")  # “n° 4”, “n.º 4” as cleaned, “Nr. 4”
_ZEROS_IN_WORDS = standing(r"(?<=[a-z])0+(?=[a-z])|(?<![a-z\d])0(?=[a-z]{2})")
_LETTER_APART = standing(r"(?<![^\W_])a (?=\d{2,4}(?!\w))")
_TOKEN = standing(r"(?<![a-z\d])(?=[a-z.-]*\d|\d)[a-z\d]+(?:[.-][a-z\d]+)*(?![a-z\d])")
_LEADING_ZEROS = standing(r"(?<=[a-z][-.])[0o]+(?=\d)")  # C-O3 is asked for as C-3
_ALIKE = str.maketrans("oilzsb", "011258", ".- ")
_LAST_LETTER = standing(r"(?<=[^\W\d_] )[A-Z]$")
_LETTERED = standing(r"\d{1,4}[a-z]")
_UNSPACED_ALONE = standing("[〇零一二三四五六七八九十百]{1,5}|[영공일이삼사오육칠팔구십백]{1,5}")
_LETTER_ALONE = standing(r"(?<!\w)[b-z] $")
_HOW_MANY = standing(rf"(?<!\w)(?:{_AMOUNTS['how many']}) \d+")  # “a gift for 20”
_AFTER_POINT = standing(r"\w\.$")


@lru_cache(maxsize=1)
def _classes() -> tuple[re.Pattern[str], re.Pattern[str], Mapping[str, frozenset[str]]]:
    """Patterns of all words for what is numbered, longest first, whole or heads of compounds; what each stands for."""
    tree: Mapping[str, str] = read_table("wishes/numbered.json")
    of: dict[str, set[str]] = {}
    for name, joined in tree.items():
        for word in joined.casefold().split("|"):
            of.setdefault(word, set()).add(name)
    words = sorted(of, key=lambda word: (-len(word), word))
    spaced = [word for word in words if not is_unspaced(word)]
    unspaced = "|".join(re.escape(word) for word in words if is_unspaced(word))
    whole = rf"(?<!\w)(?:{'|'.join(map(re.escape, spaced))})(?:{_PLURAL})?(?![a-zà-ÿ])|{unspaced}"
    heads = "|".join(re.escape(word) for word in spaced if len(word) >= _SHORTEST_HEAD)
    # “Stimmräume” are rooms.
    compound = rf"{whole}|(?<=[a-zà-ÿ]{{3}})(?:{heads})(?:{_PLURAL})?(?![a-zà-ÿ])"
    return standing(whole), standing(compound), {word: frozenset(names) for word, names in of.items()}


def _named(word: str) -> frozenset[str]:
    """What a word stands for, in the singular or the plural: Spanish *salas* are rooms, halls and screens."""
    of = _classes()[2]
    return frozenset().union(*(of.get(word.removesuffix(end), ()) for end in ("", *_PLURAL.split("|"))))


def _of_code(text: str, start: int, end: int) -> frozenset[str]:
    """What is numbered by the code between: said right before it (“gate B31”) or right after it (3号登机口)."""
    after = re.split(r"[\d,;。，/|]", _LISTED.sub("", text[end : end + _AFTER]))[0]
    ahead = _starting(_COUNTED.sub("", after)) or _starting(after) or _starting(after.lstrip(_COUNTERS))
    before = re.split(r"[;。，|]", text[max(0, start - _BEFORE) : start])[-1]
    word = next(
        ((of, hit.end()) for hit, of in _last_words(before) if not _BETWEEN.sub("", before[hit.end() :])),
        (frozenset[str](), 0),
    )
    is_unspaced_after = is_unspaced(after.strip()[:1] or "a")
    return word[0] | ahead if is_unspaced_after or not word[0] else word[0]


def _of_board_code(text: str, start: int, end: int) -> frozenset[str]:
    """What is numbered by a code of a board; other words may stand between: “Caisses automatiques 13-20”."""
    of = _of_code(text, start, end)
    if of:
        return of
    before = re.split(r"[;。，|]", text[:start])[-1]
    return next((names for _, names in _last_words(before)), of)


def _starting(text: str) -> frozenset[str]:
    """What is numbered by the longest word with which a text begins."""
    text = text.strip()
    found = _classes()[0].match(text)
    # 第二排练厅 is no row: 排练 is one word.
    is_part = found is not None and len(found.group()) == 1 and text[:2] in load_chinese_words()
    return _named(found.group()) if found is not None and not is_part else frozenset()


def _last_words(text: str) -> list[tuple[re.Match[str], frozenset[str]]]:
    """The words for what is numbered, the last first; one word may stand for several, and one may have its number."""
    hits = reversed(list(_classes()[1].finditer(text)))
    return [
        (hit, of)
        for hit in hits
        if (of := _named(hit.group())) and not (of & _LEVELS and _ORDINAL_BEFORE.search(text[: hit.start()]))
    ]


@lru_cache(maxsize=_KEPT)
def _folded(text: str) -> str:
    clean = _NUMBER_SIGN.sub("", clean_text(text).casefold())
    clean = with_unspaced_letters(_NUMBERED_ONE.sub(r"\1", clean), _follows)
    clean = _THIS_ONE.sub(lambda hit: str(number_of(hit.group(1))) if _starting(hit.group(2)) else hit.group(), clean)
    clean = _UNSPACED_NUMBER.sub(lambda found: str(number_of(next(filter(None, found.groups())))), clean)
    return _NUMERAL.sub(lambda hit: str(number_of(hit.group())) if _is_number(clean, hit) else hit.group(), clean)


def _is_number(folded: str, hit: re.Match[str]) -> bool:
    """Whether a numeral of Han or Hangul stands right behind or right before what is numbered: 登机口八, 五十八病棟."""
    numeral, rest = hit.group(), folded[hit.end() :]
    is_this = numeral == "이" and rest[:1] == " "  # 출구 이 근처
    is_apart = hit["hangul"] is None or folded[hit.start() - 1 : hit.start()] == " "
    if is_apart and not is_this and _ENDS_NUMERAL.match(rest) and _follows(folded, hit.start()):
        return True
    # 이백이 호실, but 이 호실 is this room.
    thing = _classes()[0].match(rest.removeprefix(" ") if hit["hangul"] is not None and len(numeral) > 1 else rest)
    is_told = folded[: hit.start()].endswith(("第", "제"))
    return thing is not None and len(numeral + thing.group()) + is_told >= _FEWEST_TOGETHER and numeral not in "两兩"


@lru_cache(maxsize=_KEPT)
def _board(text: str) -> str:
    """A board as its codes are looked for: “Ro0m 10”, without its hours."""
    folded = _ZEROS_IN_WORDS.sub(lambda hit: "o" * len(hit.group()), _folded(without_hours(text)))
    return _LETTER_APART.sub("a", folded)


@lru_cache(maxsize=1 << 15)
def board_keys(text: str) -> frozenset[str]:
    """Return the codes of a board as readers of signs confuse them: Al6 and A16 are the same, 1-4 and 14 are not."""
    tokens = (hit.group() for hit in _TOKEN.finditer(_board(text)))
    single = [each for each in tokens if not _is_range(each)]
    return frozenset(form.translate(_ALIKE) for each in single for form in (each, _LEADING_ZEROS.sub("", each)))


def _is_range(text: str) -> bool:
    hit = _RANGE.fullmatch(text)
    return hit is not None and range_of(hit.group(1), hit.group(2), frozenset()) is not None


def alike_key(value: str) -> str:
    """Return a code as `board_keys` has it."""
    return value.translate(_ALIKE)


@lru_cache(maxsize=1 << 15)
def board_codes(text: str) -> tuple[Code, ...]:
    """Return the codes that a board bears: every number, code and range; and letters beside what is numbered."""
    folded = _board(text)
    found: list[Code] = []
    # “4 a 7 años · Sábados” numbers nothing.
    folded = _AGES.sub(" ", folded)
    for hit in _RANGE.finditer(folded):
        span = range_of(hit.group(1), hit.group(2), _of_board_code(folded, hit.start(), hit.end()))
        found += [span] if span is not None else []
    for hit in _CODE.finditer(folded):
        of = _of_board_code(folded, hit.start(), hit.end())
        code = code_in(hit.group(1), of)
        if code.number is not None or of:
            found.append(code)
    last = _LAST_LETTER.search(clean_text(text))
    if last is not None and not any(code.letters == last.group().casefold() for code in found):
        # 연회장 A, EDV B
        found.append(Code(last.group().casefold(), None, "", frozenset()))
    return tuple(found)


def asked_codes(text: str) -> list[Code]:
    """Return the codes that a question asks for: beside what is numbered, or of a letter and a number.

    Hours, prices and numbers of people are none.
    """
    # “Tres semanas” is a time in words.
    folded = _without_quantities(_digits_in(_without_quantities(_folded(text))))
    # “The A-gates.”
    folded = re.sub(
        r"(?<!\w)[a-z]-(?=[a-z])",
        lambda hit: f"{hit.group()[0]} " if _leads(folded, hit.end()) else hit.group(),
        folded,
    )
    found: list[Code] = []
    alone = len(re.findall(r"\w+", folded)) <= _FEW_WORDS and len(folded) <= _SHORT
    for hit in _CODE.finditer(folded):
        of = _of_code(folded, hit.start(), hit.end())
        code = code_in(hit.group(1), of)
        is_mixed = code.number is not None and bool(code.letters or code.rest)
        if (
            code.number is None
            and (not of or hit.group(1) in ("a", "y", "à", "e", "o", "i"))
            and not _is_capital(text, hit.group(1), of)
            and not (of and _ends_clause(folded, hit.end()))
        ):
            continue
        if of or is_mixed or (alone and code.number is not None) or len(hit.group(1)) >= 3:
            found.append(code)
    return found


def _without_quantities(folded: str) -> str:
    """A text without times, sums and amounts; beside what is numbered 11g is no weight, nor 4h a time."""
    return _QUANTITY.sub(
        lambda hit: (
            hit.group()
            if _LETTERED.fullmatch(hit.group()) and (_follows(folded, hit.start()) or _leads(folded, hit.end()))
            else " "
        ),
        folded,
    )


def all_numbers(text: str) -> list[Code]:
    """Return all numbers that a text says, in digits or words, of whatever."""
    said = with_digits(_folded(text), lambda at: True, lambda at: True)
    return [code_in(number, frozenset()) for number in re.findall(r"(?<!\w)\d{1,4}(?!\w)", said)]


def spoken_numbers(text: str) -> list[Code]:
    """Return the numbers that a question says in words, of whatever: “two oh seven”.

    They have three digits and more, or are all that is said: “el dieciséis”, 二零五.
    """
    folded = _folded(text)
    if _UNSPACED_ALONE.fullmatch(folded.strip()):
        return [code_in(str(number_of(folded)), frozenset())]
    said = _QUANTITY.sub(" ", with_digits(folded, lambda at: True, lambda at: False))
    is_alone = re.fullmatch(r"\d{1,4}", _NUMBER_WORD.sub(" ", f" {said} ").strip()) is not None
    painted = set(re.findall(r"\d+", folded))
    fewest = 1 if is_alone else _FEWEST_SPOKEN
    numbers = re.findall(rf"(?<!\w)\d{{{fewest},4}}(?!\w)", said)
    return [code_in(number, frozenset()) for number in numbers if number not in painted]


def lettered_numbers(text: str) -> list[Code]:
    """Return what may be a letter and a number as they are called, of whatever: “I leave from bee twelve”."""
    lettered = with_letters(_folded(text), lambda *_: True)
    said = with_digits(lettered, lambda at: _LETTER_ALONE.search(lettered[:at]) is not None, lambda at: False)
    return [code_in(hit.group(), frozenset()) for hit in re.finditer(r"(?<!\w)[a-z] \d{1,4}(?!\w)", said)]


def codes_said(text: str) -> list[Code]:
    """Return every number and code in digits, of whatever; times and amounts apart."""
    said = _HOW_MANY.sub(" ", _QUANTITY.sub(" ", _folded(text)))
    every = (code_in(hit.group(1), frozenset()) for hit in _CODE.finditer(said))
    return [code for code in every if code.number is not None]


@lru_cache(maxsize=_KEPT)
def _digits_in(folded: str) -> str:
    folded = with_points(with_letters(folded, _follows))
    folded = digit_ordinal().sub(lambda hit: hit.group(1) if _leads(folded, hit.end()) else hit.group(), folded)
    return with_digits(
        folded,
        lambda at: _follows(folded, at) or _AFTER_POINT.search(folded[:at]) is not None,
        lambda at: _leads(folded, at),
    )


def in_digits(text: str) -> str:
    """Return a question, without case, with the numbers of what is numbered in digits."""
    return _digits_in(_folded(text))


def without_codes(text: str) -> str:
    """Return a question, without case, but for its codes and the words for what they number."""
    folded = _folded(text)
    for hit in reversed(list(_CODE.finditer(folded))):
        if _of_code(folded, hit.start(), hit.end()):
            folded = folded[: hit.start()] + folded[hit.end() :]
    return " ".join(_classes()[0].sub(" ", folded).split())


def _is_capital(text: str, letter: str, of: frozenset[str]) -> bool:
    # “I” is seldom a hall.
    return (
        letter != "i"
        and bool(of)
        and bool(re.search(rf"(?<![^\W_\u2e80-\uffff]){letter.upper()}(?![^\W_\u2e80-\uffff])", text))
    )


def _ends_clause(folded: str, at: int) -> bool:
    """Whether nothing of its script follows: no article stands last, as the letter of “halle a” does, nor in b区."""
    after = folded[at:].lstrip()[:1]
    return not after or after in ",.?!;" or is_unspaced(after)


def _follows(folded: str, at: int) -> bool:
    """Whether what is numbered stands right before a place: “terminal | two”, “gate D | seven”."""
    before = folded[max(0, at - _BEFORE) : at].rstrip()
    if _LETTER_BEFORE.search(before):
        return True
    before = re.sub(r" (?:[a-z]|number|nummer|num[eé]ro|número)$", "", before)
    return any(word.end() == len(before) for word, _ in _last_words(before))


def _leads(folded: str, at: int) -> bool:
    """Whether what is numbered stands right after a place: “second | floor”."""
    return bool(_starting(folded[at:]))


def identities(codes: Iterable[Code]) -> tuple[Identity, ...]:
    """The codes of a question as hard constraints."""
    return tuple(Identity(Sort.CODE, code.value, tuple(sorted(code.of))) for code in codes)


def code_of(identity: Identity) -> Code:
    """The code of a constraint."""
    return code_in(identity.value, frozenset(identity.of))
