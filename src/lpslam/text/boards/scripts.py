"""A board is written in one script, and so are most boards of a place: that decides between two forms of a character.

Readers prefer the commoner form, time and again alike, so more views of the same line do not mend it.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from math import log

from lpslam.language.model import Slots
from lpslam.language.tables.forms import are_forms, is_simplified_only, is_traditional_only
from lpslam.text.placing.places import Place

_ODDS_A_LETTER, _MOST_ODDS = 2.0, 6.0
"""What each traditional character of a board says, in log odds, for the others' being traditional too; and at most."""

_OWN_ODDS = 0.7
"""Share of the reader's own log odds between two letters that holds, as in names."""


def script_ahead(boards: Sequence[Sequence[Place]]) -> list[float]:
    """For each board how far ahead, in log odds, traditional characters are by what the other boards are written in.

    Of n boards one more is counted for either script, as long as little is known (Laplace's rule of succession).
    """
    scripts = [_script(board) for board in boards]
    counts = [scripts.count(True), scripts.count(False)]
    ahead = []
    for own in scripts:
        traditional, simplified = counts[0] - (own is True), counts[1] - (own is False)
        ahead.append(log((traditional + 1.0) / (simplified + 1.0)))
    return ahead


def _script(board: Sequence[Place]) -> bool | None:
    """Whether a board is in traditional characters; None where nothing tells."""
    painted = "".join(place.name for place in board)
    difference = sum(map(is_traditional_only, painted)) - sum(map(is_simplified_only, painted))
    return None if difference == 0 else difference > 0


def in_one_script(
    board: Sequence[Place], slots_of: Callable[[Place], Iterable[Slots]], around: float = 0.0
) -> list[Place]:
    """Give characters of a traditional board that were read in their simplified form the traditional one.

    Only where the reader held that for possible: signs do mix forms, and what is clearly painted stays.

    Args:
        board: its texts.
        slots_of: the runners-up of a text's letters, reading by reading.
        around: log odds for traditional characters by the boards around.
    """
    painted = "".join(place.name for place in board)
    simplified = sum(map(is_simplified_only, painted))
    ahead = _ODDS_A_LETTER * (sum(map(is_traditional_only, painted)) - simplified + 1) + around
    if not simplified or ahead <= 0.0:
        return list(board)
    return [replace(place, name=_in_traditional(place, slots_of(place), min(ahead, _MOST_ODDS))) for place in board]


def _in_traditional(place: Place, slots: Iterable[Slots], ahead: float) -> str:
    wanted = {ch for ch in place.name if is_simplified_only(ch)}
    if not wanted:
        return place.name
    forms: dict[str, tuple[float, str]] = {}
    for slot in (slot for reading in slots for slot in reading if slot and slot[0][0] in wanted):
        taken, probability = slot[0]
        for other, less in slot[1:]:
            if are_forms(taken, other):
                forms[taken] = min(forms.get(taken, (float("inf"), "")), (log(probability / less), other))
    mended = {taken: other for taken, (odds, other) in forms.items() if _OWN_ODDS * odds < ahead}
    return "".join(mended.get(ch, ch) for ch in place.name)
