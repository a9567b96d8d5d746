"""Opening hours: what boards say of them, and the time that a question asks for, in any language."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from lpslam.language.sanitise import clean_text
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.numerals import number_of, with_digits
from lpslam.language.wishes.sieve import Sieve

_HOUR, _NOON, _DAY = 60, 12 * 60, 24 * 60
_NIGHT_BEGINS = 6  # o'clock: from then on an hour “at night” is before midnight
_QUARTERS = frozenset({0, 15, 30, 45})  # minutes of hours that are written with a point
_DIGIT = re.compile(r"\d")
_HALF_PAST = {"半": 30, "반": 30}


@dataclass(frozen=True, slots=True)
class Hours:
    """Minutes after midnight at which a place opens and closes; the latter after the former."""

    opens: int
    closes: int

    def holds(self, minute: int) -> bool:
        """Whether it is open at a minute of the day."""
        return any(self.opens <= each < self.closes for each in (minute, minute + _DAY))


ALL_DAY = Hours(0, 2 * _DAY)


@lru_cache(maxsize=1)
def _table() -> Mapping[str, Any]:
    tree: Mapping[str, Any] = read_table("hours.json")
    return tree


def _any(name: str) -> str:
    """A pattern of one row of the table; words of spaced scripts stand alone."""
    words = re.split(r"\|(?![^()]*\))", _table()[name])
    spaced = "|".join(word for word in words if not is_unspaced(word.lstrip("(?:")))
    unspaced = "|".join(word for word in words if is_unspaced(word.lstrip("(?:")))
    parts = [rf"(?<!\w)(?:{spaced})(?!\w)" if spaced else "", unspaced]
    return "(?:" + "|".join(each for each in parts if each) + ")"


@dataclass(frozen=True, slots=True)
class _Patterns:
    """Compiled once: what boards say, and what is asked."""

    ranges: re.Pattern[str]
    until: re.Pattern[str]
    since: re.Pattern[str]
    all_day: re.Pattern[str]
    asked: re.Pattern[str]
    noon: re.Pattern[str]
    midnight: re.Pattern[str]
    open: re.Pattern[str]
    numeral: re.Pattern[str]
    led: re.Pattern[str]


def _one(at: str) -> str:
    table = _table()
    return (
        rf"(?P<h{at}>\d{{1,2}})(?:[:.](?P<m{at}>\d{{2}})|h(?P<n{at}>\d{{2}}))? ?(?P<half{at}>{table['half']})?"
        rf"(?: ?(?P<unit{at}>{table['unit']}|(?:{table['hours']})(?![a-z])))?"
        rf"(?: ?(?P<past{at}>\d{{1,2}}(?=[分분])|半|반)[分분]?)?"
    )


@lru_cache(maxsize=1)
def _patterns() -> _Patterns:
    table = _table()
    parts = "|".join(rf"(?P<{each}X>{table[each]})" for each in ("morning", "afternoon", "evening", "night"))
    before, after = parts.replace("X>", "1>"), parts.replace("X>", "2>")
    numerals = "|".join(sorted(table["numerals"], key=len, reverse=True))
    asked = (
        rf"(?:(?<!\w)(?P<lead>{table['after']}|{table['before']}|{table['at']}) ?)?(?:{before})? ?"
        rf"(?<![\d.:-]){_one('')}(?:[^\w]{{0,2}}(?:{after}))? ?"
        rf"(?P<tail>{table['after_after']}|{table['before_after']})?(?:{table['particles']})?(?![\d:])"
    )
    flags = re.IGNORECASE
    return _Patterns(
        re.compile(rf"(?<![\w.]){_one('1')} ?(?:{table['to']}) ?{_one('2')}(?!\d)", flags),
        re.compile(rf"(?:{_any('until')} ?{_one('1')}(?!\d)|(?<!\d){_one('2')} ?(?:{table['until_after']}))", flags),
        re.compile(rf"(?:{_any('from')} ?{_one('1')}(?!\d)|(?<!\d){_one('2')} ?(?:{table['from_after']}))", flags),
        re.compile(rf"(?:{_any('all_day')})", flags),
        re.compile(asked, flags),
        re.compile(rf"(?:{_any('noon')})", flags),
        re.compile(rf"(?:{_any('midnight')})", flags),
        re.compile(rf"(?:{_any('open')})", flags),
        re.compile(rf"({numerals}) ?(?=시(?!간))|([〇零一二三四五六七八九十两兩]+)(?=[点點時时])"),
        re.compile(rf"(?<!\w)(?:{table['at']}|{table['after']}|{table['before']}) ?$", flags),
    )


def _minute(found: re.Match[str], at: str, half: str = "") -> int:
    hour = int(found[f"h{at}"])
    minutes = found[f"m{at}"] or found[f"n{at}"] or _HALF_PAST.get(found[f"past{at}"] or "", found[f"past{at}"]) or 0
    said = (found[f"half{at}"] or half)[:1].lower()
    if said and hour <= 12:
        hour = hour % 12 + (12 if said == "p" else 0)
    return min(hour, 24) * _HOUR + min(int(minutes), 59)


def _says_time(found: re.Match[str], at: str) -> bool:
    return any(found[f"{each}{at}"] for each in ("m", "n", "half", "unit"))


def _is_numbers(found: re.Match[str]) -> bool:
    """Whether a range is one of rooms: “Aula 2.01-2.20”."""
    dotted = [
        found[f"m{at}"] for at in "12" if found[f"m{at}"] and f"{found[f'h{at}']}.{found[f'm{at}']}" in found.group()
    ]
    return any(int(each) not in _QUARTERS for each in dotted)


@lru_cache(maxsize=1 << 14)
def board_hours(text: str) -> tuple[Hours, ...]:
    """Return the hours that a board says: ranges, closing or opening times, round the clock; none if it is silent."""
    found, _ = _read(clean_text(text))
    return found


@lru_cache(maxsize=1 << 14)
def without_hours(text: str) -> str:
    """Return what a board says beside its hours."""
    _, bare = _read(text)
    return bare if any(ch.isalpha() for ch in bare) else text


@lru_cache(maxsize=1)
def _on_boards() -> Sieve:
    patterns = _patterns()
    return Sieve([each.pattern for each in (patterns.all_day, patterns.ranges, patterns.until, patterns.since)])


@lru_cache(maxsize=1)
def _in_questions() -> Sieve:
    patterns = _patterns()
    return Sieve([each.pattern for each in (patterns.all_day, patterns.noon, patterns.midnight, patterns.numeral)])


def _read(text: str) -> tuple[tuple[Hours, ...], str]:
    if not any(ch.isdigit() for ch in text) and "oc" not in text and "uhr" not in text.casefold():
        return (), text
    patterns = _patterns()
    if not _on_boards().possible(text):
        return (), " ".join(text.split())
    if patterns.all_day.search(text):
        return (ALL_DAY,), " ".join(patterns.all_day.sub(" ", text).split())
    hours = []
    spans = []
    for found in patterns.ranges.finditer(text):
        if not _is_numbers(found) and (_says_time(found, "1") or _says_time(found, "2")):
            hours.append(_between(_minute(found, "1", found["half2"] or ""), _minute(found, "2")))
            spans.append(found.span())
    for pattern, is_closing in ((patterns.until, True), (patterns.since, False)) if not hours else ():
        for found in pattern.finditer(text):
            at = "1" if found["h1"] else "2"
            if _says_time(found, at):
                minute = _minute(found, at)
                # What closes at one at night was open the evening before.
                opened = _NIGHT_BEGINS * _HOUR
                hours.append(_between(opened, minute) if is_closing else Hours(minute, max(minute + 1, _DAY)))
                spans.append(found.span())
    bare = text
    for start, end in sorted(spans, reverse=True):
        bare = f"{bare[:start]} {bare[end:]}"
    return tuple(hours), " ".join(bare.split())


def _between(opens: int, closes: int) -> Hours:
    return Hours(opens, closes if closes > opens else closes + _DAY)


@dataclass(frozen=True, slots=True)
class Asked:
    """A time that is asked for: minutes of the day, any of which may be meant (“at eight”), and the other words."""

    minutes: tuple[int, ...]
    rest: str


@lru_cache(maxsize=1 << 10)
def asked_time(question: str) -> Asked | None:
    """Return when a place must be open, where a question says so."""
    patterns = _patterns()
    all_day, noon, midnight, numeral = (at in _in_questions().possible(question) for at in range(4))
    if all_day and patterns.all_day.search(question):
        return Asked((3 * _HOUR,), _without_open(patterns.all_day.sub(" ", question)))
    painted = patterns.numeral.sub(_digits, question) if numeral else question
    folded = painted.casefold()
    spelled = with_digits(folded, lambda at: bool(patterns.led.search(folded[:at])), lambda _: False)
    for text in dict.fromkeys((painted, spelled)):
        # Nearly every question has no digit.
        for found in () if _DIGIT.search(text) is None else patterns.asked.finditer(text):
            if int(found["h"]) <= 24 and _is_time(found):
                return Asked(_meant(found), _without_open(f"{text[: found.start()]} {text[found.end() :]}"))
    for is_possible, pattern, minute in (
        (noon, patterns.noon, _NOON),
        (midnight, patterns.midnight, _DAY + 1),
    ):
        if (is_possible or numeral) and pattern.search(painted):
            return Asked((minute % _DAY,), _without_open(pattern.sub(" ", painted)))
    return None


def _digits(found: re.Match[str]) -> str:
    korean = found.group(1)
    return str(_table()["numerals"][korean] if korean else number_of(found.group(2)))


def _without_open(text: str) -> str:
    return " ".join(_patterns().open.sub(" ", text).split()).strip(" ,.;?!，。？、")


def _parts_of_day(found: re.Match[str]) -> Iterable[str]:
    return (part for part in ("morning", "afternoon", "evening", "night") if found[f"{part}1"] or found[f"{part}2"])


def _is_time(found: re.Match[str]) -> bool:
    """Whether a number is a time: it has a unit, minutes with a colon, or stands after “at” with a part of the day."""
    if found["half"] or re.fullmatch(_table()["unit"], found["unit"] or "", re.IGNORECASE):
        return True
    if any(_parts_of_day(found)):
        return True
    if re.fullmatch(_table()["sharp"], found["lead"] or "", re.IGNORECASE) and not found.string[found.end() :].strip(
        " .,!?"
    ):
        return True
    is_led = found["lead"] is not None or found["tail"] is not None
    return is_led and bool(found["unit"] or found["n"] or (found["m"] and ":" in found.group()))


def _meant(found: re.Match[str]) -> tuple[int, ...]:
    minute = _minute(found, "")
    hour = minute // _HOUR
    part = next(iter(_parts_of_day(found)), "")
    if part in ("evening", "night") and hour == 12:
        # “半夜十二点” is midnight.
        minutes = [(minute + _NOON) % _DAY]
    elif part in ("afternoon", "evening") or (part == "night" and hour >= _NIGHT_BEGINS):
        minutes = [minute + _NOON if hour < 12 else minute]
    elif part or found["half"] or found["unit"] or hour > 12 or not found["lead"]:
        minutes = [minute]
    else:
        minutes = [minute, minute + _NOON]
    lead, tail = found["lead"] or "", found["tail"] or ""
    table = _table()
    later = re.fullmatch(table["after"], lead, re.IGNORECASE) or re.fullmatch(table["after_after"], tail)
    sooner = re.fullmatch(table["before"], lead, re.IGNORECASE) or re.fullmatch(table["before_after"], tail)
    step = 1 if later else -1 if sooner else 0
    return tuple((each + step) % _DAY for each in minutes)


def told_hours(hours: Iterable[Hours]) -> str:
    """Hours as they are told: 9:00 to 17:30."""
    return ", ".join(f"{told_time(each.opens)} to {told_time(each.closes % _DAY)}" for each in hours)


def told_time(minute: int) -> str:
    """A minute of the day as it is told: 21:30."""
    return f"{minute // _HOUR:02d}:{minute % _HOUR:02d}"
