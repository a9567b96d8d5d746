"""What speaks for a string that nobody thought of, letter by letter (text clustering, III-E).

What is painted is one string. Were it not the best candidate, it would differ from that in some letter; then every
reading that shows the candidate's letter there is wrong at that letter. Readings that are wrong elsewhere, however many
and however poor, say nothing of it: they are as wrong of the one string as of the other.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import exp, expm1, log, log1p

from rapidfuzz.distance import Editop

from lpslam.language.naming.channel import (
    CUT_END,
    KNOWN,
    Seen,
    added_cost,
    ends_of,
    lost_cost,
    replaced_cost,
    slip_of,
    steps_between,
)

# Spellings, the weightiest, whose letters are counted, and the largest sum of costs that is told apart.
_COUNTED, _MOST = 24, 50.0
# Share of a reading's letters that must be the candidate's: else it is of something else and no evidence on letters.
_SAME_TEXT = 0.5


@dataclass(slots=True)
class _Pull:
    """What readings say for one letter: the first look in full, later ones as slips that are known by then."""

    spent: float = 0.0
    total: float = 0.0

    def add(self, weight: float, cost: float) -> None:
        """Add a reading of so many looks that would have slipped at such a cost."""
        full = min(weight, max(1.0 - self.spent, 0.0))
        self.spent += weight
        self.total = min(self.total + full * cost + (weight - full) * min(cost, KNOWN), _MOST)


@dataclass(slots=True)
class _Column:
    """What was read in one place: the candidate's own letter (or, between letters, nothing), and others."""

    own: _Pull = field(default_factory=_Pull)
    others: dict[str, _Pull] = field(default_factory=lambda: defaultdict(_Pull))

    def odds(self, unread: float) -> float:
        """Odds against the candidate in this place; `unread` stands for all letters that nobody read."""
        return exp(-self.own.total) * (unread + sum(exp(each.total) for each in self.others.values()))


def log_odds_against(painted: str, seen: Sequence[Seen], looks: Callable[[str], str]) -> float:
    """Logarithm of the odds that another string than `painted`, near to it, is what all readings are of.

    A single reading has by this the odds of its own probability to be right. Agreement raises it letter by letter.
    """
    letters = [_Column() for _ in painted]
    gaps = [_Column() for _ in range(len(painted) + 1)]
    for each in seen[:_COUNTED]:
        _count(painted, each, looks, letters, gaps)
    doubt = sum(log1p(each.odds(1.0)) for each in letters) + sum(log1p(each.odds(0.0)) for each in gaps)
    return log(max(expm1(min(doubt, _MOST)), exp(-_MOST)))


def _count(painted: str, seen: Seen, looks: Callable[[str], str], letters: list[_Column], gaps: list[_Column]) -> None:
    """Count a reading in every place of which it says something: hidden ends say nothing."""
    steps, last = steps_between(painted, seen.key), len(painted)
    changed = {step.src_pos for step in steps if step.tag != "insert"}
    if last - len(changed) < _SAME_TEXT * len(seen.key):
        return
    lost = {step.src_pos for step in steps if step.tag == "delete"}
    hidden = set[int]().union(*ends_of(lost, last))
    filled = {step.src_pos for step in steps if step.tag == "insert"}
    same = _same_letters(steps, last)
    for at, own in same.items():
        letters[at].own.add(seen.weight, slip_of(seen, own))
    for at in set(range(last + 1)) - filled:
        if not {at - 1, at} & lost:
            slip = slip_of(seen, before=same.get(at))
            gaps[at].own.add(seen.weight, slip if 0 < at < last else min(slip, CUT_END))
    for step in steps:
        if step.tag == "replace":
            cost = replaced_cost(painted[step.src_pos], seen, step.dest_pos, looks)
            letters[step.src_pos].others[seen.key[step.dest_pos]].add(seen.weight, cost)
        elif step.tag == "insert":
            cost = added_cost(painted, seen, step.dest_pos)
            gaps[step.src_pos].others[seen.key[step.dest_pos]].add(seen.weight, cost)
        elif step.src_pos not in hidden:
            cost = lost_cost(painted[step.src_pos], seen, step.dest_pos)
            letters[step.src_pos].others[""].add(seen.weight, cost)


def _same_letters(steps: Sequence[Editop], length: int) -> dict[int, int]:
    """Where the letters of a key, so long, that no step changes stand in what was read."""
    changed = {step.src_pos for step in steps if step.tag != "insert"}
    same, shift = {}, 0
    for at in range(length):
        shift += sum(step.tag == "insert" and step.src_pos == at for step in steps)
        if at not in changed:
            same[at] = at + shift
        shift -= sum(step.tag == "delete" and step.src_pos == at for step in steps)
    return same
