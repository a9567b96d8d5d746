"""Score wishes: names, codes, wants, relations and plans in worlds whose places stand somewhere.

python benchmarks/wishes.py                      # the development set
python benchmarks/wishes.py FILE.json --misses   # another set, with every miss
python benchmarks/wishes.py --speed              # processor time of the first answer and of the next ones

A world is `{"places": [{"name", "lines"?, "position": [x, y], "facing"?: degrees}], "here"?: [x, y], "wishes": [...]}`,
or has two rows of names, "north" and "south", along a corridor. A wish has "question", "expected" (a name or a list of
names of which one is right; null for none; for category "plan" a list of such) and "category". "name@n" is the n-th
place of the world, from 0, where several bear a name.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here, Place
from lpslam.navigation.sites import Sites
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve

DEVELOPMENT = Path(__file__).parent / "language" / "wishes_development.json"
SPEED = {
    "a few serve": ("Where is the toilet?", "gate B31", "Starbucks", "スターバックス", "哪里可以吃饭", "room twelve"),
    "a relation": (
        "the toilet nearest to the exit",
        "on the way to the exit, is there a café?",
        "a café, not the nearest",
    ),
    "any place": ("what is next to the bank", "facing the bank, what is on the left?"),
    "a list": ("list all shops", "list all restaurants"),
    "none serves": ("frobnicator", "customer servise", "Dr. Schneider"),
}


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
    parser.add_argument("--speed", action="store_true", help="time answers in fresh processes instead")
    parser.add_argument("--time-answers", type=int, metavar="LANDMARKS", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.time_answers:
        time_answers(given.time_answers)
        return
    if given.speed:
        for landmarks in (400, 10_000, 100_000):
            subprocess.run([sys.executable, __file__, "--time-answers", str(landmarks)], check=True)
        return
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


def time_answers(landmarks: int) -> None:
    """Print the processor time from the start of this process to its first answer, and that of later ones."""
    tree = json.loads((DEVELOPMENT.parent / "development.json").read_text(encoding="utf-8"))
    names = [name for case in tree["judging"] for name in case["expected"]]
    points = np.random.default_rng(0).uniform(0.0, 1000.0, (landmarks, 2))
    marks = tuple(
        Candidate(at, f"{names[at % len(names)]} {at // len(names) or ''}".strip()) for at in range(landmarks)
    )
    south = np.array([0.0, -1.0, 0.0])
    # As a `Directory` holds them: made once, however often is asked.
    sites = Sites([Place(mark.id, mark.name, np.array([*points[mark.id], 0.0]), south) for mark in marks])
    model = OfflineModel()

    def milliseconds(question: str) -> float:
        start = time.process_time()
        solve(model.read_wish(question), sites, model.scorer(marks), Here(np.zeros(3)))
        return 1000.0 * (time.process_time() - start)

    milliseconds("Where is the toilet?")
    print(f"{landmarks} landmarks: first answer after {time.process_time():.2f} s of processor time")
    for kind, questions in SPEED.items():
        first = max(map(milliseconds, questions))
        later = [milliseconds(question) for question in questions * 3]
        print(f"  {kind}: {statistics.median(later):.0f} ms, {max(later):.0f} at most; asked first {first:.0f} at most")


if __name__ == "__main__":
    main()
