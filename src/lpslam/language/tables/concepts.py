"""Concepts of all kinds of buildings, each one entry: what signs say of it and how one asks for it, in every language.

A file of `data/lexicon/buildings/` is one kind of building. An entry reads

    zoo/elephants < zoo/animals ~ tourism/zoo 0.5
    en elephants|elephant house // tusks|long+trunk

First the concept, after `<` the kinds above it, after `~` other kinds of place that serve it, and how well. Then a
line a language (`any` is every language): words on signs and in questions, after `//` words of questions only. Parts
joined by `+` are words that say it together, in any order. `family NAME: START …` says that rooms whose
concepts begin so tell what the building is.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files

from lpslam.language.languages import LANGUAGES

SIDES = " // "
APART = "+"
EVERY = "any"


@dataclass(frozen=True, slots=True)
class Concept:
    """One entry.

    Attributes:
        name: of the concept.
        above: kinds that it is one of.
        sellers: other kinds of place that serve it, by how well, 0 to 1.
        signs: words on signs, by language, joined by bars.
        asked: words of questions only, by language, joined by bars.
        apart: parts of words that mean it together, by language.
    """

    name: str
    above: tuple[str, ...] = ()
    sellers: Mapping[str, float] = field(default_factory=dict)
    signs: dict[str, str] = field(default_factory=dict)
    asked: dict[str, str] = field(default_factory=dict)
    apart: dict[str, tuple[tuple[str, ...], ...]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Buildings:
    """All entries, and which beginnings of concepts tell which kind of building."""

    concepts: tuple[Concept, ...]
    families: Mapping[str, tuple[str, ...]]


@lru_cache(maxsize=1)
def load_buildings() -> Buildings:
    """Read all files, once a process."""
    folder = files("lpslam.language") / "data" / "lexicon" / "buildings"
    concepts: list[Concept] = []
    families: dict[str, tuple[str, ...]] = {}
    for path in sorted(folder.iterdir(), key=lambda each: each.name):
        lines = path.read_text(encoding="utf-8").splitlines()
        families.update(_families(lines))
        concepts += _concepts(lines)
    return Buildings(tuple(concepts), families)


def load_associations(language: str) -> Iterator[tuple[str, list[str]]]:
    """Return the words of a language that are associated with concepts, though they do not say them.

    The files of `data/lexicon/associations` have entries as those of buildings have, without sides.
    """
    folder = files("lpslam.language") / "data" / "lexicon" / "associations"
    for path in sorted(folder.iterdir(), key=lambda each: each.name):
        concept = ""
        for line in path.read_text(encoding="utf-8").splitlines():
            head, _, said = line.partition(" ")
            if head == language:
                yield concept, [text.strip() for text in said.split("|") if text.strip()]
            elif head and head not in LANGUAGES and not head.startswith("#"):
                concept = head


def _families(lines: Sequence[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    for line in lines:
        if line.startswith("family "):
            name, _, starts = line.removeprefix("family ").partition(":")
            yield name.strip(), tuple(starts.split())


def _concepts(lines: Sequence[str]) -> Iterator[Concept]:
    concept: Concept | None = None
    for line in lines:
        language, _, said = line.partition(" ")
        if concept is not None and language == EVERY:
            for each in LANGUAGES:
                _add(concept, each, said)
        elif concept is not None and language in LANGUAGES:
            _add(concept, language, said)
        elif line and not line.startswith(("#", "family ")):
            concept = _headed(line)
            yield concept


def _headed(line: str) -> Concept:
    """A concept as the first line of its entry names it."""
    rest, _, sellers = line.partition(" ~ ")
    name, _, above = rest.partition(" < ")
    parts = sellers.split()
    shares = {kind: float(share) for kind, share in zip(parts[::2], parts[1::2], strict=True)}
    return Concept(name.strip(), tuple(above.split()), shares)


def _add(concept: Concept, language: str, said: str) -> None:
    signs, _, asked = f" {said} ".partition(SIDES)
    phrases = [text.strip() for text in asked.split("|") if text.strip()]
    concept.signs[language] = signs.strip()
    concept.asked[language] = "|".join(text for text in phrases if APART not in text)
    concept.apart[language] = tuple(tuple(text.split(APART)) for text in phrases if APART in text)
