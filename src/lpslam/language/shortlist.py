"""The few landmarks of a large map that a question is put with: a question must not cost more in a larger mall."""

from collections.abc import Sequence
from itertools import zip_longest

from lpslam.language.model import Candidate, LanguageModel
from lpslam.language.sanitise import clean_text
from lpslam.language.signs import load_sign_reader
from lpslam.language.words import is_unspaced

_ROUNDS = 4  # of the embedded model, which names its best six each time
_FEW_LETTERS = 3  # shorter words of a spaced script say little


def shortlist(question: str, landmarks: Sequence[Candidate], most: int, embedded: LanguageModel) -> list[Candidate]:
    """Return at most `most` landmarks, in the order given: all of them where there are no more.

    Of more, those that the question names, those that the embedded model finds fitting, and for a wish that it does
    not understand one landmark of every kind in turn.
    """
    if len(landmarks) <= most:
        return list(landmarks)
    by_name = _named(question, landmarks)[: most // 3]
    fitting = _fitting(question, landmarks, embedded)[: most // 3]
    chosen = dict.fromkeys(landmark.id for landmark in (*by_name, *fitting))
    for landmark in _one_of_every_kind(landmarks):
        if len(chosen) >= most:
            break
        chosen.setdefault(landmark.id)
    return [landmark for landmark in landmarks if landmark.id in chosen]


def _named(question: str, landmarks: Sequence[Candidate]) -> list[Candidate]:
    """Those whose names share words with the question, the largest share first."""
    asked = _pieces(question)
    shares = [(_share(_pieces(landmark.name), asked), landmark) for landmark in landmarks]
    return [landmark for share, landmark in sorted(shares, key=lambda each: -each[0]) if share > 0.0]


def _fitting(question: str, landmarks: Sequence[Candidate], embedded: LanguageModel) -> list[Candidate]:
    found: list[Candidate] = []
    remaining = {landmark.id: landmark for landmark in landmarks}
    for _ in range(_ROUNDS):
        choice = embedded.choose(question, list(remaining.values()))
        ids = [choice.landmark, *choice.alternatives]
        new = [remaining.pop(id_) for id_ in ids if id_ is not None and id_ in remaining]
        if not new:
            break
        found += new
    return found


def _one_of_every_kind(landmarks: Sequence[Candidate]) -> list[Candidate]:
    """All landmarks, so ordered that their beginning holds as many kinds as there are; evenly over the map in each."""
    reader = load_sign_reader()
    kinds: dict[str, list[Candidate]] = {}
    for landmark in landmarks:
        meaning = reader.read(landmark.name).kinds
        kinds.setdefault(meaning[0][0] if meaning else "", []).append(landmark)
    turns = zip_longest(*(_spread(group) for group in kinds.values()))
    return [landmark for turn in turns for landmark in turn if landmark is not None]


def _spread(group: Sequence[Candidate]) -> list[Candidate]:
    """The same landmarks with far ones first: every second, then those between, as in a ruler read by its marks."""
    order: dict[int, None] = {}
    step = len(group)
    while step >= 1:
        order.update(dict.fromkeys(range(0, len(group), step)))
        step //= 2
    return [group[at] for at in order]


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
