"""Train how sure the embedded model is that what it found is what was meant.

python tools/train_certainty.py             # report by leaving each set of wishes out
python tools/train_certainty.py --write     # train on all and write data/wishes/certainty.json

Every stop of the sets in benchmarks/language that is answered by words, and whether the answer is right. Sets of
questions without positions are among the training sets, never among those that are reported. The tables were mended by
nearly all of them, so their answers are surer than those of questions that nobody has seen. Therefore the model is
trained on answers of tables of which a part is hidden, another part each round: turns of phrase sooner than words.

A map that has just been begun has few signs. So each wish is asked of two small maps as well, drawn from its world: one
with the place that is meant, and one without, where the answer is none.
"""

import argparse
import json
import pickle
import sys
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "benchmarks"))

from lpslam.language.choosing import evidence  # noqa: E402
from lpslam.language.model import Candidate  # noqa: E402
from lpslam.language.offline import OfflineModel  # noqa: E402
from lpslam.language.signs.reader import load_sign_reader  # noqa: E402
from lpslam.language.tables import combined, knowledge  # noqa: E402
from lpslam.language.tables.concepts import APART, Buildings, load_associations, load_buildings  # noqa: E402
from lpslam.language.tables.lexicon import load_lexicons, split  # noqa: E402
from lpslam.language.wishes import certainty, scoring  # noqa: E402
from lpslam.language.wishes.form import Stop, Wish  # noqa: E402
from lpslam.language.wishes.served import UNQUESTIONED, Served  # noqa: E402
from lpslam.navigation import solver  # noqa: E402
from lpslam.navigation.places import Here, Place  # noqa: E402
from wishes import accepts, is_right, places_of  # noqa: E402

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
    "blind_seventh",
    "blind_eighth",
)
RIDGE = 1000.0  # of the weights, in columns of spread 1: few of the products of two tell anything
STEPS = 300  # of L-BFGS, more than it takes
OF_WISHES = 5.0  # what an answer to a wish weighs: there are five times as many to questions in malls
SMALL = (1, 2, 3, 4, 5, 6, 10)  # signs of small maps
OF_SMALL, OF_LEFT_OUT = 2.0, 1.0  # what an answer weighs on a small map, and on one without the place that is meant
EACH = 8  # of so many questions without positions one is asked
TOLD = (0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9)  # probabilities of the report

HIDDEN_WORDS, HIDDEN_TURNS = 0.12, 0.45  # of the tables' words, and of their phrases of several words
ROUNDS = 2
SECTIONS = ("means", "venues", "said", "said_in_venues")


@dataclass(frozen=True, slots=True)
class Row:
    """Clues of an answer, whether it is right, whether none would have been, and on which map it was given."""

    clues: dict[str, float]
    right: bool
    none: bool
    small: bool


Rows = list[Row]


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
    for case in tree["questions"][::EACH]:
        names = tree["places"][case["place"]] if "place" in case else case.get("landmarks", tree.get("landmarks"))
        key = json.dumps(names, ensure_ascii=False)
        rows = [{"name": name, "position": [0.0, 0.0]} for name in names]
        worlds.setdefault(key, {"places": rows, "wishes": []})["wishes"].append({"category": "want", **case})
    return worlds


def kept(answers: dict[Stop, Any], stop: Stop, answer: Callable[[], Any]) -> Any:
    """What was answered before, or is answered now; the last stops alone are kept."""
    if stop not in answers:
        if len(answers) > 8:
            answers.clear()
        answers[stop] = answer()
    return answers[stop]


class Asked:
    """A map of some places of a world, as wishes are put to it."""

    def __init__(self, model: OfflineModel, places: Sequence[Place], candidates: Sequence[Candidate]) -> None:
        self.places = places
        scorer = model.scorer(tuple(candidates))
        self._served: dict[Stop, Served] = {}
        self._clues: dict[Stop, dict[str, float]] = {}
        serve, clues = scorer.serve, scorer.clues
        # Asked for again and again for one wish.
        scorer.serve = lambda stop: kept(self._served, stop, lambda: serve(stop))  # type: ignore[method-assign]
        scorer.clues = lambda served: kept(self._clues, served.stop, lambda: clues(served))  # type: ignore[method-assign]
        self._scorer = scorer

    def row(self, wish: Wish, case: dict[str, Any], here: Here, small: bool) -> Row | None:
        """The row of a wish that is answered by words; None for others."""
        solution = solver.solve(wish, self.places, self._scorer, here)
        last = solution.stops[-1]
        if last.place is None or len(solution.stops) > 1 or not last.stop.what:
            return None
        served = self._scorer.serve(last.stop)
        if not served.scores or served.way in UNQUESTIONED:
            return None
        meant = any(accepts(case["expected"], place) for place in self.places) if case["expected"] else False
        return Row(self._scorer.clues(served), is_right(case, solution), not meant, small)


def small_maps(world: dict[str, Any], model: OfflineModel, seed: int) -> list[Asked]:
    """The places of a world dealt to small maps."""
    places, candidates = places_of(world)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(places)).tolist()
    maps: list[Asked] = []
    while order:
        size = int(rng.choice(SMALL))
        dealt, order = order[:size], order[size:]
        maps.append(Asked(model, [places[at] for at in dealt], [candidates[at] for at in dealt]))
    return maps


def rows_of(worlds: dict[str, Any], model: OfflineModel, seed: int | None = None) -> Rows:
    """Rows of wishes, plans apart: of their world, and of small maps that are dealt by `seed` unless it is None."""
    rows: list[Row | None] = []
    for number, world in enumerate(worlds.values()):
        whole = Asked(model, *places_of(world))
        maps = [] if seed is None else small_maps(world, model, 1000 * seed + number)
        for case in world["wishes"]:
            if case.get("category") == "plan":
                continue
            said = case.get("here", world.get("here"))
            here = Here(None if said is None else np.array([*said, 0.0][:3], dtype=float))
            wish = model.read_wish(case["question"])
            rows.append(whole.row(wish, case, here, small=False))
            if len(wish.stops) > 1 or wish.stops[0].relation is not None or not case["expected"]:
                continue
            having = [any(accepts(case["expected"], place) for place in each.places) for each in maps]
            for has in (True, False):
                drawn = next((each for each, holds in zip(maps, having, strict=True) if holds is has), None)
                rows += [drawn.row(wish, case, here, small=True)] if drawn is not None else []
    return [row for row in rows if row is not None]


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
        x = certainty.paired(np.array([[row.clues[name] for name in self.names] for row in rows]))
        return np.asarray(1.0 / (1.0 + np.exp(-(x @ self.weights + self.bias))))

    def to_document(self) -> dict[str, Any]:
        """As it is shipped."""
        return {"names": self.names, "bias": round(self.bias, 4), "weights": np.round(self.weights, 4).tolist()}


def fitted(rows: Rows, weight: NDArray[np.float64]) -> Trained:
    """Logistic regression, with columns of equal spread."""
    names = tuple(sorted(rows[0].clues))
    x = certainty.paired(np.array([[row.clues[name] for name in names] for row in rows]))
    mean, spread = x.mean(axis=0), x.std(axis=0) + 1e-6
    z = np.hstack([(x - mean) / spread, np.ones((len(x), 1))])
    y = np.array([row.right for row in rows], dtype=float)
    free = np.full(z.shape[1], RIDGE)
    free[-1] = 0.0

    def misfit(beta: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        said = z @ beta
        loss = weight @ (np.logaddexp(0.0, said) - y * said) + 0.5 * free @ (beta * beta)
        return float(loss), z.T @ (weight * (1.0 / (1.0 + np.exp(-said)) - y)) + free * beta

    beta = minimize(misfit, np.zeros(z.shape[1]), jac=True, method="L-BFGS-B", options={"maxiter": STEPS}).x
    weights = beta[:-1] / spread
    return Trained(names, weights, float(beta[-1] - weights @ mean))


def weight_of(row: Row, name: str) -> float:
    """What an answer weighs: answers to wishes more than those to questions without positions."""
    if row.small:
        return OF_LEFT_OUT if row.none else OF_SMALL
    return OF_WISHES if name else 1.0


def trained(rows_by_set: Mapping[str, Rows], without: str = "-") -> Trained:
    """Trained on the answers of some sets."""
    named = [(row, name) for name, each in rows_by_set.items() if name != without for row in each]
    return fitted([row for row, _ in named], np.array([weight_of(*each) for each in named]))


def told(rows: Rows, sure: NDArray[np.float64], least: float) -> str:
    """Answers right and wrong, then those below each probability."""
    right = np.array([row.right for row in rows])
    below = (f"{t:.2f}: {right[sure < t].sum()} {(~right)[sure < t].sum()}" for t in sorted({*TOLD, least}))
    return f"{right.sum()} {(~right).sum()}; " + ", ".join(below)


def gathered(report: Sequence[str], rounds: int) -> tuple[dict[str, Rows], dict[str, Rows]]:
    """By set, the rows of full tables, and those of tables of which a part is hidden."""
    full = model_of(None)
    reported = {name: rows_of(wishes_of(name), full, ROUNDS) for name in report}
    hidden: dict[str, Rows] = {name: [] for name in (*REPORTED, "")}
    for seed in range(rounds):
        model = model_of(seed)
        for name in REPORTED:
            hidden[name] += rows_of(wishes_of(name), model, seed)
        for path in sorted(SETS.glob("*.json")):
            if not path.name.startswith("wishes_"):
                hidden[""] += rows_of(questions_of(path), model)
        print(f"round {seed} of {rounds}", flush=True)
    return reported, hidden


def main() -> None:
    """Report, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    parser.add_argument("--rows", type=Path, help="file of the rows, made when missing")
    parser.add_argument("--report", nargs="*", choices=REPORTED, help="which sets are reported; all unless given")
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="of tables of which a part is hidden")
    given = parser.parse_args()
    least = solver.LEAST_SURE
    solver.LEAST_SURE = scoring.LEAST_SURE = 0.0
    if given.rows and given.rows.exists():
        reported, hidden = pickle.loads(given.rows.read_bytes())
    else:
        reported, hidden = gathered(given.report or REPORTED, given.rounds)
        if given.rows:
            given.rows.write_bytes(pickle.dumps((reported, hidden)))
    print("left out: answers by words, right and wrong; then those below each probability, right and wrong")
    for name, rows in reported.items():
        model = trained(hidden, name)
        for title, some in (
            ("", [row for row in rows if not row.small]),
            (", small maps", [row for row in rows if row.small and not row.none]),
            (", small maps without what is meant", [row for row in rows if row.small and row.none]),
        ):
            print(f"{name}{title}: {told(some, model.probabilities(some), least)}", flush=True)
    if given.write:
        WRITTEN.write_text(json.dumps(trained(hidden).to_document(), ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
