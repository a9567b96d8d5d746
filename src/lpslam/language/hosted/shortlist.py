"""The few landmarks of a large map that a question is put with: a question must not cost more in a larger mall."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, zip_longest

from lpslam.language.model import Candidate, Choice
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge, load_knowledge
from lpslam.language.tables.words import is_unspaced

_FEW_LETTERS = 3  # shorter words of a spaced script say little


def shortlist(question: str, landmarks: Sequence[Candidate], most: int, own: Choice) -> list[Candidate]:
    """Return at most `most` landmarks, in the order given: all of them where there are no more.

    Of more, those that the question names, those that the embedded model chose (`own`) and others of their kinds; and
    for a wish that the embedded model does not understand, one landmark of every kind in turn.
    """
    if len(landmarks) <= most:
        return list(landmarks)
    kinds = _by_kind(landmarks)
    chosen: dict[int, None] = {}
    for share, found in (
        (1, [id_ for id_ in (own.landmark, *own.alternatives) if id_ is not None]),
        (2, _named(question, landmarks)),
        (2, _of_the_kinds_of(own, kinds)),
        (1, _in_turn(kinds.values())),
    ):
        for id_ in found:
            if len(chosen) >= most // share:
                break
            chosen.setdefault(id_)
    return [landmark for landmark in landmarks if landmark.id in chosen]


def _named(question: str, landmarks: Sequence[Candidate]) -> Iterable[int]:
    """Those whose names share words with the question, the largest share first."""
    asked = _pieces(question)
    shares = [(_share(_pieces(landmark.name), asked), landmark.id) for landmark in landmarks]
    return [id_ for share, id_ in sorted(shares, key=lambda each: -each[0]) if share > 0.0]


def _of_the_kinds_of(own: Choice, kinds: dict[str, list[int]]) -> Iterator[int]:
    best = {own.landmark, *own.alternatives}
    return _in_turn(group for kind, group in kinds.items() if kind and not best.isdisjoint(group))


def _by_kind(landmarks: Sequence[Candidate]) -> dict[str, list[int]]:
    knowledge = load_knowledge()
    kinds: dict[str, list[int]] = {}
    for landmark in landmarks:
        kinds.setdefault(_kind(landmark.name, knowledge), []).append(landmark.id)
    return kinds


def _kind(name: str, knowledge: Knowledge) -> str:
    """The kind that a name or one of its words is known for; quicker and coarser than reading the sign."""
    clean = clean_text(name)
    for text in (clean, *reversed(clean.split())):
        key = knowledge.folder.key(text)
        known, word = knowledge.known.get(key), knowledge.painted.get(key)
        kinds = known.kinds if known is not None else word.concepts if word is not None else ()
        if kinds:
            return kinds[0][0]
    return ""


def _in_turn(groups: Iterable[Sequence[int]]) -> Iterator[int]:
    """The first of every group, then the second of every group; in each, far ones first."""
    turns = zip_longest(*(_spread(group) for group in groups))
    return (id_ for id_ in chain.from_iterable(turns) if id_ is not None)


def _spread(group: Sequence[int]) -> Iterator[int]:
    """The same ids, every second one, then those between, as a ruler is read by its marks."""
    seen: set[int] = set()
    step = len(group)
    while step >= 1:
        for at in range(0, len(group), step):
            if at not in seen:
                seen.add(at)
                yield group[at]
        step //= 2


def _share(name: frozenset[str], asked: frozenset[str]) -> float:
    return len(name & asked) / len(name) if name else 0.0


def _pieces(text: str) -> frozenset[str]:
    """Words of a spaced script, pairs of letters of an unspaced one."""
    pieces: set[str] = set()
    for word in clean_text(text).casefold().split():
        letters = "".join(ch for ch in word if ch.isalnum())
        if not letters:
            continue
        if is_unspaced(letters):
            pieces.update(letters[at : at + 2] for at in range(len(letters) - 1))
        elif len(letters) >= _FEW_LETTERS:
            pieces.add(letters)
    return frozenset(pieces)
