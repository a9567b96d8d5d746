"""What tells places of a map apart: the blue room, the north gate; departments of a hospital, doors of a house."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import Kinds, likeness
from lpslam.language.model import Candidate
from lpslam.language.questions.wanted import Wish as Meaning
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import keep_ready, ready, standing
from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.form import Ask, Stop, Which

_ANY_SORT = frozenset({"shop", "business", "place"})
_FEW_OF_A_FAMILY = 3  # rooms of one sort of building that make the map one of it, at least
_NUMBERED = standing(r"[\d.,–~-]*\d[\d.,–~-]*|(?<![^\W\d_])[A-Za-z](?![^\W\d_])")
_MUCH_OF_A_FAMILY = 0.25  # of all landmarks: fewer aisles of goods are shops of a mall
_FIRST_OF_ALL = 0.9  # of a kind that a place is, not one that is had there as well


@lru_cache(maxsize=1)
def _patterns() -> Mapping[tuple[str, str], re.Pattern[str]]:
    """Groups and what each may be, and how that is said; of a group a place has one."""
    tree: Mapping[str, Mapping[str, str]] = read_table("wishes/attributes.json")
    said = {(group, value): _pattern(joined) for group, values in tree.items() for value, joined in values.items()}
    keep_ready("attributes", ((pattern, 0) for pattern in said.values()))
    return {value: ready(pattern) for value, pattern in said.items()}


def _pattern(joined: str) -> str:
    words = re.split(r"\|(?![^()]*\))", joined)
    spaced = "|".join(word for word in words if not is_unspaced(word))
    unspaced = "|".join(word for word in words if is_unspaced(word))
    prefixes = "|".join([word for word in words if word.endswith(r"(?=\w)")] or ["(?!)"])
    # It is looked for in texts without capitals. “Haupt-” and “Süd-” begin words.
    return rf"(?<!\w)(?:{spaced})(?!(?<=\w)[^\W_])|(?<!\w)(?:{prefixes})|{unspaced}"


@lru_cache(maxsize=1 << 14)
def attributes_of(text: str) -> frozenset[tuple[str, str]]:
    """Return what a board or a question says that tells a place from others of its kind: ("colour", "blue")."""
    folded = clean_text(text).casefold()
    return frozenset(value for value, pattern in _patterns().items() if pattern.search(folded))


def told_apart(asked: frozenset[tuple[str, str]], board: frozenset[tuple[str, str]]) -> int:
    """Return how much of what is asked a board says, 0 where it is silent, -1 where it says something else of it."""
    values = dict(board)
    is_another = any(group in values and (group, value) not in board for group, value in asked)
    return -1 if is_another else len(asked & board)


def others_alike(out: Iterable[str], names: Mapping[int, str]) -> set[int]:
    """Return the landmarks whose boards are those of what is left out but for numbers: another room than room 201."""
    sorts = {_NUMBERED.sub("", name).replace(" ", "") for name in out if _NUMBERED.search(name)} - {""}
    numbered = ((id_, name) for id_, name in names.items() if _NUMBERED.search(name))
    return {id_ for id_, name in numbered if _NUMBERED.sub("", name).replace(" ", "") in sorts}


@lru_cache(maxsize=2)
def _kinds(name: str) -> tuple[str, ...]:
    """How the kinds of "parts" of a house begin, or of its "rooms", of which it has several."""
    return tuple(read_table("wishes/house.json")[name].split())


class Sorts:
    """What the landmarks of one map are together, and what that says of each."""

    def __init__(self, landmarks: Sequence[Candidate], index: LandmarkIndex, knowledge: Knowledge) -> None:
        self._landmarks = landmarks
        self._index = index
        self._knowledge = knowledge
        families = [
            {knowledge.family(kind) for kind, weight in sign.kinds if weight >= 0.5} for sign in index.signs.values()
        ]
        self._families = Counter(family for found in families for family in found if family)

    def of_any_sort(self, stop: Stop, meaning: Meaning) -> dict[int, float]:
        """“The shop next to …” is any shop: what the map says of where it stands is all that tells it from others."""
        wanted = {kind for kind, _ in meaning.wanted}
        if not wanted or not wanted <= _ANY_SORT or meaning.refused:
            return {}
        is_told_by_place = stop.relation is not None or stop.ask in (Ask.LIST, Ask.HERE) or stop.which is not Which.ANY
        if not is_told_by_place:
            return {}
        if wanted == {"place"}:
            return {mark.id: 1.0 for mark in self._landmarks}
        return {
            id_: 1.0
            for kinds, ids in self._index.groups.items()
            if self.are_shops(kinds)
            for id_ in ids
            if kinds or self._index.signs[id_].name_like
        }

    def are_shops(self, kinds: Kinds) -> bool:
        """Whether places may be called shops where their place tells which: anything that is no part of the house.

        Of names that say nothing, those that read like names may be.
        """
        if likeness("business", kinds, self._knowledge) >= 0.5:
            return True
        return not any(kind.startswith((*_kinds("parts"), "sign/")) for kind, _ in kinds)

    def of_the_family(self, meaning: Meaning, scores: Mapping[int, float]) -> dict[int, float]:
        """Who asks for one department of a hospital wants no other; an aisle goes before the rest of a supermarket."""
        for kind, _ in meaning.wanted:
            family = self._knowledge.family(kind)
            if family and self._families[family] >= max(_FEW_OF_A_FAMILY, _MUCH_OF_A_FAMILY * len(self._landmarks)):
                alike = self._index.alike(kind)
                own = {id_ for group, sure in alike.items() if sure >= 0.5 for id_ in self._index.members[group]}
                others = {
                    other for other, _ in meaning.wanted if other != kind and (self._knowledge.family(other) == family)
                }
                if own or not others:
                    kept = {id_: score for id_, score in scores.items() if id_ in own}
                    more = {
                        id_: score
                        for id_, score in scores.items()
                        if any(
                            likeness(other, self._index.signs[id_].kinds, self._knowledge) >= 0.5 for other in others
                        )
                    }
                    return kept | more
        return dict(scores)

    def is_of_the_house(self, id_: int) -> bool:
        """Whether a landmark is a part of the building and no business in it: a toilet, a lift, a gate."""
        return self._is_first_of_all(id_, _kinds("parts"))

    def is_a_room(self, id_: int) -> bool:
        """Whether a landmark is of a kind of which a building has several, told apart by names."""
        return self._is_first_of_all(id_, _kinds("rooms"))

    def joins_floors(self, id_: int) -> bool:
        """Whether a landmark is on every floor that it leads to: a lift, stairs."""
        return self._is_first_of_all(id_, _kinds("joins floors"))

    def _is_first_of_all(self, id_: int, kinds: tuple[str, ...]) -> bool:
        # What the further lines of a shop's board list makes no room of it.
        return any(weight >= _FIRST_OF_ALL and kind.startswith(kinds) for kind, weight in self._index.signs[id_].kinds)
