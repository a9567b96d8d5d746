"""What SLAM reaches alone: accuracy, finding the way back, long runs, a camera's pace.

    python benchmarks/slam.py accuracy --cache DIR            malls that nothing was tuned on, and the red kitchen
    python benchmarks/slam.py accuracy FOLDER...              recordings with ground truth
    python benchmarks/slam.py recovery --cache DIR            blanked and carried elsewhere; parts not mapped yet
    python benchmarks/slam.py halves FOLDER...                one half of a recording in the map of the other
    python benchmarks/slam.py scale --cache DIR --minutes 30  around the same mall again and again
    python benchmarks/slam.py large --cache DIR               a map of 2,000 keyframes
    python benchmarks/slam.py live --cache DIR                30 frames a second, mapping beside tracking
    python benchmarks/slam.py render --cache DIR              only the recordings that the others need

Every figure comes as a line of JSON, and all of them as a table at the end; `--out DIR` gets the lines and pictures of
each trajectory over the truth. Malls are rendered into the cache once; rendering goes on where it was ended. OpenCV,
OpenMP and BLAS have one thread each, processor time is that of the thread which calls `RgbdSlam.process`, and frames
are decoded before the clock runs.
"""

import argparse
import os
from pathlib import Path

KITCHEN = Path(__file__).parents[2] / "shared" / "data" / "redkitchen"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["accuracy", "recovery", "halves", "scale", "large", "live", "render"])
    parser.add_argument("folders", nargs="*", type=Path, help="recordings with ground truth instead of the malls")
    parser.add_argument("--cache", type=Path, help="where rendered malls are kept")
    parser.add_argument("--kind", action="append", choices=["loop", "figure-eight", "dark"], help="only these malls")
    parser.add_argument("--malls", type=int, default=5, help="how many of each kind (default 5)")
    parser.add_argument("--processes", type=int, default=2, help="that render (default 2)")
    parser.add_argument("--runs", type=int, default=5, help="accuracy: runs of each recording (default 5)")
    parser.add_argument("--trials", type=int, default=20, help="recovery: random places (default 20)")
    parser.add_argument("--minutes", type=float, default=30.0, help="scale: length of the run (default 30)")
    parser.add_argument("--keyframes", type=int, default=2000, help="large: size of the map (default 2000)")
    parser.add_argument("--out", type=Path, help="folder for results.jsonl and pictures")
    given = parser.parse_intermixed_args()
    # Before numpy loads: its threads would hide processor time from the thread that is measured.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    import cv2

    import slam_accuracy
    import slam_halves
    import slam_large
    import slam_live
    import slam_recovery
    import slam_scale
    from lpslam.slam.warm_up import warm_up
    from slam_recordings import Recording, rendered
    from slam_report import Report

    cv2.setNumThreads(1)
    if not given.folders and given.cache is None:
        parser.error("name recordings, or a folder for rendered malls: --cache DIR")
    kinds = given.kind or {"recovery": ["loop"], "scale": ["loop"], "large": ["loop"]}.get(given.what)
    recordings = [Recording.at(folder) for folder in given.folders]
    if not recordings:
        recordings = rendered(given.cache, kinds, given.malls, given.processes)
        if given.what in ("accuracy", "live") and given.kind is None and KITCHEN.is_dir():
            recordings.append(Recording("redkitchen", "red kitchen", KITCHEN))
    if given.what == "render":
        return
    print(f"kernels ready in {warm_up(print):.1f} s; load average {os.getloadavg()[0]:.1f}")
    report = Report(given.out)
    match given.what:
        case "accuracy":
            slam_accuracy.measure(recordings, given.runs, report)
        case "recovery":
            slam_recovery.measure(recordings, given.trials, report)
        case "halves":
            slam_halves.measure(recordings, report)
        case "scale":
            slam_scale.measure(recordings[0], given.minutes, report)
        case "large":
            slam_large.measure(recordings, given.keyframes, report)
        case "live":
            slam_live.measure(recordings, report)


if __name__ == "__main__":
    main()
