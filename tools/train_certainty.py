"""Train how sure the embedded model is that what it found is what was meant.

python tools/train_certainty.py             # report by leaving each set of wishes out
python tools/train_certainty.py --write     # train on all and write data/wishes/certainty.json

Every stop of the sets in benchmarks/language that is answered by words, and whether the answer is right. Sets of
questions without positions are among the training sets, never among those that are reported. The tables were mended by
nearly all of them, so their answers are surer than those of questions that nobody has seen. Therefore the model is
trained on answers of tables of which a part is hidden, another part each round: turns of phrase sooner than words.
"""

import argparse
import json
import sys
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "benchmarks"))

from lpslam.language.choosing import evidence  # noqa: E402
from lpslam.language.offline import OfflineModel  # noqa: E402
from lpslam.language.signs.reader import load_sign_reader  # noqa: E402
from lpslam.language.tables import combined, knowledge  # noqa: E402
from lpslam.language.tables.concepts import APART, Buildings, load_associations, load_buildings  # noqa: E402
from lpslam.language.tables.lexicon import load_lexicons, split  # noqa: E402
from lpslam.language.wishes import certainty, scoring  # noqa: E402
from lpslam.language.wishes.served import UNQUESTIONED  # noqa: E402
from lpslam.navigation import solver  # noqa: E402
from lpslam.navigation.places import Here  # noqa: E402
from wishes import is_right, places_of  # noqa: E402

WRITTEN = ROOT / "src" / "lpslam" / "language" / "data" / "wishes" / "certainty.json"
SETS = ROOT / "benchmarks" / "language"
REPORTED = (
    "development",
    "own_second",
    "blind_first",
    "blind_second",
    "blind_third",
    "blind_fourth",
    "blind_fifth",
    "blind_sixth",
)
RIDGE = 1000.0  # of the weights, in columns of spread 1: few of the products of two tell anything
STEPS = 15  # of Newton's method, more than it takes
OF_WISHES = 5.0  # what an answer to a wish weighs: there are five times as many to questions in malls
TOLD = (0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9)  # probabilities of the report

HIDDEN_WORDS, HIDDEN_TURNS = 0.12, 0.45  # of the tables' words, and of their phrases of several words
ROUNDS = 3
SECTIONS = ("means", "venues", "said", "said_in_venues")

Rows = list[tuple[dict[str, float], bool, bool]]
"""Clues, whether the answer is right, and whether none would have been."""


def wishes_of(name: str) -> dict[str, Any]:
    """The worlds of a set of wishes."""
    worlds: dict[str, Any] = json.loads((SETS / f"wishes_{name}.json").read_text(encoding="utf-8"))["worlds"]
    return worlds


def questions_of(path: Path) -> dict[str, Any]:
    """The questions of a set without positions, as worlds whose places stand at one point."""
    tree = json.loads(path.read_text(encoding="utf-8")).get("choosing")
    if not isinstance(tree, dict):
        return {}
    worlds: dict[str, Any] = {}
    for case in tree["questions"]:
        names = tree["places"][case["place"]] if "place" in case else case.get("landmarks", tree.get("landmarks"))
        key = json.dumps(names, ensure_ascii=False)
        rows = [{"name": name, "position": [0.0, 0.0]} for name in names]
        worlds.setdefault(key, {"places": rows, "wishes": []})["wishes"].append({"category": "want", **case})
    return worlds


def rows_of(worlds: dict[str, Any], model: OfflineModel) -> Rows:
    """One row a wish that is answered by words, plans apart."""
    rows: Rows = []
    for world in worlds.values():
        places, candidates = places_of(world)
        scorer = model.scorer(candidates)
        at = world.get("here")
        for case in world["wishes"]:
            if case.get("category") == "plan":
                continue
            said = case.get("here", at)
            here = Here(None if said is None else np.array([*said, 0.0][:3], dtype=float))
            solution = solver.solve(model.read_wish(case["question"]), places, scorer, here)
            last = solution.stops[-1]
            if last.place is None or len(solution.stops) > 1 or not last.stop.what:
                continue
            served = scorer.serve(last.stop)
            if not served.scores or served.way in UNQUESTIONED:
                continue
            rows.append((scorer.clues(served), is_right(case, solution), not case["expected"]))
    return rows


def is_kept(seed: int, phrase: str) -> bool:
    """Whether a phrase is left in the tables of a round."""
    is_turn = " " in phrase or APART in phrase or (len(phrase) > 4 and not phrase.isascii() and ord(phrase[0]) > 0x3000)
    drawn = zlib.crc32(f"{seed} {phrase}".encode()) / 2**32
    return drawn >= (HIDDEN_TURNS if is_turn else HIDDEN_WORDS)


def hiding(seed: int) -> Callable[[], dict[str, dict[str, Any]]]:
    """Lexicons of which a part is hidden."""

    def load() -> dict[str, dict[str, Any]]:
        lexicons = load_lexicons()
        for lexicon in lexicons.values():
            for section in SECTIONS:
                lexicon[section] = {
                    concept: "|".join(phrase for phrase in split(joined) if is_kept(seed, phrase))
                    for concept, joined in lexicon.get(section, {}).items()
                }
        return lexicons

    return load


def hiding_apart(seed: int) -> Callable[[], Buildings]:
    """Entries of buildings of which a part of the words that stand apart is hidden."""

    def load() -> Buildings:
        entries = load_buildings()
        concepts = tuple(
            replace(
                entry,
                apart={
                    language: tuple(parts for parts in rows if is_kept(seed, APART.join(parts)))
                    for language, rows in entry.apart.items()
                },
            )
            for entry in entries.concepts
        )
        return replace(entries, concepts=concepts)

    return load


def hiding_associations(seed: int) -> Callable[[str], Iterator[tuple[str, list[str]]]]:
    """Associations of which a part is hidden."""

    def load(language: str) -> Iterator[tuple[str, list[str]]]:
        for concept, phrases in load_associations(language):
            yield concept, [phrase for phrase in phrases if is_kept(seed, phrase)]

    return load


def model_of(seed: int | None) -> OfflineModel:
    """The embedded model, with a part of its tables hidden unless `seed` is None."""
    knowledge.load_lexicons = load_lexicons if seed is None else hiding(seed)  # type: ignore[attr-defined]
    combined.load_buildings = load_buildings if seed is None else hiding_apart(seed)  # type: ignore[attr-defined]
    evidence.load_buildings = combined.load_buildings  # type: ignore[attr-defined]
    evidence.load_associations = load_associations if seed is None else hiding_associations(seed)  # type: ignore[attr-defined]
    knowledge.load_knowledge.cache_clear()
    load_sign_reader.cache_clear()
    return OfflineModel()


@dataclass(frozen=True, eq=False)
class Trained:
    """A logistic model of clues and their products of two."""

    names: tuple[str, ...]
    weights: NDArray[np.float64]
    bias: float

    def probabilities(self, rows: Rows) -> NDArray[np.float64]:
        """Of each row."""
        x = certainty.paired(np.array([[clues[name] for name in self.names] for clues, _, _ in rows]))
        return np.asarray(1.0 / (1.0 + np.exp(-(x @ self.weights + self.bias))))

    def to_document(self) -> dict[str, Any]:
        """As it is shipped."""
        return {"names": self.names, "bias": round(self.bias, 4), "weights": np.round(self.weights, 4).tolist()}


def fitted(rows: Rows, weight: NDArray[np.float64]) -> Trained:
    """Logistic regression by Newton's method, with columns of equal spread."""
    names = tuple(sorted(rows[0][0]))
    x = certainty.paired(np.array([[clues[name] for name in names] for clues, _, _ in rows]))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-6
    z = np.hstack([(x - mean) / spread, np.ones((len(x), 1))])
    y = np.array([right for _, right, _ in rows], dtype=float)
    beta = np.zeros(z.shape[1])
    free = np.full(len(beta), RIDGE)
    free[-1] = 0.0
    for _ in range(STEPS):
        p = 1.0 / (1.0 + np.exp(-z @ beta))
        slope = z.T @ (weight * (y - p)) - free * beta
        bend = (z * (weight * p * (1.0 - p))[:, None]).T @ z + np.diag(free + 1e-9)
        beta = beta + np.linalg.solve(bend, slope)
    weights = beta[:-1] / spread
    return Trained(names, weights, float(beta[-1] - weights @ mean))


def trained(rows_by_set: Mapping[str, Rows], without: str = "-") -> Trained:
    """Trained on the answers of some sets; those to wishes weigh more than those to questions without positions."""
    rows = [row for name, each in rows_by_set.items() if name != without for row in each]
    weight = [OF_WISHES if name else 1.0 for name, each in rows_by_set.items() if name != without for _ in each]
    return fitted(rows, np.array(weight))


def main() -> None:
    """Report, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    least = solver.LEAST_SURE
    solver.LEAST_SURE = scoring.LEAST_SURE = 0.0
    full = model_of(None)
    reported = {name: rows_of(wishes_of(name), full) for name in REPORTED}
    hidden: dict[str, Rows] = {name: [] for name in (*REPORTED, "")}
    for seed in range(ROUNDS):
        model = model_of(seed)
        for name in REPORTED:
            hidden[name] += rows_of(wishes_of(name), model)
        for path in sorted(SETS.glob("*.json")):
            if not path.name.startswith("wishes_"):
                hidden[""] += rows_of(questions_of(path), model)
    print("left out: answers by words, right and wrong; then those below each probability, right and wrong")
    for name, rows in reported.items():
        sure, right = trained(hidden, name).probabilities(rows), np.array([each for _, each, _ in rows])
        below = (f"{t:.2f}: {right[sure < t].sum()} {(~right)[sure < t].sum()}" for t in sorted({*TOLD, least}))
        print(f"{name}: {right.sum()} {(~right).sum()}; " + ", ".join(below))
    if given.write:
        WRITTEN.write_text(json.dumps(trained(hidden).to_document(), ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
