"""Which whole string is painted, given all that was read of it (text clustering, III-E).

The candidates are the strings that were read, what the reader held for possible beside them, and what is put together
from parts. Each is judged by how likely all readings are if it is painted, and one candidate stands for anything else.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import exp, expm1, log, log1p

from rapidfuzz.distance import Editop
from rapidfuzz.fuzz import partial_ratio

from lpslam.language.naming.channel import (
    CUT_END,
    KNOWN,
    Seen,
    added_cost,
    ends_of,
    log_likelihood,
    lost_cost,
    replaced_cost,
    slip_of,
    steps_between,
)

# Spellings, the weightiest, whose letters are counted, and the largest sum of costs that is told apart.
_COUNTED, _MOST = 24, 50.0
# Share of a reading's letters that must be the candidate's: else it is of something else and no evidence on letters.
_SAME_TEXT = 0.5
ELSE = ""
"""Key of the candidate that stands for anything else."""
# What anything else is behind before a look.
_ELSE = 3.0
# Spellings, the weightiest, whose letters are doubted one by one, and a runner-up's least share of the letter taken.
_DOUBTED, _RUNNER_UP = 6, 0.05
# Spellings, the weightiest, that are tried as parts of a longer one; and letters of a part.
_PARTS, _SHORTEST_PART = 6, 3
# Two readings, one within the other but for slips (percent alike), are spellings of one text and not its two parts.
_SAME_PART = 75.0
# Largest difference of length between two parts put together and a reading of the whole, as a share of it.
_WHOLE_LENGTH = 0.35
Looks = Callable[[str], str]


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


def posterior(candidates: Mapping[str, float], seen: Sequence[Seen], looks: Looks) -> dict[str, float]:
    """The probability of each candidate, and of anything else.

    Args:
        candidates: keys with the logarithm of their prior odds.
        seen: what was read.
        looks: takes a letter to what it looks like.
    """
    likely = {key: log_likelihood(key, seen, looks) for key in candidates}
    scores = {key: prior + likely[key] for key, prior in candidates.items()}
    best = max(scores, key=lambda key: scores[key])
    scores[ELSE] = likely[best] + log_odds_against(best, seen, looks) - _ELSE
    top = max(scores.values())
    weights = {key: exp(score - top) for key, score in scores.items()}
    total = sum(weights.values())
    return {key: weight / total for key, weight in weights.items()}


def doubted(seen: Sequence[Seen], makes_a_word: Callable[[str, int, str], bool]) -> Iterator[str]:
    """Keys that differ from a reading in one letter, which the reader held for possible.

    Args:
        seen: what was read.
        makes_a_word: whether a letter in a place of a key makes a word: then any runner-up is tried.
    """
    for each in seen[:_DOUBTED]:
        for at, slot in enumerate(each.letters):
            taken = slot.get(each.key[at], 1.0)
            for letter, probability in slot.items():
                if letter == each.key[at] or len(letter) > 1:
                    continue
                if probability >= _RUNNER_UP * taken or makes_a_word(each.key, at, letter):
                    yield each.key[:at] + letter + each.key[at + 1 :]
        for at, slot in (each.gaps or {}).items():
            for letter, probability in slot.items():
                if len(letter) == 1 and probability >= _RUNNER_UP:
                    yield each.key[:at] + letter + each.key[at:]


def put_together(seen: Sequence[Seen]) -> Iterator[tuple[str, str]]:
    """Pairs of readings that may be the two parts of a line which was read as a whole, and worse."""
    parts = [each for each in seen[:_PARTS] if len(each.key) >= _SHORTEST_PART]
    for first in parts:
        for second in parts:
            length = len(first.key) + len(second.key)
            if partial_ratio(first.key, second.key) >= _SAME_PART:
                continue
            if any(_is_worse_whole(each, first, second, length) for each in seen):
                yield first.key, second.key


def _is_worse_whole(whole: Seen, first: Seen, second: Seen, length: int) -> bool:
    is_longer = len(whole.key) > max(len(first.key), len(second.key))
    is_worse = whole.right < min(first.right, second.right)
    return is_longer and is_worse and abs(length - len(whole.key)) <= _WHOLE_LENGTH * length
