"""What a question wants and what it refuses, as concepts and names."""

from dataclasses import dataclass, field
from functools import lru_cache

_KEPT = 64  # what one question wants, and its parts
THING = 0.7  # a wanted concept of this weight is a thing of its own


@dataclass(frozen=True, slots=True)
class Wish:
    """Concepts wanted and refused, by weight; `language` is None where the question could not be read.

    `wanted_names`, `refused_names` and `near_names` hold the values of the names that were passed in and mentioned;
    `contradicted` are phrases that are wanted and refused in one breath; `rest` is the question
    without what is refused, `left_out` that alone: both are empty where nothing is; `turned` says that turns of phrase
    of other buildings than malls were read in it, so that it may say something else without them.
    """

    wanted: tuple[tuple[str, float], ...]
    refused: tuple[str, ...]
    wanted_names: tuple[str, ...]
    refused_names: tuple[str, ...]
    language: str | None
    near_names: tuple[str, ...] = ()
    contradicted: tuple[str, ...] = ()
    rest: str = ""
    left_out: str = ""
    turned: bool = field(default=False, compare=False)

    @property
    def main(self) -> tuple[str, ...]:
        """The concepts that a place must serve: the weightiest sort of those that are wanted."""
        return _weightiest(self.wanted)


@lru_cache(maxsize=_KEPT)
def _weightiest(wanted: tuple[tuple[str, float], ...]) -> tuple[str, ...]:
    # Every kind of place is held against the same wish.
    things = tuple(concept for concept, weight in wanted if weight >= THING)
    meals = tuple(concept for concept, _ in wanted if concept in ("food", "drink"))
    if things or meals:
        return things or meals
    heaviest = max((weight for _, weight in wanted), default=0.0)
    return tuple(concept for concept, weight in wanted if weight >= 0.9 * heaviest)
