"""Train how sure the embedded model is that what it found is what was meant.

python tools/train_certainty.py             # report by leaving each set of wishes out
python tools/train_certainty.py --write     # train on all and write data/wishes/certainty.json

Every stop of the sets in benchmarks/language that is answered by words, and whether the answer is right. Sets of questions
without positions are among the training sets, never among those that are reported. The tables were mended by nearly all of
them, so their answers are surer than those of questions that nobody has seen. Therefore the model is trained on answers of
tables of which a part is hidden, another part each round: turns of phrase sooner than words.
"""

import argparse
import json
import sys
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path.insert(0, str(ROOT / "benchmarks"))

from wishes import is_right, places_of  # noqa: E402

from lpslam.language.offline import OfflineModel  # noqa: E402
from lpslam.language.signs.reader import load_sign_reader  # noqa: E402
from lpslam.language.tables import knowledge  # noqa: E402
from lpslam.language.tables.lexicon import load_lexicons, split  # noqa: E402
from lpslam.language.wishes import certainty, scoring  # noqa: E402
from lpslam.language.wishes.served import Served, Way  # noqa: E402
from lpslam.navigation.places import Here  # noqa: E402
from lpslam.navigation.solver import solve  # noqa: E402

WRITTEN = ROOT / "src" / "lpslam" / "language" / "data" / "wishes" / "certainty.json"
SETS = ROOT / "benchmarks" / "language"
REPORTED = ("development", "own_second", "blind_first", "blind_second", "blind_third", "blind_fourth")
RIDGE = 2.0  # of the weights, as if so many answers spoke for none
STEPS = 30  # of Newton's method, far more than it takes

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
            solution = solve(model.read_wish(case["question"]), places, scorer, here)
            last = solution.stops[-1]
            if last.place is None or len(solution.stops) > 1 or not last.stop.what:
                continue
            served = scorer.serve(last.stop)
            if not served.scores or served.way in (Way.PLACE, Way.IDENTITY):
                continue
            rows.append((scorer.clues(served), is_right(case, solution), not case["expected"]))
    return rows


def hiding(seed: int) -> Callable[[], dict[str, dict[str, Any]]]:
    """Lexicons of which a part is hidden."""

    def is_kept(phrase: str) -> bool:
        is_turn = " " in phrase or (len(phrase) > 4 and not phrase.isascii() and ord(phrase[0]) > 0x3000)
        drawn = zlib.crc32(f"{seed} {phrase}".encode()) / 2**32
        return drawn >= (HIDDEN_TURNS if is_turn else HIDDEN_WORDS)

    def load() -> dict[str, dict[str, Any]]:
        lexicons = load_lexicons()
        for lexicon in lexicons.values():
            for section in SECTIONS:
                lexicon[section] = {
                    concept: "|".join(filter(is_kept, split(joined)))
                    for concept, joined in lexicon.get(section, {}).items()
                }
        return lexicons

    return load


def model_of(seed: int | None) -> OfflineModel:
    """The embedded model, with a part of its tables hidden unless `seed` is None."""
    knowledge.load_lexicons = load_lexicons if seed is None else hiding(seed)  # type: ignore[attr-defined]
    knowledge.load_knowledge.cache_clear()
    load_sign_reader.cache_clear()
    return OfflineModel()


def fitted(rows: Rows, weight: NDArray[np.float64]) -> dict[str, float]:
    """Logistic regression by Newton's method."""
    names = sorted(rows[0][0])
    x = np.array([[clues[name] for name in names] for clues, _, _ in rows])
    y = np.array([right for _, right, _ in rows], dtype=float)
    beta = np.zeros(len(names))
    free = np.array([0.0 if name == "always" else RIDGE for name in names])
    for _ in range(STEPS):
        p = 1.0 / (1.0 + np.exp(-x @ beta))
        slope = x.T @ (weight * (y - p)) - free * beta
        bend = (x * (weight * p * (1.0 - p))[:, None]).T @ x + np.diag(free + 1e-9)
        beta = beta + np.linalg.solve(bend, slope)
    return dict(zip(names, np.round(beta, 4).tolist(), strict=True))


def probabilities(rows: Rows, weights: dict[str, float]) -> NDArray[np.float64]:
    """Of each row."""
    odds = np.array([sum(weights[name] * value for name, value in clues.items()) for clues, _, _ in rows])
    return np.asarray(1.0 / (1.0 + np.exp(-odds)))


def main() -> None:
    """Report, or write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    scoring.LEAST_SURE = certainty.LEAST_SURE = 0.0
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
        json.dump({"reported": reported, "hidden": hidden}, open("/tmp/rows.json", "w"))


if __name__ == "__main__":
    main()
