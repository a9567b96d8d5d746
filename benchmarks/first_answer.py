"""How much processor time `lpslam ask MAP QUESTION` takes: without a cache, and once the cache has tables and map.

Between the two: of a map that this user's `lpslam` has saved, so that its landmarks are in the cache, and no table is.
Modules are compiled beforehand, as pip leaves them, whatever this environment does.

    python benchmarks/first_answer.py                    # 400 and 10,000 boards
    python benchmarks/first_answer.py --landmarks 100000 --times 3

The map has boards with the names of the language benchmarks, each seen five times. Every question is a process of its
own; what is said is the least and the median of user and system time, as the system counts it for the whole process.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))
QUESTION = "Where is the toilet?"


def asked_map(folder: Path, landmarks: int) -> Path:
    """A map of so many boards, and beside it the cache of the user who saved it."""
    from lpslam.navigation.known import remember
    from small_maps import small_map

    tree = json.loads((ROOT / "benchmarks" / "language" / "development.json").read_text(encoding="utf-8"))
    names = [name for case in tree["judging"] for name in case["expected"]]
    path = folder / f"{landmarks}.lpmap"
    world = small_map([f"{names[at % len(names)]} {at // len(names) or ''}".strip() for at in range(landmarks)])
    identity = world.save(path)
    os.environ["XDG_CACHE_HOME"] = str(folder / "saved")
    remember(world, identity)
    return path


def seconds(map_file: Path, cache: Path) -> float:
    """Processor time of one process that asks once."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment = {**kept, "XDG_CACHE_HOME": str(cache), "PYTHONPYCACHEPREFIX": str(map_file.parent / "compiled")}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [sys.executable, "-m", "lpslam", "ask", str(map_file), QUESTION]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print one line a size of map."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--landmarks", type=int, nargs="*", default=[400, 10_000])
    parser.add_argument("--times", type=int, default=5, help="processes with the cache")
    given = parser.parse_args()
    for landmarks in given.landmarks:
        with tempfile.TemporaryDirectory() as folder:
            map_file, cache = asked_map(Path(folder), landmarks), Path(folder) / "cache"
            seconds(map_file, Path(folder) / "compiling")
            first, saved = seconds(map_file, cache), seconds(map_file, Path(folder) / "saved")
            again = [seconds(map_file, cache) for _ in range(given.times)]
        print(
            f"{landmarks:,} landmarks: {first:.2f} s without a cache, {saved:.2f} s once saved, "
            f"then {min(again):.2f} s, median {statistics.median(again):.2f} s"
        )


if __name__ == "__main__":
    main()
