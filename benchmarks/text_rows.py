"""What stands in one row of a board is compared as a row: it may be read as one line, or as its columns.

Two lines are of one row if their middles are at one height, to half a letter, and their letters are about as high. A
menu's goods and prices are such a row, whether the label, or the map, has them as one line or as two. Which is which
is told by where the lines stand, not by what they say. Typographic forms of a mark are one mark, and pictures
(telephones, stars) are no letters.
"""

import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lpslam.text.remembering.similarity import comparison_key, similarity

ROW_SHIFT, ROW_HEIGHT = 0.5, 1.5  # letters between the middles of a row, and the ratio of its letters' heights, at most
LONGEST = 6  # lines of a row that are one
MARKS = str.maketrans("‘’‛′“”„″‐‑‒–—−", "''''" + '"' * 4 + "-" * 6)


@dataclass(frozen=True)
class RowLine:
    """A line of a board.

    Attributes:
        text: what it says.
        place: (3,) metres: along the row, upwards, and out of the board.
        letter: metres, height of its letters; 0 where it is not known: then it is a row of its own.
    """

    text: str
    place: NDArray[np.float64]
    letter: float


def key_of(text: str) -> str:
    """What of a text is compared: no case, spaces or pictures; marks in one form."""
    plain = unicodedata.normalize("NFKC", text).translate(MARKS)
    return comparison_key("".join(ch for ch in plain if unicodedata.category(ch) not in ("So", "Cf", "Mn")))


def likenesses(own: Sequence[RowLine], others: Sequence[RowLine], near: float) -> list[float]:
    """How like each line, or a row that it is in, is to a line or a row of another board, at most `near` metres off."""
    wanted = [(key_of(" ".join(each.text for each in run)), run) for run in runs(others)]
    best = [0.0] * len(own)
    for run in runs(own):
        key = key_of(" ".join(each.text for each in run))
        said = max((similarity(key, other) for other, its in wanted if other and _apart(run, its) <= near), default=0.0)
        for row, each in enumerate(own):
            if any(each is one for one in run):
                best[row] = max(best[row], said)
    return best


def runs(lines: Sequence[RowLine]) -> Iterator[tuple[RowLine, ...]]:
    """Every line, and every few neighbours of a row from left to right."""
    for row in _rows(lines):
        for first in range(len(row)):
            for last in range(first + 1, min(len(row), first + LONGEST) + 1):
                yield tuple(row[first:last])


def _rows(lines: Sequence[RowLine]) -> list[list[RowLine]]:
    rows: list[list[RowLine]] = []
    for each in sorted(lines, key=lambda line: -float(line.place[1])):
        own = next((row for row in rows if all(_are_level(each, other) for other in row)), None)
        if own is None:
            rows.append([each])
        else:
            own.append(each)
    return [sorted(row, key=lambda line: float(line.place[0])) for row in rows]


def _are_level(first: RowLine, second: RowLine) -> bool:
    low, high = sorted((first.letter, second.letter))
    apart = abs(float(first.place[1] - second.place[1]))
    return low > 0.0 and high <= ROW_HEIGHT * low and apart <= ROW_SHIFT * low


def _apart(first: Sequence[RowLine], second: Sequence[RowLine]) -> float:
    """Metres from the nearest line of one run to the nearest of the other."""
    return min(float(np.linalg.norm(a.place - b.place)) for a in first for b in second)
