"""What SLAM and text reach in many worlds: other sensors, motions, places and lights, each drawn from a seed.

    python benchmarks/worlds.py render  --set dev --cache DIR                    only the recordings
    python benchmarks/worlds.py run     --set dev --cache DIR --out DIR          accuracy, by factor
    python benchmarks/worlds.py run     --set dev --seeds 1-12 --starts 3 ...    some of them, from several frames on
    python benchmarks/worlds.py run     --set dev --compare FILE ...             another configuration, in ratios
    python benchmarks/worlds.py run     --set dev --text ...                     with the signs that are read
    python benchmarks/worlds.py carried --set dev --cache DIR                    blanked and set down elsewhere
    python benchmarks/worlds.py carried --set dev --text ...                     the same, with the signs that are read
    python benchmarks/worlds.py cameras --set dev --cache DIR                    found in by cameras of other kinds

Seeds count from 1 within a set; 1 to 40 show every value of every factor about equally often, what follows is drawn
freely. Worlds of `dev` are to develop on; nothing is tuned on those of `test`. Tracked is the share of frames with a
pose, in whichever sub-map, among those in which the camera sees anything. ATE is given in metres and as a share of the
path; a camera that only turns has no path worth the name, and half a metre for every radian is added. A world has
failed below 80 % tracked, or above 5 % of the path, or with a wrong loop.
"""

import argparse
import os
from pathlib import Path


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["render", "run", "carried", "cameras"])
    parser.add_argument("--set", choices=["dev", "test"], default="dev", help="which worlds (default dev)")
    parser.add_argument("--seeds", default="1-40", help="of the set, as 1-40 or 3,7,20-25 (default 1-40)")
    parser.add_argument("--cache", type=Path, required=True, help="where rendered worlds are kept")
    parser.add_argument("--processes", type=int, default=1, help="that render or run (default 1)")
    parser.add_argument("--starts", type=int, default=1, help="run: each leaves out one more frame (default 1)")
    parser.add_argument("--config", type=Path, help="run: a configuration instead of the defaults")
    parser.add_argument("--compare", type=Path, help="run: a second configuration, reported in ratios to the first")
    parser.add_argument("--text", action="store_true", help="read signs too (run: no other starts)")
    parser.add_argument("--trials", type=int, default=4, help="carried: places for each world (default 4)")
    parser.add_argument("--out", type=Path, help="folder for results.jsonl")
    given = parser.parse_args()
    # Before numpy loads: its threads would hide processor time from the thread that is measured.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    import worlds_cameras
    import worlds_carried
    import worlds_runs
    from slam_report import Report
    from worlds_recordings import numbered, rendered

    recordings = rendered(given.cache, numbered(given.set, given.seeds), given.processes)
    if given.what == "run":
        configs = [given.config, given.compare] if given.compare else [given.config]
        worlds_runs.measure(recordings, configs, given.starts, given.text, given.processes, Report(given.out))
    elif given.what == "carried":
        worlds_carried.measure(recordings, given.config, given.trials, given.text, given.processes, Report(given.out))
    elif given.what == "cameras":
        worlds_cameras.measure(recordings, given.processes, Report(given.out))


if __name__ == "__main__":
    main()
