"""A reader of signs as a noisy channel: how likely a painted text is read as it was (text clustering, III-E).

A reading is right with a probability that how it was seen tells, and so, letter by letter, is each of its letters. A
wrong letter is one that looks alike more often than another; a letter that the reader itself held for possible costs
what it said. Ends that are missing were hidden, ends too many belong to a neighbour: neither says anything against the
letters between.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, log

from rapidfuzz.distance import Editop, Levenshtein

from lpslam.language.model import Reading, Slots
from lpslam.language.naming.marks import ODD_MARK, misread_letters
from lpslam.language.tables.spelling import is_alike, is_ideograph

# Natural logarithms of how much rarer each slip is than some slip: of letters that look alike, of any, of none at all,
# of one too many; of ideographs there are thousands.
_ALIKE, _OTHER, _LOST, _ADDED, _OTHER_IDEOGRAPH = 0.0, 1.2, 1.2, 1.5, 4.0
# A slip costs so much more than the letter itself, however poor the reading.
_LEAST_SLIP = 0.3
# An end that is hidden, and each letter of it; an end that is another text's, and each of its letters.
CUT_END, _CUT_LETTER = 2.0, 0.3
_JOINED_END, _JOINED_LETTER = 4.0, 0.8
# A round or square logo beside Chinese is read as a letter of another script, again and again.
_LOGO = 0.8
# The reader's own odds between two letters hold nearly as they are: their logarithm counts for this share, measured
# on drawn lettering (`benchmarks/text_calibration.py odds`).
_OWN_ODDS = 0.7
# The same slip again is this much rarer than another failure, or than the same letters where they are painted: a
# reader that fails on a letter of a sign fails on it in the next view as well.
_AGAIN = 0.7
# A slip that another reading of the same sign shows as well, or the same hidden end: what hides it is still there.
KNOWN = 1.5
# The same neighbour once more, in a reading that is likelier wrong than right: such boxes are seen from afar, where
# they take in both, and each fails in its own way.
_JOINED_AGAIN = 3.0
# A thin letter for which a mark was read, 1 as : or ]; of any other a mark says nothing but where signs have none.
_MARKED, _THIN = 0.7, frozenset("1lijtı")
# A reading of something else altogether.
_FOREIGN = 16.0
# Where nothing says how many views a reading stands for: its number to this power.
_REPETITION = 0.75
_LEAST_RIGHT, _MOST_RIGHT = 0.02, 0.995
# What may be wrong in a reading is shared by its letters as the reader is unsure of each, no surer than this: which
# letters of wrong readings are wrong is told so (`benchmarks/text_calibration.py letters`).
_LEAST_DOUBT = 0.002
# Most log odds by which readings that contradict each other are lowered, and how finely.
_MOST_HUMBLED, _HUMBLED_STEP = 6.0, 0.05


_Slip = tuple[str, int, str]
"""What was done to a letter, its place in the painted key, and the letter that was read."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """One spelling as evidence.

    Attributes:
        key: letters and digits as read, without case.
        right: probability that it is exactly what is painted.
        weight: views of its own that it stands for.
        letters: for each letter of the key, what else it may be, with the reader's probability; empty if not known.
        gaps: before which letter of the key another one was nearly read, and how surely.
        marks: before which letters of the key a mark was read.
        odd: those of them that stand for a letter, since signs have no mark there.
        doubts: of each letter of the key, its share of what may be wrong; empty where all have an equal one.
        whole: probabilities that nothing more is painted before it, and behind it.
    """

    key: str
    right: float
    weight: float
    letters: tuple[Mapping[str, float], ...] = ()
    gaps: Mapping[int, Mapping[str, float]] | None = None
    marks: frozenset[int] = frozenset()
    odd: frozenset[int] = frozenset()
    doubts: tuple[float, ...] = ()
    whole: tuple[float, float] = (1.0, 1.0)


def _none(_: str) -> Sequence[int]:
    return ()


def paint_key(text: str) -> str:
    """What of a text is compared: letters and digits in their own script and form, without case."""
    return "".join(filter(str.isalnum, text.casefold()))


def evidence_of(readings: Iterable[Reading], lost_letters: Callable[[str], Sequence[int]] = _none) -> list[Seen]:
    """Take readings as evidence, the weightiest first; equal keys with equal marks are one; none without a letter.

    Args:
        readings: what was read.
        lost_letters: where in a text spaces stand for letters that cannot be seen.
    """
    grouped: dict[tuple[str, frozenset[int], frozenset[int]], list[Seen]] = {}
    for each in readings:
        key = paint_key(each.text)
        if not key or each.count <= 0:
            continue
        # Where nothing else is known, every letter is as sure as their mean.
        right = min(max(each.confidence, 0.0), 1.0) ** len(key) if each.right is None else each.right
        weight = each.count**_REPETITION if each.looks is None else each.looks
        letters, gaps = _aligned(key, each.slots)
        right, marks = min(max(right, _LEAST_RIGHT), _MOST_RIGHT), _before(each.text, _marks(each.text))
        odd = _before(each.text, [*misread_letters(each.text), *lost_letters(each.text)])
        own = Seen(key, right, weight, letters, gaps, marks, odd, doubts_of(key, letters), each.whole)
        grouped.setdefault((key, marks, odd), []).append(own)
    seen = _humbled(_one_look_at_least([_together(same) for same in grouped.values()]))
    return sorted(seen, key=lambda each: (-each.weight * each.right, each.key))


def _one_look_at_least(seen: list[Seen]) -> list[Seen]:
    """However little readings of one place's far side are worth, together they are worth the one that they are."""
    worth = sum(each.weight for each in seen)
    return [replace(each, weight=each.weight / worth) for each in seen] if 0.0 < worth < 1.0 else seen


def _humbled(seen: list[Seen]) -> list[Seen]:
    """Lower how sure readings are, all by the same odds, until no more of them are right than agree: one can be."""
    agreeing: dict[str, float] = {}
    for each in seen:
        agreeing[each.key] = agreeing.get(each.key, 0.0) + each.weight
    most = max(agreeing.values(), default=0.0)

    def right(each: Seen, shift: float) -> float:
        return 1.0 / (1.0 + (1.0 - each.right) / each.right * exp(shift))

    low, high = 0.0, _MOST_HUMBLED
    if sum(each.weight * each.right for each in seen) <= most:
        return seen
    while high - low > _HUMBLED_STEP:
        shift = (low + high) / 2.0
        is_enough = sum(each.weight * right(each, shift) for each in seen) <= most
        low, high = (low, shift) if is_enough else (shift, high)
    return [replace(each, right=max(right(each, high), _LEAST_RIGHT)) for each in seen]


def _together(same: Sequence[Seen]) -> Seen:
    best = max(same, key=lambda each: each.right)
    weight = sum(each.weight for each in same)
    odds = sum(each.weight * log(each.right / (1.0 - each.right)) for each in same) / max(weight, 1e-9)
    whole = max(each.whole[0] for each in same), max(each.whole[1] for each in same)
    return replace(best, right=1.0 / (1.0 + exp(-odds)), weight=weight, whole=whole)


def _marks(text: str) -> list[int]:
    """Where in a text marks stand, that are no spaces."""
    return [at for at, ch in enumerate(text) if not ch.isalnum() and not ch.isspace()]


def _before(text: str, places: Iterable[int]) -> frozenset[int]:
    """Before which letters of a text's key these places of the text are."""
    return frozenset(len(paint_key(text[:at])) for at in places)


def _aligned(key: str, slots: Slots) -> tuple[tuple[Mapping[str, float], ...], Mapping[int, Mapping[str, float]]]:
    """The slots of the key's letters and of the gaps between; none where the text was mended after it was read."""
    letters: list[Mapping[str, float]] = []
    gaps: dict[int, Mapping[str, float]] = {}
    taken = ""
    for slot in slots:
        folded: dict[str, float] = {}
        for letter, probability in slot:
            folded[paint_key(letter)] = max(probability, folded.get(paint_key(letter), 0.0))
        first = paint_key(slot[0][0])
        taken += first
        if first:
            letters += [folded] * len(first)
        elif not slot[0][0]:
            gaps[len(letters)] = folded
    return (tuple(letters), gaps) if taken == key else ((), {})


def doubts_of(key: str, letters: Sequence[Mapping[str, float]]) -> tuple[float, ...]:
    """Shares of the letters of a key in what may be wrong, by how unsure the reader is of each; empty if not known."""
    if not letters:
        return ()
    doubts = [max(1.0 - slot.get(letter, 1.0), _LEAST_DOUBT) for letter, slot in zip(key, letters, strict=True)]
    return tuple(each / sum(doubts) for each in doubts)


def log_likelihood(painted: str, evidence: Iterable[Seen], looks: Callable[[str], str]) -> float:
    """Logarithm of how likely a sign that says `painted` is read as all of the evidence, in all of its looks.

    What kind of slip it is counts once: a reader that fails on a letter of a sign fails on it again in the same way.

    Args:
        painted: key, not empty.
        evidence: what was read, the weightiest first.
        looks: takes a letter to what it looks like.
    """
    known: set[_Slip] = set()
    return sum(_of_one(painted, seen, looks, known) for seen in evidence)


def _of_one(painted: str, seen: Seen, looks: Callable[[str], str], known: set[_Slip]) -> float:
    all_right = log(seen.right)
    if painted == seen.key and not seen.odd:
        return seen.weight * all_right
    ends, slips = _costs(painted, seen, looks, known)
    first = max(all_right - ends - slips, -_FOREIGN)
    if seen.weight <= 1.0:
        return seen.weight * first
    ends, _ = _costs(painted, seen, looks, known)
    again = max((min(log(1.0 - seen.right), all_right) - _AGAIN if slips else all_right) - ends, first)
    return first + (seen.weight - 1.0) * again


def _costs(painted: str, seen: Seen, looks: Callable[[str], str], known: set[_Slip]) -> tuple[float, float]:
    """Costs of the likeliest way from a painted key to the one read: of its ends, and of its slips.

    Slips that are `known` of this sign cost little; those of this reading are, from then on.
    """
    read = seen.key
    if painted == read or looks(painted) == looks(read):
        return _odd_cost(seen.odd, known), 0.0 if painted == read else slip_of(seen) + _ALIKE
    steps = steps_between(painted, read)
    cut = ends_of({step.src_pos for step in steps if step.tag == "delete"}, len(painted))
    joined = ends_of({step.dest_pos for step in steps if step.tag == "insert"}, len(read))
    ends = sum(
        _once(("cut", len(end), str(at > 0)), _cut_cost(painted, end, at in seen.marks, whole), known)
        for end, at, whole in zip(cut, (0, len(read)), seen.whole, strict=True)
        if end
    )
    for side, end in enumerate(joined):
        slips = sum(added_cost(painted, seen, at) for at in end)
        cost = min(_JOINED_END + _JOINED_LETTER * len(end), slips)
        again = _JOINED_AGAIN if seen.right < 0.5 else cost
        ends += _once(("joined", side, ""), cost, known, again) if end else 0.0
    ends_lost, ends_added = cut[0] | cut[1], joined[0] | joined[1]
    ends += _odd_cost(seen.odd - {step.dest_pos for step in steps if step.tag == "delete"}, known)
    cost = 0.0
    for step in steps:
        own = (step.tag, step.src_pos, read[step.dest_pos] if step.tag != "delete" else "")
        if step.tag == "replace":
            one = replaced_cost(painted[step.src_pos], seen, step.dest_pos, looks)
        elif step.tag == "delete" and step.src_pos not in ends_lost:
            one = lost_cost(painted[step.src_pos], seen, step.dest_pos)
        elif step.tag == "insert" and step.dest_pos not in ends_added:
            one = added_cost(painted, seen, step.dest_pos)
        else:
            continue
        cost += _once(own, one, known)
    return ends, cost


def _odd_cost(odd: Iterable[int], known: set[_Slip]) -> float:
    """What marks cost for which no letter is painted, in places where signs have none."""
    return sum(_once(("mark", at, ""), ODD_MARK, known) for at in odd)


def _once(slip: _Slip, cost: float, known: set[_Slip], again: float = KNOWN) -> float:
    """What a slip costs, which is known of this sign from then on."""
    if slip in known:
        return min(cost, again)
    known.add(slip)
    return cost


def steps_between(painted: str, read: str) -> Sequence[Editop]:
    """The fewest steps from what is painted to what was read; all at the ends where one is a piece of the other.

    “Centre” is “copy centre” with its beginning hidden, and not a c, a gap in the middle, and “entre”.
    """
    first, second = painted.find(read), read.find(painted)
    if first >= 0:
        lost = [at for at in range(len(painted)) if not first <= at < first + len(read)]
        return [Editop("delete", at, 0 if at < first else len(read)) for at in lost]
    if second >= 0:
        added = [at for at in range(len(read)) if not second <= at < second + len(painted)]
        return [Editop("insert", 0 if at < second else len(painted), at) for at in added]
    return list(Levenshtein.editops(painted, read))


def slip_of(seen: Seen, at: int | None = None, before: int | None = None) -> float:
    """Cost of some slip in a letter of a reading, in the gap before one, or in the mean letter."""
    share = 1.0 / len(seen.key)
    if seen.doubts and at is not None:
        share = seen.doubts[at]
    elif seen.doubts and before is not None and 0 < before < len(seen.key):
        share = (seen.doubts[before - 1] + seen.doubts[before]) / 2.0
    letter_right = seen.right**share
    return max(-log(1.0 - letter_right) + log(letter_right), _LEAST_SLIP)


def _cut_cost(painted: str, end: set[int], is_marked: bool, whole: float) -> float:
    """Cost of letters missing at an end, where a text is whole with such a probability by the view.

    Where a mark was read for thin ones, they were seen and not hidden.
    """
    is_seen = is_marked and all(painted[at] in _THIN for at in end)
    hidden = min(CUT_END, -log(1.0 - whole)) if whole < 1.0 else CUT_END
    return (_MARKED if is_seen else hidden) + _CUT_LETTER * (len(end) - 1)


def ends_of(places: set[int], length: int) -> tuple[set[int], set[int]]:
    """Which of the places reach from the first on, and which to the last."""
    first = next(at for at in range(length + 1) if at not in places)
    last = next(at for at in range(length - 1, -2, -1) if at not in places)
    head = set(range(first))
    return head, set(range(last + 1, length)) - head


def replaced_cost(letter: str, seen: Seen, at: int, looks: Callable[[str], str]) -> float:
    """Cost of what was read in place `at` where `letter` is painted."""
    other, slot = seen.key[at], seen.letters[at] if seen.letters else {}
    # What the reader itself held for possible looks alike as well; among ideographs there always is something.
    if is_alike(letter, other, looks) or (slot.get(letter) and not is_ideograph(letter)):
        kind = _ALIKE
    else:
        kind = _OTHER_IDEOGRAPH if is_ideograph(letter) and is_ideograph(other) else _OTHER
    return min(slip_of(seen, at) + kind, _own_cost(slot, other, letter))


def lost_cost(letter: str, seen: Seen, at: int) -> float:
    """Cost of nothing read before place `at` where `letter` is painted."""
    gap = seen.gaps.get(at, {}) if seen.gaps else {}
    if at in seen.odd:
        return _MARKED
    return min(slip_of(seen, before=at) + _LOST, _own_cost(gap, "", letter))


def added_cost(painted: str, seen: Seen, at: int) -> float:
    """Cost of the letter in place `at` of a reading where nothing is painted."""
    letter = seen.key[at]
    is_end = at in (0, len(seen.key) - 1)
    if is_end and letter.isascii() and letter.isalpha() and not any(map(str.isascii, painted)):
        return _LOGO
    return min(slip_of(seen, at) + _ADDED, _own_cost(seen.letters[at] if seen.letters else {}, letter, ""))


def _own_cost(slot: Mapping[str, float], taken: str, wanted: str) -> float:
    """Cost at which the reader itself would have had another letter; without end where it did not think of it."""
    if not slot.get(wanted) or not slot.get(taken):
        return float("inf")
    return _OWN_ODDS * max(log(slot[taken] / slot[wanted]), 0.0)
