"""The lines of a board: pieces of one line side by side are joined, and each line gets its role."""

from collections.abc import Sequence
from dataclasses import replace
from math import exp, log

import numpy as np
from numpy.typing import NDArray

from lpslam.text.boards.kinship import out_of_line
from lpslam.text.boards.roles import LineShape, is_bare_price, role_by_form, roles_of
from lpslam.text.placing.places import Place
from lpslam.text.remembering.similarity import IDEOGRAPHS
from lpslam.text.types import LandmarkLine

Array = NDArray[np.float64]

# How far pieces of one line may differ: ratio of their letter heights; letter heights out of row, and between them.
# Between words a space may be wide. Characters that are written without spaces are read in one piece: what stands
# beside them is another line, unless it looks just the same and all but touches them.
_WORDS, _UNSPACED = (1.35, 0.3, 0.9), (1.15, 0.12, 0.45)
# What stands in a column is of the size of what is above or below it, so many letter heights away at most, and has an
# edge or the middle in common with it to this share of a letter; what is beside it differs by more than the factor.
_COLUMN_SIZE, _COLUMN_STEP, _COLUMN_SHIFT = 1.15, 2.0, 0.3
# Cosine between the directions of texts that run the same way: two words of an arc lean by half of the angle each.
_LEANS = 0.8
# Width of a box over its height from which its line runs across: one that runs down has nothing beside it.
_ACROSS = 0.8
AT_EVEN, GROWTH = 0.37, 0.66
"""Log odds that a line is right: at even odds, and what they grow by with those that its readings tell.

One cause may spoil them all, so they tell less than they say; what is left of a text that is doubted is right more
often than not. Fitted to labelled walks (`benchmarks/text_certainty.py`).
"""

# Log odds that are believed.
_SUREST = 20.0


def lines_of(board: Sequence[Place]) -> tuple[LandmarkLine, list[LandmarkLine]]:
    """The line that a board is called by, and all its lines in the order of reading, top to bottom."""
    reference = _levelled(max(board, key=lambda each: (each.width * each.height, -each.id)), board)
    rows = _in_reading_order(board, reference)
    joined = [pieces for row in rows for pieces in _pieces(row, board, reference)]
    shapes = [_shape(pieces, reference) for pieces in joined]
    main, roles = roles_of(shapes)
    lines = [
        LandmarkLine(
            text=shape.text,
            role=role.value,
            confidence=as_measured(shape.sure),
            position=reference.position
            + reference.baseline * (shape.left + shape.right) / 2.0
            + reference.down * (shape.top + shape.bottom) / 2.0
            + reference.normal * float(np.mean([_out(each, reference) for each in pieces])),
            width=shape.right - shape.left,
            height=shape.bottom - shape.top,
            observations=max(each.observations for each in pieces),
        )
        for pieces, shape, role in zip(joined, shapes, roles, strict=True)
    ]
    return lines[main], lines


def as_measured(sure: float) -> float:
    """How often a line is right, 0 to 1, of which its readings tell that it is so surely: fitted to labelled walks."""
    odds = log(max(sure, exp(-_SUREST)) / max(1.0 - sure, exp(-_SUREST)))
    return 1.0 / (1.0 + exp(-AT_EVEN - GROWTH * odds))


def _levelled(reference: Place, board: Sequence[Place]) -> Place:
    """The reference with the direction that its board's lines have in the mean: on an arc each leans its own way."""
    alike = [each for each in board if float(each.baseline @ reference.baseline) >= _LEANS]
    mean = np.sum([each.width * each.baseline for each in alike], axis=0)
    mean = mean - reference.normal * float(mean @ reference.normal)
    return replace(reference, baseline=mean / np.linalg.norm(mean))


def _in_reading_order(board: Sequence[Place], reference: Place) -> list[list[Place]]:
    """Rows from top to bottom, each left to right."""
    across = {each.id: float((each.position - reference.position) @ reference.baseline) for each in board}
    down = {each.id: float((each.position - reference.position) @ reference.down) for each in board}
    rows: list[list[Place]] = []
    for place in sorted(board, key=lambda each: down[each.id]):
        # Still the same row while its middle lies within the height of the row's first text.
        if rows and down[place.id] - down[rows[-1][0].id] < 0.5 * rows[-1][0].height:
            rows[-1].append(place)
        else:
            rows.append([place])
    return [sorted(row, key=lambda each: across[each.id]) for row in rows]


def _pieces(row: Sequence[Place], board: Sequence[Place], reference: Place) -> list[list[Place]]:
    """Split a row into its lines: those of a menu stand side by side too, and beside a name."""
    lines: list[list[Place]] = []
    for place in row:
        last = lines[-1][-1] if lines else place
        is_entry = _is_entry(place, last, board, reference) or _is_entry(last, place, board, reference)
        is_price = bool(lines) and _is_price_of(last, place)
        if lines and (is_price or (not is_entry and _go_on(last, place, reference))):
            lines[-1].append(place)
        else:
            lines.append([place])
    return lines


def _runs_down(place: Place) -> bool:
    return place.width <= _ACROSS * place.height


def _is_price_of(goods: Place, price: Place) -> bool:
    """Whether a text is the price, in a box of its own, of the goods that stand before it in its row."""
    return _ratio(goods, price) <= _WORDS[0] and is_bare_price(price.name) and role_by_form(goods.name) is None


def _is_entry(place: Place, beside: Place, board: Sequence[Place], reference: Place) -> bool:
    """Whether a text is one of a column of its size, and what stands beside it is not."""
    return _ratio(place, beside) > _COLUMN_SIZE and any(
        0.5 * place.letter < abs(float(offset @ reference.down)) <= _COLUMN_STEP * place.letter
        and out_of_line(float(offset @ reference.baseline), place.width, other.width) <= _COLUMN_SHIFT * place.letter
        and _ratio(place, other) <= _COLUMN_SIZE
        for other, offset in ((each, each.position - place.position) for each in board)
    )


def _ratio(first: Place, second: Place) -> float:
    return max(first.letter, second.letter) / max(min(first.letter, second.letter), 1e-6)


def _go_on(first: Place, second: Place, reference: Place) -> bool:
    """Whether a piece goes on with the one before it: as all lines run, or, on an arc, as these two do in the mean."""
    is_unspaced = max(first.name[-1:], second.name[:1]) >= IDEOGRAPHS
    ratio, shift, space = _UNSPACED if is_unspaced else _WORDS
    letter = max(first.letter, second.letter)
    offset = second.position - first.position
    gap = float(offset @ reference.baseline) - (first.width + second.width) / 2.0
    leaning = first.down + second.down
    shifted = min(abs(float(offset @ down)) for down in (reference.down, leaning / np.linalg.norm(leaning)))
    is_across = not _runs_down(first) and not _runs_down(second)
    return (
        is_across
        and _ratio(first, second) <= ratio
        and float(first.baseline @ second.baseline) >= _LEANS
        and shifted <= shift * letter
        # What lies over one another is not side by side: places of texts without depth are not told finely.
        and -letter <= gap <= space * letter
    )


def _shape(pieces: Sequence[Place], reference: Place) -> LineShape:
    across = [float((each.position - reference.position) @ reference.baseline) for each in pieces]
    down = [float((each.position - reference.position) @ reference.down) for each in pieces]
    return LineShape(
        text=" ".join(each.name for each in pieces),
        letter=float(np.mean([each.letter for each in pieces])),
        left=min(x - each.width / 2.0 for x, each in zip(across, pieces, strict=True)),
        top=min(y - each.height / 2.0 for y, each in zip(down, pieces, strict=True)),
        right=max(x + each.width / 2.0 for x, each in zip(across, pieces, strict=True)),
        bottom=max(y + each.height / 2.0 for y, each in zip(down, pieces, strict=True)),
        sure=float(np.prod([each.confidence for each in pieces])),
    )


def _out(place: Place, reference: Place) -> float:
    return float((place.position - reference.position) @ reference.normal)
