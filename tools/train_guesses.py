"""Train what weighs how much in guesses, and how sure the embedded model is (data/wishes/guesses.json).

python tools/train_guesses.py             # report by leaving each set of wishes out
python tools/train_guesses.py --write     # train on all and write

Wishes of all sets that are answered by words are asked of whole maps and of small ones, with and without the place that
is meant. The tables were mended by nearly all sets, so their answers are surer than those of questions that nobody has
seen: all are asked once more with tables of which a part is hidden, turns of phrase sooner than words. The landmarks
are ranked by a conditional logit of their columns; the first of them, and what the tables found, are judged by a
logistic model of their clues.
"""

import argparse
import json
import os
import sys
import tempfile
import zlib
from collections import Counter
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
from lpslam.language.choosing.guessing import COLUMNS, Found, Guessing, Heard  # noqa: E402
from lpslam.language.offline import OfflineModel  # noqa: E402
from lpslam.language.signs.reader import load_sign_reader  # noqa: E402
from lpslam.language.tables import knowledge, lexicon  # noqa: E402
from lpslam.language.tables.concepts import APART, Buildings, load_associations, load_buildings  # noqa: E402
from lpslam.language.tables.lexicon import load_lexicons, split  # noqa: E402
from lpslam.language.wishes import guesses  # noqa: E402
from lpslam.language.wishes.form import Stop, Which  # noqa: E402
from lpslam.language.wishes.served import Served  # noqa: E402
from wishes import accepts, places_of  # noqa: E402

SETS = ROOT / "benchmarks" / "language"
HIDDEN_WORDS, HIDDEN_TURNS = 0.12, 0.45  # of the tables' words, and of their phrases of several words
SECTIONS = ("means", "venues", "said", "said_in_venues")
WRITTEN = Path(guesses.__file__).parent.parent / "data" / "wishes" / "guesses.json"
SMALL = (1, 2, 3, 4, 5, 6, 10)  # signs of small maps
WEIGHT = {"whole": 1.0, "small": 0.5, "without": 0.3, "everyday": 0.3}  # of an answer, by its map
EACH = 3  # of so many everyday questions one is asked
USUAL = 3.0  # landmarks of a kind that are as likely as any other, beside those that were seen
RIDGE = 30.0  # of logistic weights, in columns of spread 1
TOLD = (0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8)  # probabilities of the report

Floats = NDArray[np.float64]


def wishes_of(name: str) -> dict[str, Any]:
    """The worlds of a set of wishes."""
    worlds: dict[str, Any] = json.loads((SETS / f"wishes_{name}.json").read_text(encoding="utf-8"))["worlds"]
    return worlds


def is_kept(seed: int, phrase: str) -> bool:
    """Whether a phrase is left in the tables of a round."""
    is_turn = " " in phrase or APART in phrase or (len(phrase) > 4 and not phrase.isascii() and ord(phrase[0]) > 0x3000)
    drawn = zlib.crc32(f"{seed} {phrase}".encode()) / 2**32
    return drawn >= (HIDDEN_TURNS if is_turn else HIDDEN_WORDS)


def hiding(seed: int) -> Callable[[], dict[str, dict[str, Any]]]:
    """Lexicons of which a part is hidden."""

    def load() -> dict[str, dict[str, Any]]:
        lexicons = load_lexicons()
        for said in lexicons.values():
            for section in SECTIONS:
                said[section] = {
                    concept: "|".join(phrase for phrase in split(joined) if is_kept(seed, phrase))
                    for concept, joined in said.get(section, {}).items()
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
    # Nothing is taken from the user's cache: there the tables are whole.
    os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp()
    lexicon.load_lexicons = load_lexicons if seed is None else hiding(seed)  # type: ignore[attr-defined]
    knowledge.load_lexicons = load_lexicons if seed is None else hiding(seed)  # type: ignore[attr-defined]
    evidence.load_buildings = load_buildings if seed is None else hiding_apart(seed)  # type: ignore[attr-defined]
    evidence.load_associations = load_associations if seed is None else hiding_associations(seed)  # type: ignore[attr-defined]
    knowledge.load_knowledge.cache_clear()
    load_sign_reader.cache_clear()
    return OfflineModel()


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """One wish of one map: what was heard, what the tables found, and which landmarks are right.

    `is_told` says that only what the tables found may be the answer.
    """

    set: str
    map: str
    is_hidden: bool
    guessing: Guessing
    heard: Heard
    found: Found
    right: NDArray[np.bool_]
    is_told: bool

    def likeliest(self, rank: Floats) -> list[int]:
        """The landmarks that may be meant."""
        rows = self.guessing.likeliest(self.heard, self.found, rank)
        return rows[:1] if self.is_told else rows


class Asking:
    """Puts wishes to scorers, and keeps what they hear instead of letting them guess."""

    def rows(self, scorer: Any, stop: Stop, right: set[int], name: str, kind: str, is_hidden: bool) -> Iterator[Row]:
        """The row of a stop, if it is one to guess at."""
        kept: list[Row] = []
        asked, judge = guesses.Guesses.asked, guesses.Guesses.judged

        def noted(given: guesses.Guesses, served: Served, *args: Any) -> tuple[Heard, Found] | None:
            heard = asked(given, served, *args)
            # The parts of a refusal are asked by themselves.
            if heard is not None and served.stop.what == stop.what:
                is_right = np.isin(heard[0].ids, list(right))
                kept.append(Row(name, kind, is_hidden, given.guessing, *heard, is_right, True))
            return heard

        def judged(given: guesses.Guesses, served: Served, clues: Any, meaning: Any, language: str, _: Any) -> Served:
            if given.asked(served, clues, meaning, language) is not None and served.stop.what == stop.what:
                kept[-1] = replace(kept[-1], is_told=False)
            return served

        guesses.Guesses.asked, guesses.Guesses.judged = noted, judged  # type: ignore[method-assign, assignment]
        scorer.serve(stop)
        guesses.Guesses.asked, guesses.Guesses.judged = asked, judge  # type: ignore[method-assign]
        # What is asked last is what is answered.
        yield from [row for row in kept[-1:] if row.found.best is not None or not row.is_told]


def maps_of(world: dict[str, Any], model: OfflineModel, seed: int) -> list[tuple[Any, Any]]:
    """The places of a world dealt to small maps, with what scores them."""
    places, candidates = places_of(world)
    rng = np.random.default_rng(seed)
    order = rng.permutation(len(places)).tolist()
    maps: list[tuple[Any, Any]] = []
    while order:
        size = int(rng.choice(SMALL))
        dealt, order = order[:size], order[size:]
        maps.append(([places[at] for at in dealt], model.scorer([candidates[at] for at in dealt])))
    return maps


def of_wishes(asking: Asking, seed: int | None) -> Iterator[Row]:
    """Rows of all sets of wishes, with a part of the tables hidden unless `seed` is None."""
    model = model_of(seed)
    for path in sorted(SETS.glob("wishes_*.json")):
        name = path.stem.removeprefix("wishes_")
        for number, world in enumerate(wishes_of(name).values()):
            places, candidates = places_of(world)
            whole = (places, model.scorer(candidates))
            maps = maps_of(world, model, 1000 * (seed or 0) + number)
            for case in world["wishes"]:
                stops = model.read_wish(case["question"]).stops if case.get("category") != "plan" else ()
                if len(stops) != 1 or not stops[0].what:
                    continue
                for kind, (some, scorer) in asked_of(case, stops[0], whole, maps):
                    right = {place.id for place in some if case["expected"] and accepts(case["expected"], place)}
                    yield from asking.rows(scorer, stops[0], right, name, kind, seed is not None)


def asked_of(case: Mapping[str, Any], stop: Stop, whole: Any, maps: Sequence[Any]) -> Iterator[tuple[str, Any]]:
    """The maps that a wish is asked of: its world, and a small map with and one without what is meant."""
    yield "whole", whole
    if stop.relation is not None or stop.which is not Which.ANY or not case["expected"]:
        return
    having = [any(accepts(case["expected"], place) for place in some) for some, _ in maps]
    for kind, has in (("small", True), ("without", False)):
        yield from ((kind, each) for each in [m for m, h in zip(maps, having, strict=True) if h is has][:1])


def of_questions(asking: Asking, seed: int | None) -> Iterator[Row]:
    """Rows of everyday questions that the tables leave to guesses."""
    model = model_of(seed)
    for path in sorted(SETS.glob("*.json")):
        tree = json.loads(path.read_text(encoding="utf-8")).get("choosing")
        if not isinstance(tree, dict) or path.name.startswith("wishes_"):
            continue
        for case in tree["questions"][::EACH]:
            names = tree["places"][case["place"]] if "place" in case else case.get("landmarks", tree.get("landmarks"))
            places, candidates = places_of({"places": [{"name": name, "position": [0.0, 0.0]} for name in names]})
            stops = model.read_wish(case["question"]).stops
            if len(stops) == 1 and stops[0].what and model.choose(case["question"], candidates).landmark is None:
                right = {place.id for place in places if case["expected"] and accepts(case["expected"], place)}
                scorer = model.scorer(candidates)
                yield from asking.rows(scorer, stops[0], right, "", "everyday", seed is not None)


def ranked(rows: Sequence[Row]) -> Floats:
    """Weights of columns by which what is right comes first: a conditional logit of every wish's landmarks."""
    rows = [row for row in rows if not row.is_told and row.right.any() and not row.right.all()]
    x = np.concatenate([row.heard.columns for row in rows])
    right = np.concatenate([row.right for row in rows])
    lengths = [len(row.right) for row in rows]
    starts = np.cumsum([0, *lengths[:-1]])
    spread = x.std(axis=0) + 1e-9
    z = x / spread

    def misfit(beta: Floats) -> tuple[float, Floats]:
        score = z @ beta
        share = np.exp(score - np.repeat(np.maximum.reduceat(score, starts), lengths))
        whole, of_right = np.add.reduceat(share, starts), np.add.reduceat(share * right, starts)
        slope = share * right / np.repeat(of_right, lengths) - share / np.repeat(whole, lengths)
        return float((np.log(whole) - np.log(of_right)).sum() + beta @ beta), 2.0 * beta - z.T @ slope

    return np.asarray(minimize(misfit, np.zeros(len(COLUMNS)), jac=True, method="L-BFGS-B").x / spread)


def fitted(clues: Floats, right: NDArray[np.bool_], weight: Floats) -> Floats:
    """Weights of a logistic model of clues, the last of which stands alone."""
    mean, spread = clues.mean(axis=0), clues.std(axis=0) + 1e-6
    z = np.hstack([(clues - mean) / spread, np.ones((len(clues), 1))])
    free = np.array([RIDGE] * clues.shape[1] + [0.0])

    def misfit(beta: Floats) -> tuple[float, Floats]:
        said = z @ beta
        loss = weight @ (np.logaddexp(0.0, said) - right * said) + 0.5 * free @ (beta * beta)
        return float(loss), z.T @ (weight * (1.0 / (1.0 + np.exp(-said)) - right)) + free * beta

    beta = minimize(misfit, np.zeros(z.shape[1]), jac=True, method="L-BFGS-B").x
    weights = beta[:-1] / spread
    return np.array([*weights, beta[-1] - weights @ mean])


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """What may be meant by wishes: whose, clues, and whether it is right."""

    of: NDArray[np.int64]
    clues: Floats
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    right: NDArray[np.bool_]
    is_whole: NDArray[np.bool_]

    def usual(self, taken: NDArray[np.bool_]) -> dict[str, float]:
        """By kind, how much oftener one that may be meant is meant than others are, of the whole maps among `taken`."""
        taken = taken & self.is_whole
        seen, right = Counter[str](), Counter[str]()
        for at in np.flatnonzero(taken).tolist():
            seen[self.kinds[at]] += 1
            right[self.kinds[at]] += bool(self.right[at])
        share = float(self.right[taken].mean())
        odds = np.log(share / (1.0 - share))
        return {
            kind: float(np.log((right[kind] + USUAL * share) / (n - right[kind] + USUAL * (1.0 - share))) - odds)
            for kind, n in sorted(seen.items())
            if kind
        }

    def with_usual(self, usual: Mapping[str, float]) -> Floats:
        """The clues, and how usual each kind is."""
        return np.column_stack([self.clues, [usual.get(kind, 0.0) for kind in self.kinds]])


def judged(rows: Sequence[Row], rank: Floats) -> Judged:
    """What may be meant: what comes first, and what the tables found."""
    of, found, right, kinds = list[int](), list[dict[str, float]](), list[bool](), list[str]()
    for number, row in enumerate(rows):
        for at in row.likeliest(rank):
            of.append(number)
            found.append(row.guessing.clues(row.heard, at, rank, row.found))
            right.append(bool(row.right[at]))
            kinds.append(row.guessing.kind(row.heard, at))
    names = sorted({name for each in found for name in each})
    clues = np.array([[each.get(name, 0.0) for name in names] for each in found])
    is_whole = np.array([rows[at].map == "whole" and not rows[at].is_hidden for at in of])
    return Judged(np.array(of), clues, tuple(names), tuple(kinds), np.array(right), is_whole)


def report(rows: Sequence[Row]) -> None:
    """Print what is answered of each set that is left out."""
    total: Counter[tuple[str, float, bool]] = Counter()
    every = judged(rows, ranked(rows))
    sets, weight = np.array([row.set for row in rows])[every.of], np.array([WEIGHT[row.map] for row in rows])[every.of]
    for name in sorted({row.set for row in rows} - {""}):
        out = sets == name
        clues = every.with_usual(every.usual(~out))
        model = fitted(clues[~out], every.right[~out], weight[~out])
        sure = 1.0 / (1.0 + np.exp(-(clues[out] @ model[:-1] + model[-1])))
        best: dict[int, tuple[float, bool]] = {}
        for number, p, right in zip(every.of[out].tolist(), sure.tolist(), every.right[out].tolist(), strict=True):
            best[number] = max(best.get(number, (0.0, False)), (p, right))
        for number, (p, right) in best.items():
            row = rows[number]
            for least in (0.0, *TOLD):
                total[f"{row.map}{', hidden' if row.is_hidden else ''}", least, right] += p >= least
                if row.map == "whole":
                    total[f"{name}{', hidden' if row.is_hidden else ''}", least, right] += p >= least
    print("from each probability on: right and wrong")
    for key in sorted({key for key, _, _ in total}):
        print(key, "; ".join(f"{t:.2f}: {total[key, t, True]} {total[key, t, False]}" for t in (0.0, *TOLD)))


def main() -> None:
    """Report, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    asking = Asking()
    rows = [row for seed in (None, 0) for of in (of_wishes, of_questions) for row in of(asking, seed)]
    if not given.write:
        report(rows)
        return
    rank = ranked(rows)
    every = judged(rows, rank)
    weight = np.array([WEIGHT[row.map] for row in rows])[every.of]
    usual = every.usual(np.ones(len(every.right), bool))
    document = {
        "rank": np.round(rank, 4).tolist(),
        "names": every.names,
        "usual": {kind: round(odds, 3) for kind, odds in usual.items()},
        "weights": np.round(fitted(every.with_usual(usual), every.right, weight), 4).tolist(),
    }
    WRITTEN.write_text(json.dumps(document, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
