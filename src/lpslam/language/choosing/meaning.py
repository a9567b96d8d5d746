"""What a question and a board have in common without a common word: vectors of the pieces of words.

A text is cut into the likeliest pieces (Kudo 2018); the sum of their vectors is the text's, turned once for questions
and once for boards. Vectors and turns are in `data/meaning.npz`, distilled from universal-sentence-encoder-multilingual
3 and fitted to the tables by `tools/train_meaning.py`.
"""

import math
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Vectors = NDArray[np.float32]

WRITTEN = Path(__file__).parent.parent / "data" / "meaning.npz"
_SPACE = "▁"  # stands for a space in pieces
_UNKNOWN = -20.0  # log probability of a letter of no piece
_BEGINNING = 2  # letters of a piece by which it is looked for
_LEVELS = 15  # steps of a number of four bits


def folded(text: str) -> str:
    """Return a text as it is cut into pieces: one form of each letter, small, single spaces."""
    return " ".join(unicodedata.normalize("NFKC", text).lower().split())


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Pieces of words with the logarithm of how likely each is, shape (pieces,)."""

    texts: tuple[str, ...]
    scores: NDArray[Any]
    _at: dict[str, int] = field(init=False)
    _sizes: dict[str, list[int]] = field(init=False)
    _score: list[float] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_at", {text: at for at, text in enumerate(self.texts)})
        sizes: dict[str, set[int]] = {}
        for text in self.texts:
            sizes.setdefault(text[:_BEGINNING], set()).add(len(text))
        object.__setattr__(self, "_sizes", {beginning: sorted(found) for beginning, found in sizes.items()})
        object.__setattr__(self, "_score", np.asarray(self.scores, float).tolist())

    def of(self, text: str) -> list[int]:
        """Return the likeliest pieces of a folded text, as rows; letters of no piece are left out."""
        if not text:
            return []
        said = _SPACE + text.replace(" ", _SPACE)
        rows, scores, length = self._at, self._score, len(said)
        best = [0.0] + [-math.inf] * length
        back: list[tuple[int, int]] = [(0, -1)] * (length + 1)
        for start, letter in enumerate(said):
            # A letter that is no piece stands alone.
            one, so_far = rows.get(letter, -1), best[start]
            score = so_far + (scores[one] if one >= 0 else _UNKNOWN)
            if score > best[start + 1]:
                best[start + 1], back[start + 1] = score, (start, one)
            for size in self._sizes.get(said[start : start + _BEGINNING], ()):
                end = start + size
                if end > length:
                    break
                row = rows.get(said[start:end])
                if row is not None and (score := so_far + scores[row]) > best[end]:
                    best[end], back[end] = score, (start, row)
        found: list[int] = []
        at = len(said)
        while at > 0:
            at, row = back[at]
            found += [row] if row >= 0 else []
        return found[::-1] if any(self.texts[row] != _SPACE for row in found) else []


class Senses:
    """The vectors of meaning of texts, each of length 1, or 0 where no piece of a text is known."""

    def __init__(self, document: Mapping[str, NDArray[Any]]) -> None:
        self._pieces = Pieces(tuple(_texts(document["pieces"])), document["scores"])
        self._rows, self._scale = document["rows"], document["scale"]
        self._turns = {side: document[side].astype(np.float32) for side in ("asked", "board")}
        middles = document["middles"].astype(np.float32)
        self.concepts = {name: row for row, name in enumerate(_texts(document["concepts"]))}
        self.middles: Vectors = _unit(middles)

    def asked(self, text: str) -> Vectors:
        """(size,) of a question."""
        return np.asarray(self._of([text], "asked")[0])

    def boards(self, texts: Sequence[str]) -> Vectors:
        """(n, size) of what stands on boards."""
        return self._of(texts, "board")

    def _of(self, texts: Sequence[str], side: str) -> Vectors:
        rows = [self._pieces.of(folded(text)) for text in texts]
        flat = np.array([at for row in rows for at in row], int)
        sums = np.zeros((len(texts), self._turns[side].shape[0]), np.float32)
        np.add.at(sums, np.repeat(np.arange(len(texts)), [len(row) for row in rows]), self._unpacked(flat))
        return _unit(sums @ self._turns[side])

    def _unpacked(self, at: NDArray[Any]) -> Vectors:
        two = self._rows[at]
        numbers = np.stack([two >> 4, two & 15], axis=-1).reshape(len(at), 2 * two.shape[1])
        return np.asarray((numbers - 0.5 * _LEVELS) * self._scale[at, None], np.float32)


def packed(
    pieces: Pieces, vectors: Vectors, turns: tuple[Vectors, Vectors], concepts: Mapping[str, Vectors]
) -> dict[str, NDArray[Any]]:
    """Return what is written: four bits a number of pieces' (n, size) vectors, eight of concepts' ones."""
    scale = 2.0 * np.abs(vectors).max(axis=1) / _LEVELS + 1e-9
    numbers = np.clip(np.round(vectors / scale[:, None] + 0.5 * _LEVELS), 0, _LEVELS).astype(np.uint8)
    middles = np.array(list(concepts.values()))
    return {
        "pieces": np.frombuffer("\n".join(pieces.texts).encode(), np.uint8),
        "scores": pieces.scores.astype(np.float16),
        "rows": numbers[:, ::2] << 4 | numbers[:, 1::2],
        "scale": scale.astype(np.float32),
        "asked": turns[0].astype(np.float16),
        "board": turns[1].astype(np.float16),
        "concepts": np.frombuffer("\n".join(concepts).encode(), np.uint8),
        "middles": np.round(127.0 * middles / np.abs(middles).max()).astype(np.int8),
    }


@lru_cache(maxsize=1)
def load_senses() -> Senses:
    """Read the vectors, once a process."""
    with np.load(WRITTEN, allow_pickle=False) as document:
        return Senses(dict(document))


def _texts(joined: NDArray[Any]) -> list[str]:
    return bytes(joined).decode().split("\n")


def _unit(vectors: Vectors) -> Vectors:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9), np.float32)
