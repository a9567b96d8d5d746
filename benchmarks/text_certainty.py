"""How sure a landmark's lines are, fitted to recordings whose signs are listed: two coefficients of `boards/lines.py`.

    python benchmarks/text_certainty.py --maps DIR FOLDER[=SIGNS]...

A folder is a recording with a ground truth, and SIGNS its list (default: `signs.json` in it), as of
`text_labelled.py` or as drawn streets have it. Its map is DIR/NAME.lpmap, which is made where it is missing, and its
lines are derived by the program of now. For every recording the calibration error is given of what is stated, and of
what a fit to all others would state. Seen again in other light, a street is no other recording: name such ones
NAME and NAME-more (`street`, `street-night`), so that they are left out together.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from math import exp, log
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam import pipeline
from lpslam.config import Config
from lpslam.evaluation.report import evaluate
from lpslam.evaluation.signs import listed_signs
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.warm_up import warm_up
from lpslam.text.boards.lines import AT_EVEN, GROWTH
from slam_recordings import Recording
from text_calibration import calibration_error, error_by_chance, logistic
from text_fronts_scores import stated_and_exact
from text_labelled import boards_of, stated_and_right

LEAST = 1e-6  # of what is stated, and of what is missing to one
Array = NDArray[np.float64]
Stated = Sequence[tuple[float, bool]]


def odds_told(stated: float) -> float:
    """The log odds that a line's readings tell, of which so much is stated."""
    bounded = min(max(stated, LEAST), 1.0 - LEAST)
    return (log(bounded / (1.0 - bounded)) - AT_EVEN) / GROWTH


def fit(lines: Stated) -> tuple[float, float]:
    """AT_EVEN and GROWTH that make most probable which of some lines are right.

    Raises:
        ValueError: there are no lines.
    """
    if not lines:
        raise ValueError("there are no lines to fit to")
    terms = np.array([(1.0, odds_told(stated)) for stated, _ in lines])
    even, growth = logistic(terms, np.array([right for _, right in lines], np.float64))
    return float(even), float(growth)


def restated(lines: Stated, coefficients: tuple[float, float]) -> Array:
    """How sure the same lines would be said to be by other coefficients, (n,)."""
    even, growth = coefficients
    return np.array([1.0 / (1.0 + exp(-even - growth * odds_told(stated))) for stated, _ in lines], np.float64)


def compare(by_recording: Mapping[str, Stated]) -> tuple[float, float]:
    """Print every recording's errors, and give what is fitted to all."""
    for name, lines in by_recording.items():
        others = [each for other, some in by_recording.items() if not _is_one(name, other) for each in some]
        stated, right = (np.array(column) for column in zip(*lines, strict=True)) if lines else ((), ())
        if not len(stated) or not others:
            print(f"{name}: {len(stated)} lines, nothing to compare")
            continue
        left_out = restated(lines, fit(others))
        print(
            f"{name}: {len(lines)} lines, error {calibration_error(stated, right):.3f} as stated, "
            f"{calibration_error(left_out, right):.3f} fitted to the others, {error_by_chance(stated)[0]:.3f} by chance"
        )
    return fit([each for some in by_recording.values() for each in some])


def _is_one(name: str, other: str) -> bool:
    return name == other or other.startswith(f"{name}-") or name.startswith(f"{other}-")


def stated_of(folder: Path, signs: Path, maps: Path) -> list[tuple[float, bool]]:
    """How sure the lines of a recording's map are said to be, and which are exact."""
    recording, config, kept = Recording.at(folder), Config(), maps / f"{folder.name}.lpmap"
    if kept.exists():
        world = LanguageMap.load(kept)
    else:
        warm_up(print)
        world = pipeline.run(recording.open(), config, sequential=True)
        world.save(kept)
    pipeline.distill(world)
    scores = evaluate(world, recording.truth, [], len(recording.truth), config.evaluation)
    truth_from_map, marks = scores.ate.truth_from_estimate, world.landmarks()
    listed = json.loads(signs.read_text())
    if isinstance(listed, list) and all("board" in each for each in listed):
        return stated_and_right(boards_of(signs), marks, truth_from_map)
    return stated_and_exact(marks, listed_signs(listed, str(signs)), truth_from_map)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", metavar="FOLDER[=SIGNS]")
    parser.add_argument("--maps", type=Path, required=True, help="folder for NAME.lpmap")
    given = parser.parse_args()
    given.maps.mkdir(parents=True, exist_ok=True)
    by_recording = {}
    for each in given.recordings:
        folder, _, signs = each.partition("=")
        listed = Path(signs) if signs else Path(folder) / "signs.json"
        by_recording[Path(folder).name] = stated_of(Path(folder), listed, given.maps)
    even, growth = compare(by_recording)
    print(f"AT_EVEN, GROWTH = {even:.2f}, {growth:.2f}")


if __name__ == "__main__":
    main()
