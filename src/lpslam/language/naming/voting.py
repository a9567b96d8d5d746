"""Naming a class of misread strings by a vote, letter by letter (text clustering, III-E)."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from rapidfuzz.distance import Levenshtein

from lpslam.language.model import Reading
from lpslam.language.sanitise import clean_text

# Readers lose spaces far more often than they see one that is not there: so few readings are enough for it.
_SPACE_SHARE, _MOST = 0.2, 0.5
# More so points, commas and colons within numbers: of 318 readings of such 40 had lost it, all of four texts in chalk;
# of 728 readings of 98 numbers without, none had one.
_POINTS, _POINT_SHARE = frozenset(".,:："), 0.1


@dataclass(frozen=True, slots=True)
class Vote:
    """The spelling that the readings agree on, and the mean share of their weight behind its letters."""

    text: str
    agreement: float
    readings: tuple[tuple[str, float], ...]


def vote(readings: Sequence[Reading]) -> Vote:
    """Align every reading to the most central one and let each column choose its letter.

    A reading weighs count times confidence. Case and punctuation stay as most readings have them.
    """
    weights: dict[str, float] = defaultdict(float)
    for reading in readings:
        text = clean_text(reading.text)
        if text:
            weights[text] += max(reading.count, 0) * min(max(reading.confidence, 0.0), 1.0)
    total = sum(weights.values())
    if not weights:
        return Vote("", 0.0, ())
    if total <= 0.0:
        weights = dict.fromkeys(weights, 1.0)
        total = float(len(weights))
    ranked = sorted(weights.items(), key=lambda item: (-item[1], item[0]))
    nearness = Levenshtein.normalized_similarity
    pivot = max(ranked, key=lambda item: sum(weight * nearness(item[0], other) for other, weight in ranked))[0]
    columns, gaps = _columns(pivot, ranked)
    letters: list[str] = []
    shares: list[float] = []
    for at in range(len(pivot) + 1):
        inserted = max(gaps[at].items(), key=lambda item: item[1], default=("", 0.0))
        if inserted[1] > total * _share_needed(inserted[0], pivot[max(at - 1, 0) : at + 1]):
            letters.append(inserted[0])
            shares.append(inserted[1] / total)
        if at < len(pivot):
            # On a tie the pivot's own letter stays.
            letter = max(columns[at].items(), key=lambda item: (item[1], item[0] == pivot[at]))
            needed = _share_needed(pivot[at], pivot[max(at - 1, 0) : at] + pivot[at + 1 : at + 2])
            if needed < _MOST and columns[at][pivot[at]] > total * needed:
                letter = (pivot[at], columns[at][pivot[at]])
            letters.append(letter[0])
            shares.append(letter[1] / total)
    return Vote(clean_text("".join(letters)), sum(shares) / len(shares), tuple(ranked))


def _share_needed(added: str, around: str) -> float:
    """The share of the readings that must have a letter, space or mark between two others for it to be there."""
    if not added.strip():
        return _SPACE_SHARE
    return _POINT_SHARE if added in _POINTS and len(around) == 2 and around.isdigit() else _MOST


def _columns(pivot: str, ranked: Sequence[tuple[str, float]]) -> tuple[list[dict[str, float]], list[dict[str, float]]]:
    """Weight of each letter (or of none) at each place of the pivot, and of what is inserted before each place."""
    columns: list[dict[str, float]] = [defaultdict(float) for _ in pivot]
    gaps: list[dict[str, float]] = [defaultdict(float) for _ in range(len(pivot) + 1)]
    for text, weight in ranked:
        inserted: dict[int, str] = defaultdict(str)
        for step in Levenshtein.opcodes(pivot, text):
            own = text[step.dest_start : step.dest_end]
            if step.tag == "insert":
                inserted[step.src_start] += own
            else:
                for offset in range(step.src_end - step.src_start):
                    columns[step.src_start + offset][own[offset] if own else ""] += weight
        for at, letters in inserted.items():
            gaps[at][letters] += weight
    return columns, gaps


def painted_like(known: str, seen: str) -> str:
    """Return `known` with the case in which `seen` is painted, letter by letter; both have the same letters."""
    painted = iter(ch for ch in seen if ch.isalnum())
    letters: list[str] = []
    for ch in known:
        own = next(painted, ch) if ch.isalnum() else ch
        letters.append(own if own.casefold() == ch.casefold() else ch)
    return "".join(letters)


def cased_like(known: str, seen: str) -> str:
    """Return `known` in capitals, in small letters or with capital heads, as the letters of `seen` mostly are."""
    letters = [ch for ch in seen if ch.isalpha() and ch.upper() != ch.lower()]
    if not letters:
        return known
    upper = sum(ch.isupper() for ch in letters) / len(letters)
    if upper > 0.7 and len(letters) > 1:
        return known.upper()
    if upper == 0.0:
        return known.lower()
    if known.isupper() and upper < 0.5:
        return known.title()
    return known if any(ch.isupper() for ch in known) else known.title().replace("'S", "'s").replace("'T", "'t")
