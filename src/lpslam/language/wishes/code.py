"""One code, or a range of them: what a board bears and a question asks for."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

_HUNDREDS = 100  # from which ranges hold what has a point


@dataclass(frozen=True, slots=True)
class Code:
    """Letters, a number (None: letters alone), the rest, what is numbered; and the last code, where it is a range."""

    letters: str
    number: int | None
    rest: str
    of: frozenset[str]
    until: Self | None = None

    @property
    def value(self) -> str:
        """As it is compared: "b31"."""
        return f"{self.letters}{'' if self.number is None else self.number}{self.rest}"

    def bears(self, asked: "Code") -> bool:
        """Whether this code, or range of codes, of a board is or contains the one that is asked for."""
        if self.of and asked.of and self.of.isdisjoint(asked.of):
            return False
        if self.until is not None and self.number is None:
            # “Lockers G–M” hold locker H12.
            is_bare = asked.number is None and not asked.rest
            is_alike = len(asked.letters) == len(self.letters) and (is_bare or bool(self.of & asked.of))
            return is_alike and self.letters <= asked.letters <= self.until.letters
        if self.number is None:
            return asked.letters == self.letters and not asked.rest and bool(self.of or asked.number is None)
        if asked.letters != self.letters:
            return False
        if asked.number is None:
            # “Gates A” are A1 to A15.
            return bool(self.of & asked.of)
        if self.until is None:
            return (asked.number, asked.rest) == (self.number, self.rest)
        if self.until.number is None or self.rest:
            return asked.number == self.number and _between(self.rest, asked.rest, self.until.rest)
        # M1-4 lies in M1 to M8, and 3.05 not in 1 to 6.
        last = int(asked.rest[1:]) if re.fullmatch(r"-\d+", asked.rest) else asked.number
        # A book's 641.5 stands among 400–699.
        is_shelf = self.until.number >= _HUNDREDS and re.fullmatch(r"\.\d+", asked.rest) is not None
        is_one = not asked.rest or asked.rest.isalpha() or last > asked.number or is_shelf
        return is_one and self.number <= asked.number <= last <= self.until.number


def code_in(text: str, of: frozenset[str]) -> Code:
    """Return the code that a text without case is."""
    bare = re.sub(r"(?<=[a-z])[-. ](?=\d)|(?<=\d) (?=[a-z])", "", text)
    found = re.match(r"([a-z]{0,2})(\d{1,4})(.*)$", bare)
    if found is None:
        return Code(bare, None, "", of)
    return Code(found.group(1), int(found.group(2)), found.group(3), of)


def range_of(first: str, last: str, of: frozenset[str]) -> Code | None:
    """Return the range from one code to another, which may leave out what both begin with; None where it is none."""
    one, end = code_in(first, of), code_in(last, of)
    if one.number is not None and end.number is None:
        # 2A–F
        end = replace(one, rest=end.letters)
    if one.number is None or end.number is None:
        is_range = one.number == end.number and one.letters < end.letters and len(one.letters) == len(end.letters)
        return replace(one, until=end) if is_range and of else None
    if end.letters not in (one.letters, ""):
        return None
    if one.rest:
        is_range = one.number == end.number and _between(one.rest, end.rest, end.rest)
    else:
        is_range = one.number <= end.number and not end.rest
    return replace(one, until=end) if is_range else None


def _between(first: str, rest: str, last: str) -> bool:
    """Whether what follows a number lies between what follows two: .05 between .01 and .12, d between a and f."""
    keys = [(each[:1].isalpha(), int(each[1:]) if each[1:].isdigit() else each) for each in (first, rest, last)]
    kinds = {(is_letter, type(key)) for is_letter, key in keys}
    return len(kinds) == 1 and keys[0] <= keys[1] <= keys[2]


def packed(code: Code) -> tuple[Any, ...]:
    """Return a code in plain values."""
    until = None if code.until is None else packed(code.until)
    return code.letters, code.number, code.rest, tuple(sorted(code.of)), until


def unpacked(values: Sequence[Any]) -> Code:
    """Return the code of plain values."""
    letters, number, rest, of, until = values
    return Code(letters, number, rest, frozenset(of), None if until is None else unpacked(until))
