"""What words mean together wherever they stand in a question: “borrow … wheelchair”.

The rows are those of `concepts.py` with `+`: each part is the beginning of a word, or, in scripts without spaces, a run
of characters.
"""

from collections import defaultdict
from collections.abc import Sequence

from lpslam.language.languages import LATIN
from lpslam.language.tables.concepts import load_buildings
from lpslam.language.tables.states import Trouble
from lpslam.language.tables.words import Folder

_BEGINNING = 4  # letters of a part by which rows are found
_WHOLE = 4  # letters, with the space before them, up to which a part is a whole word
_FARTHEST_WORDS, _FARTHEST_LETTERS = 14, 24  # from the first part to the last


class Combined:
    """The rows of one language."""

    def __init__(self, language: str, folder: Folder) -> None:
        self._is_spaced = language in LATIN
        self._farthest = _FARTHEST_WORDS if self._is_spaced else _FARTHEST_LETTERS
        self._rows = [
            (sorted((self._part(part, folder) for part in parts), key=len, reverse=True), entry.name)
            for entry in load_buildings().concepts
            for parts in entry.apart.get(language, ())
        ]
        # The longest part is the rarest: few rows are looked at further.
        self._beginning: dict[str, list[int]] = defaultdict(list)
        for row, (parts, _) in enumerate(self._rows):
            self._beginning[parts[0][:_BEGINNING]].append(row)
        self._sizes = {len(each) for each in self._beginning}
        self._last: tuple[tuple[str, ...], list[Trouble]] | None = None

    def _part(self, part: str, folder: Folder) -> str:
        """A part as the units of a question are joined: “can't find” is “ca not find” there."""
        part = " ".join(folder.units(part)) if "'" in part else folder.fold(part).replace("-", " ")
        if not self._is_spaced:
            return part.replace(" ", "")
        return f" {part}"

    def found(self, units: Sequence[str]) -> list[Trouble]:
        """Return what the units of a question mean together, and which units say so."""
        # One question is looked at again and again.
        last = self._last
        if last is None or last[0] != tuple(units):
            last = self._last = (tuple(units), self._found(units))
        return last[1]

    def _found(self, units: Sequence[str]) -> list[Trouble]:
        text, at_letter = "", list[int]()
        for at, unit in enumerate(units):
            piece = f" {unit}" if self._is_spaced else unit
            text += piece
            at_letter += [at] * len(piece)
        text += " "
        at_letter.append(len(units) - 1)
        found: dict[str, set[int]] = {}
        for row in self._rows_in(text):
            parts, concept = self._rows[row]
            if any(part not in text for part in parts):
                continue
            spans = [_letters(part, text) for part in parts]
            if all(spans):
                own = {at for start, end in spans for at in at_letter[start:end]}
                if max(own) - min(own) <= self._farthest:
                    found.setdefault(concept, set()).update(own)
        return [Trouble(concept, frozenset(own)) for concept, own in found.items()]

    def _rows_in(self, text: str) -> list[int]:
        """The rows of which the beginning of a part is in a text."""
        said = {text[at : at + size] for size in self._sizes for at in range(len(text) - size + 1)}
        return sorted(row for each in said & self._beginning.keys() for row in self._beginning[each])


def _letters(part: str, text: str) -> tuple[int, ...]:
    """Where the letters of a part stand, without the space before it; a short one stands as a word of its own only."""
    start = text.index(part)
    end = start + len(part)
    if part.startswith(" ") and len(part) <= _WHOLE:
        while not _is_whole(text, end):
            start = text.find(part, start + 1)
            if start < 0:
                return ()
            end = start + len(part)
    return (start + part.startswith(" "), end)


def _is_whole(text: str, end: int) -> bool:
    """Whether a word ends here, but for the s of a plural."""
    return text[end] == " " or text[end : end + 2] == "s "
