"""What the text map reaches: signs found, named and placed on mock malls, and plain reading of photographs.

    python benchmarks/text.py malls --cache DIR                 malls that nothing was tuned on
    python benchmarks/text.py malls --cache DIR --set dev       those to develop on
    python benchmarks/text.py malls FOLDER...                   recordings with ground truth and signs.json
    python benchmarks/text.py photographs [FOLDER]              photographs with labels.json
    python benchmarks/text.py photographed --cache DIR          walks past photographed shop fronts
    python benchmarks/text.py photographed --set test --seeds 101-106
    python benchmarks/text.py photographed FOLDER               the same of your photographs with labels.json
    python benchmarks/text.py photographed --looks 4 FOLDER     each so often, worn otherwise each time
    python benchmarks/text.py render --cache DIR [--set dev]    only the malls

A sign is expected in the map when its letters were 12 pixels high (Chinese 16), seen within 50 degrees, sharp and
uncovered, in ten frames or more. A landmark is right when its name is like the sign's (similarity 0.8) within a metre;
one on a sign that is not expected is right too, a second one on the same sign is not. Every figure comes as a line of
JSON, and all of them as a table at the end; `--out DIR` gets the lines, the maps, and pictures of every expected sign
and every wrong landmark in the frame that shows it best. Malls are rendered into the cache once.
"""

import argparse
import os
from pathlib import Path

PHOTOGRAPHS = Path(__file__).parents[2] / "shared" / "data" / "signs"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["malls", "photographs", "photographed", "render", "long"])
    parser.add_argument("folders", nargs="*", type=Path, help="recordings instead of the malls; or of photographs")
    parser.add_argument("--cache", type=Path, help="where rendered malls are kept")
    parser.add_argument(
        "--set",
        choices=["dev", "eval", "development", "test"],
        help="which malls (default eval, or development fronts)",
    )
    parser.add_argument("--seeds", help="of photographed fronts, A-B (default: all of the set)")
    parser.add_argument("--looks", type=int, default=0, help="hang every photograph so many times, each time worn anew")
    parser.add_argument("--kind", action="append", choices=["dark", "duplicates", "chinese", "protruding"])
    parser.add_argument("--processes", type=int, default=2, help="that render (default 2)")
    parser.add_argument("--live", action="store_true", help="at the camera's pace, reading beside tracking")
    parser.add_argument("--true-poses", action="store_true", help="reading and remembering alone, without SLAM")
    parser.add_argument("--minutes", type=float, default=30.0, help="of a long walk (default 30)")
    parser.add_argument("--engine", choices=["auto", "openvino", "onnxruntime"], default="auto")
    parser.add_argument("--plot", type=Path, help="picture of stated against measured, of photographed fronts")
    parser.add_argument("--out", type=Path, help="folder for results.jsonl, maps and pictures")
    given = parser.parse_intermixed_args()
    # Before numpy loads: its threads would hide processor time from what is measured.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    import cv2

    import text_fronts
    import text_long
    import text_malls
    import text_photographs
    from lpslam.config import Config
    from lpslam.slam.warm_up import warm_up
    from slam_recordings import Recording, rendered_for_text
    from slam_report import Report

    cv2.setNumThreads(1)
    config = Config.model_validate({"text": {"spotting": {"engine": given.engine}}})
    if given.what == "photographs":
        text_photographs.measure(given.folders or [PHOTOGRAPHS], config.text.spotting)
        return
    if given.what == "photographed":
        text_fronts.measure(given, config, Report(given.out), PHOTOGRAPHS)
        return
    which = "dev" if given.set in ("dev", "development") else "eval"
    if not given.folders and given.cache is None:
        parser.error("name recordings, or a folder for rendered malls: --cache DIR")
    recordings = [Recording.at(folder) for folder in given.folders]
    recordings = recordings or rendered_for_text(given.cache, which, given.kind, given.processes)
    if given.what == "render":
        return
    print(f"kernels ready in {warm_up(print):.1f} s; load average {os.getloadavg()[0]:.1f}")
    if given.what == "long":
        text_long.measure(recordings[0], given.minutes, given.live, config, Report(given.out))
        return
    how = "true poses" if given.true_poses else "live" if given.live else "in step"
    text_malls.measure(recordings, how, config, Report(given.out), given.out)


if __name__ == "__main__":
    main()
