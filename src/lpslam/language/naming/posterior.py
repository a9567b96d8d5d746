"""Which whole string is painted, given all that was read of it (text clustering, III-E).

The candidates are the strings that were read, what the reader held for possible beside them, and what is put together
from parts. Each is judged by how likely all readings are if it is painted, and one candidate stands for anything else.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import exp

from rapidfuzz.fuzz import partial_ratio

from lpslam.language.naming.channel import Seen, log_likelihood
from lpslam.language.naming.doubts import log_odds_against

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
