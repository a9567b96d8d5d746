"""Score wishes: names, codes, wants, relations and plans in worlds whose places stand somewhere.

python benchmarks/wishes.py                      # the development set
python benchmarks/wishes.py FILE.json --misses   # another set, with every miss

A world is `{"places": [{"name", "lines"?, "position": [x, y], "facing"?: degrees}], "here"?: [x, y], "wishes": [...]}`,
or has two rows of names, "north" and "south", along a corridor. A wish has "question", "expected" (a name or a list of
names of which one is right; null for none; for category "plan" a list of such) and "category". "name@n" is the n-th
place of the world, from 0, where several bear a name.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solver import Solution, solve

DEVELOPMENT = Path(__file__).parent / "language" / "wishes_development.json"


def places_of(world: dict[str, Any]) -> tuple[list[Place], list[Candidate]]:
    """The places of a world, and what the language layer sees of them."""
    rows: list[dict[str, Any]] = list(world.get("places", []))
    for side, y, facing in (("north", world.get("width", 0.0), -90.0), ("south", 0.0, 90.0)):
        for at, name in enumerate(world.get(side, [])):
            rows.append({"name": name, "position": [at * world["spacing"], y], "facing": facing})
    places, candidates = [], []
    for id_, row in enumerate(rows):
        facing = np.radians(row["facing"]) if row.get("facing") is not None else None
        normal = None if facing is None else np.array([np.cos(facing), np.sin(facing), 0.0])
        position = np.array([*row["position"], 0.0][:3], dtype=float)
        places.append(Place(id_, row["name"], position, normal, float(row.get("size", 0.0))))
        candidates.append(Candidate(id_, row["name"], (), tuple(row.get("lines", ()))))
    return places, candidates


def accepts(expected: Any, place: Place | None) -> bool:
    """Whether a place is one that is expected."""
    if expected is None or expected == []:
        return place is None
    names = [expected] if isinstance(expected, str) else expected
    return place is not None and any(each in (place.name, f"{place.name}@{place.id}") for each in names)


def is_right(case: dict[str, Any], solution: Solution) -> bool:
    """Whether every stop is right."""
    expected = case["expected"]
    if case["category"] == "plan" and expected is not None:
        return len(solution.stops) == len(expected) and all(
            accepts(each, stop.place) for each, stop in zip(expected, solution.stops, strict=True)
        )
    return accepts(expected, solution.stops[-1].place)


def main() -> None:
    """Print one line a category."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="?", default=DEVELOPMENT)
    parser.add_argument("--misses", action="store_true", help="show every miss")
    given = parser.parse_args()
    model = OfflineModel()
    counts: dict[str, list[int]] = defaultdict(lambda: [0, 0, 0])
    for name, world in json.loads(given.file.read_text(encoding="utf-8"))["worlds"].items():
        places, candidates = places_of(world)
        for case in world["wishes"]:
            at = case.get("here", world.get("here"))
            here = Here(None if at is None else np.array([*at, 0.0][:3], dtype=float))
            solution = solve(model.read_wish(case["question"]), places, model.scorer(candidates), here)
            right = is_right(case, solution)
            wrong = not right and any(stop.place is not None for stop in solution.stops)
            for key in (case["category"], f"in a {name}", f"language {case.get('language', '?')}", "all"):
                counts[key] = [a + b for a, b in zip(counts[key], (right, wrong, 1), strict=True)]
            if given.misses and not right:
                got = [stop.place and stop.place.name for stop in solution.stops]
                print(f"{'WRONG' if wrong else 'none '} {name}: {case['question']!r}: {got}, not {case['expected']}")
                print(f"      {solution.wish} {solution.notes}")
    for key, (right, wrong, total) in sorted(counts.items(), key=lambda each: (each[0] == "all", each[0])):
        print(f"{key}: {right}/{total} = {right / total:.1%}, wrong {wrong}")


if __name__ == "__main__":
    main()
