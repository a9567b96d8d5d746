"""Which floor a wish names, in any language; where the floors lie is the map's knowledge."""

import re
from collections.abc import Iterator, Mapping
from functools import lru_cache

from lpslam.language.tables.lexicon import read_table
from lpslam.language.tables.patterns import keep_ready, ready
from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.codes import in_digits
from lpslam.language.wishes.form import Counting, Floor

_COUNTED_FROM_ONE = frozenset({"zh", "ja", "ko"})
"""Languages in which the ground floor is the first."""
_MOST = 60  # floors of a building: a larger number is none


@lru_cache(maxsize=1)
def _patterns() -> Mapping[str, re.Pattern[str]]:
    table: Mapping[str, str] = read_table("wishes/floors.json")

    numbered = (
        rf"(?<!\w)(?:{table['before']})[ ](?:no\.? ?)?(?P<one>-?\d{{1,2}})(?![\w.])"
        rf"|(?<![a-zA-Z\d.-])(?P<two>-?\d{{1,2}})(?:{table['ordinal']})? ?"
        rf"(?:(?:{table['after']})(?!\w)|{table['after_unspaced']})"
    )
    below = (
        rf"(?<!\w)(?:{table['below']}) ?(?P<three>\d)? ?(?:(?:{table['after']})(?!\w)|{table['after_unspaced']})?(?!\w)"
        rf"|(?:地下|지하 ?|负|負|(?<!\w)b)(?P<four>\d) ?(?:{table['after_unspaced']})"
    )
    alone = {name: _alone(table[name]) for name in ("ground", "same", "top", "up", "down")}
    said = {
        name: f"{table['lead']}(?:{words}){table['tail']}"
        for name, words in {"below": below, **alone, "numbered": numbered}.items()
    }
    keep_ready("floors", ((pattern, re.IGNORECASE) for pattern in said.values()))
    return {name: ready(pattern, re.IGNORECASE) for name, pattern in said.items()}


def _alone(joined: str) -> str:
    words = re.split(r"\|(?![^()]*\))", joined)
    spaced = "|".join(word for word in words if not is_unspaced(word))
    unspaced = "|".join(word for word in words if is_unspaced(word))
    return rf"(?<!\w)(?:{spaced})(?!\w)|{unspaced}"


def floor_of(text: str, language: str | None) -> tuple[Floor | None, str, bool]:
    """Return the floor that a text names, what it says beside it, and whether it names two that cannot both be."""
    # Spelled numbers are read where that says more: “the first floor that is on the ground floor”.
    read = [(said, list(_floors(said, language))) for said in dict.fromkeys((text, in_digits(text)))]
    said, found = max(read, key=lambda each: len({floor for floor, _ in each[1]}))
    if not found:
        return None, text, False
    rest = said
    for start, end in sorted({span for _, span in found}, reverse=True):
        rest = f"{rest[:start]} {rest[end:]}"
    floors = {floor for floor, _ in found}
    return found[0][0], " ".join(rest.split()).strip(" ,，、"), len(floors) > 1


def _floors(text: str, language: str | None) -> Iterator[tuple[Floor, tuple[int, int]]]:
    """Every floor that is named, the numbered ones last; no letter is read twice."""
    counting = Counting.FROM_ONE if language in _COUNTED_FROM_ONE else Counting.ABOVE_GROUND
    taken: set[int] = set()
    for name, pattern in _patterns().items():
        for hit in pattern.finditer(text):
            if not taken.isdisjoint(range(*hit.span())):
                continue
            floor = _floor(name, hit, counting)
            if floor is not None:
                taken.update(range(*hit.span()))
                yield floor, hit.span()


def _floor(name: str, hit: re.Match[str], counting: Counting) -> Floor | None:
    if name == "below":
        return Floor(Counting.ABOVE_GROUND, -int(hit["three"] or hit["four"] or 1))
    if name == "numbered":
        number = int(hit["one"] or hit["two"])
        if abs(number) > _MOST:
            return None
        return Floor(counting if number > 0 else Counting.ABOVE_GROUND, number)
    if name == "ground":
        return Floor(Counting.ABOVE_GROUND, 0)
    if name == "top":
        return Floor(Counting.TOP, 0)
    return Floor(Counting.FROM_HERE, {"up": 1, "down": -1, "same": 0}[name])
