"""Opening hours on boards, and the time that a question asks for, in any language (`data/hours.json`)."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any

from lpslam.language.sanitise import clean_text
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.numerals import number_of, with_digits

_HOUR, _NOON, _DAY = 60, 12 * 60, 24 * 60
_NIGHT_BEGINS = 6  # o'clock: from then on an hour “at night” is before midnight
_OPENS = 6 * _HOUR  # of what says only when it closes
_QUARTERS = frozenset({"00", "15", "30", "45"})  # minutes of hours that are written with a point: “Aula 2.01” is none
_PARTS = ("morning", "afternoon", "evening", "night")
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


@lru_cache(maxsize=1)
def _rows() -> Mapping[str, str]:
    """What boards say and what is asked, put together of the rows of the table."""
    table = _table()

    def alone(name: str) -> str:
        # Words of spaced scripts stand alone.
        words = re.split(r"\|(?![^()]*\))", table[name])
        return "|".join(word if is_unspaced(word.lstrip("(?:")) else rf"(?<!\w)(?:{word})(?!\w)" for word in words)

    def time(at: str) -> str:
        return (
            rf"(?P<h{at}>\d{{1,2}})(?:[:.](?P<m{at}>\d{{2}})|h(?P<n{at}>\d{{2}}))? ?(?P<half{at}>{table['half']})?"
            rf"(?: ?(?P<unit{at}>{table['unit']}|(?:{table['hours']})(?![a-z])))?"
            rf"(?: ?(?P<past{at}>\d{{1,2}}(?=[分분])|半|반)[分분]?)?"
        )

    before, after = ("|".join(rf"(?P<{each}{at}>{table[each]})" for each in _PARTS) for at in "12")
    numerals = "|".join(sorted(table["numerals"], key=len, reverse=True))
    lead = rf"(?<!\w)(?:{table['after']}|{table['before']}|{table['at']})"
    rows = {
        **{name: alone(name) for name in ("all_day", "noon", "midnight")},
        "range": rf"(?<![\w.]){time('1')} ?(?:{table['to']}) ?{time('2')}(?!\d)",
        "until": rf"(?:{alone('until')}) ?{time('1')}(?!\d)|(?<!\d){time('2')} ?(?:{table['until_after']})",
        # 快一点 is “a bit faster”.
        "numeral": rf"({numerals}) ?(?=시(?!간))"
        r"|(?!(?<![午晨上里夜到在])一[点點](?![钟鐘半整]))([〇零一二三四五六七八九十两兩]+)(?=[点點時时])",
        "led": rf"{lead} ?$",
        "asked": rf"(?:(?P<lead>{lead}) ?)?(?:{before})? ?(?<![\d.:-]){time('')}(?:[^\w]{{0,2}}(?:{after}))? ?"
        rf"(?P<tail>{table['after_after']}|{table['before_after']})?(?:{table['particles']})?(?![\d:])",
        "unit": table["unit"],
        "sharp": table["sharp"],
        "later": rf"{table['after']}|{table['after_after']}",
        "sooner": rf"{table['before']}|{table['before_after']}",
    }
    return rows


@cache
def _pattern(name: str) -> re.Pattern[str]:
    """A pattern, made ready when it is first looked for."""
    return standing(_rows()[name], re.IGNORECASE)


def _minute(found: re.Match[str], at: str, half: str = "") -> int:
    hour = int(found[f"h{at}"])
    minutes = found[f"m{at}"] or found[f"n{at}"] or _HALF_PAST.get(found[f"past{at}"] or "", found[f"past{at}"]) or 0
    said = (found[f"half{at}"] or half)[:1].lower()
    if said and hour <= 12:
        hour = hour % 12 + (12 if said == "p" else 0)
    return min(hour, 24) * _HOUR + min(int(minutes), 59)


def _is_code(found: re.Match[str], at: str) -> bool:
    """Whether a number with a point is no time: its minutes are no quarter."""
    is_dotted = found[f"m{at}"] and f"{found[f'h{at}']}.{found[f'm{at}']}" in found.group()
    return bool(is_dotted) and found[f"m{at}"] not in _QUARTERS


def _says_time(found: re.Match[str], at: str) -> bool:
    return any(found[f"{each}{at}"] for each in ("m", "n", "half", "unit"))


@lru_cache(maxsize=1 << 14)
def board_hours(text: str) -> tuple[Hours, ...]:
    """Return the hours that a board says: ranges, closing times, round the clock; none if it is silent."""
    return _read(clean_text(text))[0]


@lru_cache(maxsize=1 << 14)
def without_hours(text: str) -> str:
    """Return what a board says beside its hours."""
    _, bare = _read(text)
    return bare if any(ch.isalpha() for ch in bare) else text


def _read(text: str) -> tuple[tuple[Hours, ...], str]:
    if not any(ch.isdigit() for ch in text) and "oc" not in text and "uhr" not in text.casefold():
        return (), text
    hours: list[Hours] = []
    bare = text
    if _pattern("all_day").search(text):
        return (ALL_DAY,), " ".join(_pattern("all_day").sub(" ", text).split())
    for found in _pattern("range").finditer(text):
        # “Rooms 2.01–2.15” are rooms.
        is_range_of_codes = _is_code(found, "1") or _is_code(found, "2")
        if not is_range_of_codes and (_says_time(found, "1") or _says_time(found, "2")):
            hours.append(_between(_minute(found, "1", found["half2"] or ""), _minute(found, "2")))
            bare = bare.replace(found.group(), " ")
    for found in _pattern("until").finditer(text) if not hours else ():
        at = "1" if found["h1"] else "2"
        if _says_time(found, at) and not _is_code(found, at):
            hours.append(_between(_OPENS, _minute(found, at)))
            bare = bare.replace(found.group(), " ")
    return tuple(hours), " ".join(bare.split())


def _between(opens: int, closes: int) -> Hours:
    # What closes at one at night was open the evening before.
    return Hours(opens, closes if closes > opens else closes + _DAY)


@dataclass(frozen=True, slots=True)
class Asked:
    """A time that is asked for: minutes of the day, any of which may be meant (“at eight”), and the other words."""

    minutes: tuple[int, ...]
    rest: str


@lru_cache(maxsize=1 << 10)
def asked_time(question: str) -> Asked | None:
    """Return when a place must be open, where a question says so."""
    painted = _pattern("numeral").sub(_digits, question)
    folded = painted.casefold()
    spelled = with_digits(folded, lambda at: _pattern("led").search(folded[:at]) is not None, lambda _: False)
    if _pattern("all_day").search(question):
        return Asked((3 * _HOUR,), _pattern("all_day").sub(" ", question))
    for text in dict.fromkeys((painted, spelled)):
        for found in _pattern("asked").finditer(text) if any(ch.isdigit() for ch in text) else ():
            if int(found["h"]) <= 24 and _is_time(found):
                before, after = text[: found.start()], text[found.end() :]
                # The other words with their capitals, which names have.
                before = painted[: len(before)] if folded.startswith(before) else before
                after = painted[len(painted) - len(after) :] if folded.endswith(after) else after
                return Asked(_meant(found), f"{before} {after}")
    for name, minute in (("noon", _NOON), ("midnight", 1)):
        if _pattern(name).search(painted):
            return Asked((minute,), _pattern(name).sub(" ", painted))
    return None


def _digits(found: re.Match[str]) -> str:
    korean = found.group(1)
    return str(_table()["numerals"][korean] if korean else number_of(found.group(2)))


def _part_of_day(found: re.Match[str]) -> str:
    return next((part for part in _PARTS if found[f"{part}1"] or found[f"{part}2"]), "")


def _is_time(found: re.Match[str]) -> bool:
    """Whether a number is a time: it has a unit, minutes with a colon, or stands after “at” with a part of the day."""
    is_last = not found.string[found.end() :].strip(" .,!?")
    if found["half"] or _pattern("unit").fullmatch(found["unit"] or "") or _part_of_day(found):
        return True
    if is_last and _pattern("sharp").fullmatch(found["lead"] or ""):
        return True
    is_led = found["lead"] is not None or found["tail"] is not None
    return is_led and bool(found["unit"] or found["n"] or (found["m"] and ":" in found.group()))


def _meant(found: re.Match[str]) -> tuple[int, ...]:
    minute, part = _minute(found, ""), _part_of_day(found)
    hour = minute // _HOUR
    minutes = [minute]
    if part in ("evening", "night") and hour == 12:
        # “半夜十二点” is midnight.
        minutes = [(minute + _NOON) % _DAY]
    elif part in ("afternoon", "evening") or (part == "night" and hour >= _NIGHT_BEGINS):
        minutes = [minute + _NOON if hour < 12 else minute]
    elif not (part or found["half"] or found["unit"]) and hour <= 12 and found["lead"]:
        minutes = [minute, minute + _NOON]
    said = [found["lead"] or "", found["tail"] or ""]
    step = sum(bool(_pattern("later").fullmatch(each)) - bool(_pattern("sooner").fullmatch(each)) for each in said)
    return tuple((each + step) % _DAY for each in minutes)


def told_hours(hours: Iterable[Hours]) -> str:
    """Hours as they are told: 09:00 to 17:30."""
    return ", ".join(f"{_told(each.opens)} to {_told(each.closes % _DAY)}" for each in hours)


def _told(minute: int) -> str:
    return f"{minute // _HOUR:02d}:{minute % _HOUR:02d}"
