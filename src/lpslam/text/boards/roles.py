"""What a line of a board is for, by its size among the others and by its form: no word of any trade is known here."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum


class Role(StrEnum):
    """What a line is for."""

    PRIMARY = "primary"
    SECONDARY = "secondary"
    CONTACT = "contact"
    LIST = "list"


@dataclass(frozen=True, slots=True)
class LineShape:
    """A line as it stands on its board.

    Attributes:
        text: what it says.
        letter: metres, height of its letters.
        left, top, right, bottom: metres, on the board's face; to the right and down.
        sure: 0 to 1, how surely the text is right.
    """

    text: str
    letter: float
    left: float
    top: float
    right: float
    bottom: float
    sure: float = 1.0

    @property
    def prominence(self) -> float:
        """How much it stands out: its letters' height, in metres, a little its length, and how surely it was read."""
        length = max(self.right - self.left, self.bottom - self.top) / max(self.letter, 1e-6)
        return float(
            self.letter * min(max(length, 1.0), _LONG) ** _LENGTH_POWER * max(self.sure, _UNSURE) ** _SURE_POWER
        )


# Longer than so many letter heights a line stands out no more; how little its length counts beside its height, and
# how much its sureness, down to one: what is hardly read is an ornament as often as a name.
_LONG, _LENGTH_POWER, _SURE_POWER, _UNSURE = 6.0, 0.25, 0.5, 0.2
# Entries of a list differ in letter height by this factor at most ...
_LIKE = 1.25
# ... and begin, end or have their middles in line within so many letter heights, ...
_IN_LINE = 0.6
# ... with no more than so many between two; of entries without prices there are so many at least.
_LIST_GAP, _FEWEST = 2.5, 3
# A menu is called by its first entry that is this sure, as a share of the surest one's.
_SURE_SHARE = 0.7
# Fewest digits of a telephone number.
_FEWEST_DIGITS = 6

_CLOCK = r"\d{1,2}\s*[:：.h]\s*\d{2}"
_HOURS = re.compile(
    rf"{_CLOCK}.{{0,8}}{_CLOCK}|\d\s*[ap]\.?m\b|\b24\s*(h\b|hours?\b|小[时時]|時間|시간)", re.IGNORECASE
)
_NETWORK = re.compile(r"https?:|www\.|\w@\w|\b[a-z0-9-]{2,}\.[a-z]{2,4}(\b|/)(?!\s*\d)", re.IGNORECASE)
_CURRENCY = r"(?:元|円|圆|圓|원|[€$£¥₩₫฿₹₽]|\b(?:eur|usd|kr|zł|ft|lei|rm|rp)\b)"
_PRICE = re.compile(rf"\d\s*{_CURRENCY}|{_CURRENCY}\s*\d|\s\d{{1,3}}[.,]\d{{2}}$", re.IGNORECASE)
_BARE_PRICE = re.compile(rf"\W*{_CURRENCY}?\s*\d+(?:[.,:]\d+)?\s*{_CURRENCY}?(?:\s*/?\s*\w)?\W*", re.IGNORECASE)
_NUMBERED = re.compile(r"\d\s*(號|号|番地|丁目|巷|弄|번지)|(路|街|道|巷|로|길)\s*\d")
# Units of two letters and more: with one letter numbers are parts of names as often (3M, Gate 2 A).
_MEASURE = re.compile(
    r"\d\s*(?:%|°\s*[cf]\b|(?:rpm|kg|lbs?|tons?|km/?h|mph|k?va|kw|hp|k?hz|k?pa|mpa|bar|psi|mm|cm|ft|km|ml|min|sec)\b)"
    r"|\d\s*(?:公斤|公尺|公里|千瓦|伏特|馬力|马力)",
    re.IGNORECASE,
)
_STREET = re.compile(
    r"(?:stra(?:ß|ss)e|str\.|gasse|weg|platz|allee|straat|gatan|vej|gade|utca)\b|\b(?:road|rd|street|st|lane|ln|avenue|"
    r"ave|boulevard|blvd|drive|row|walk|square|way|court|rue|quai|place|via|viale|piazza|corso|calle|avenida|plaza|rua|"
    r"carrer|ulica|ul|caddesi|cad|sokak|jalan|jl|soi)\b",
    re.IGNORECASE,
)


def role_by_form(text: str) -> Role | None:
    """What the form of a line says: ways to reach someone, or a price; None where it says nothing."""
    digits = sum(ch.isdigit() for ch in text)
    if _HOURS.search(text) or _NETWORK.search(text):
        return Role.CONTACT
    if _PRICE.search(text):
        return Role.LIST
    if digits >= _FEWEST_DIGITS or _NUMBERED.search(text) or (digits and _STREET.search(text)):
        return Role.CONTACT
    return None


def is_bare_price(text: str) -> bool:
    """Whether a text is a price and does not say of what."""
    return role_by_form(f"x {text}") is Role.LIST and _BARE_PRICE.fullmatch(text) is not None


def roles_of(lines: Sequence[LineShape]) -> tuple[int, list[Role]]:
    """Which line a board is called by, and every line's role; a menu is called by its first entry."""
    forms = [role_by_form(line.text) for line in lines]
    worded = [row for row, line in enumerate(lines) if any(ch.isalpha() for ch in line.text)]
    formless = [row for row in worded if forms[row] is None]
    # A measure says how much of something there is: what that is called stands beside it.
    named = [row for row in formless if not _MEASURE.search(lines[row].text)] or formless or worded
    named = named or list(range(len(lines)))
    main = max(named, key=lambda row: (lines[row].prominence, -row))
    roles = [form or Role.SECONDARY for form in forms]
    if forms[main] is None:
        roles[main] = Role.PRIMARY
    entries = [row for row in range(len(lines)) if forms[row] is not Role.CONTACT]
    for group in _lists(lines, entries):
        if len(group) < _FEWEST and not all(forms[row] is Role.LIST for row in group):
            continue
        for row in group:
            roles[row] = Role.LIST
        if main in group:
            surest = max(lines[row].sure for row in group)
            readable = [row for row in group if lines[row].sure >= _SURE_SHARE * surest]
            main = min(readable, key=lambda row: (lines[row].top, lines[row].left))
    return main, roles


def _lists(lines: Sequence[LineShape], rows: Sequence[int]) -> list[list[int]]:
    """Lines of like size that follow one another in a column or in a row."""
    groups: list[list[int]] = []
    for row in rows:
        joined: list[list[int]] = []
        for group in groups:
            letters = [lines[each].letter for each in (row, *group, *(each for other in joined for each in other))]
            is_alike = max(letters) <= _LIKE * min(letters)
            if is_alike and any(_follow(lines[row], lines[other]) for other in group):
                joined.append(group)
        groups = [group for group in groups if group not in joined]
        groups.append([*(each for group in joined for each in group), row])
    return groups


def _follow(first: LineShape, second: LineShape) -> bool:
    letter = max(first.letter, second.letter)
    beside = max(first.left, second.left) - min(first.right, second.right)
    below = max(first.top, second.top) - min(first.bottom, second.bottom)
    if max(beside, below) > _LIST_GAP * letter:
        return False
    if below >= beside:
        offsets = (first.left - second.left, first.right - second.right)
    else:
        offsets = (first.top - second.top, first.bottom - second.bottom)
    return min(*map(abs, offsets), abs(sum(offsets)) / 2.0) <= _IN_LINE * letter
