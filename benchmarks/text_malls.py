"""The text map of whole recordings against their signs."""

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam import pipeline
from lpslam.config import Config, SpottingConfig
from lpslam.evaluation.landmarks import LandmarkScore
from lpslam.evaluation.report import Evaluation, evaluate
from lpslam.evaluation.signs import TrueSign, read_signs
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.text.types import Recognition
from lpslam.views.pictures import draw_language_map, draw_score_histories
from slam_recordings import Recording
from slam_report import Report
from text_pictures import draw_signs
from text_true_poses import map_with_true_poses

COUNTED = ("expected", "found", "landmarks", "right", "exact", "facing", "facings", "pairs", "apart")
"""What is added up over malls."""


class MeasuredSpotter:
    """The reader of the configuration, and the processor time that the process spent while it was at work."""

    def __init__(self, config: SpottingConfig) -> None:
        self._spotter = PaddleSpotter(config)
        self.processor_seconds = 0.0

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As `PaddleSpotter`."""
        started = time.process_time()
        found = self._spotter.detect(rgb)
        self.processor_seconds += time.process_time() - started
        return found

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        """As `PaddleSpotter`."""
        started = time.process_time()
        texts = self._spotter.recognise(rgb, boxes)
        self.processor_seconds += time.process_time() - started
        return texts


@dataclass(frozen=True)
class Mapped:
    """One recording, its map, how they compare, and the processor time of all and of reading."""

    recording: Recording
    world: LanguageMap
    signs: list[TrueSign]
    scores: Evaluation
    processor_seconds: float
    reader_seconds: float

    @property
    def landmarks(self) -> LandmarkScore:
        """The score of the landmarks."""
        if self.scores.landmarks is None:
            raise SystemExit(f"{self.recording.folder} lists no signs")
        return self.scores.landmarks


def measure(recordings: Sequence[Recording], how: str, config: Config, report: Report, out: Path | None) -> None:
    """Map every recording and compare: "in step", "live" or with "true poses"."""
    rows, every = [], []
    for recording in recordings:
        mapped = map_recording(recording, how, config)
        facts = _facts(mapped)
        every.append(facts)
        report.line(recording=recording.name, how=how, **facts, **_faults(mapped))
        rows.append(_row(recording.name, facts))
        if out is not None:
            mapped.world.save(out / f"{recording.name}.lpmap")
            draw_language_map(mapped.world, out / f"{recording.name}-map.png")
            draw_score_histories(mapped.world, out / f"{recording.name}-memory.png")
            draw_signs(out / f"{recording.name}-signs", recording, mapped.world, mapped.signs, mapped.landmarks)
    if len(every) > 1:
        rows.append(_row(f"all {len(every)}", _together(every)))
    headings = [
        *("Recording", "Recall", "Precision", "Exact", "Duplicates apart", "Position m", "Facing", "Remembered after"),
        *("Searched a min", "Read a min", "Reader s a min", "ATE m", "Dropped"),
    ]
    report.table(headings, rows)


def map_recording(recording: Recording, how: str, config: Config) -> Mapped:
    source, spotter = recording.open(), MeasuredSpotter(config.text.spotting)
    started = time.process_time()
    if how == "true poses":
        world = map_with_true_poses(source, recording.truth, config, spotter)
    else:
        world = pipeline.run(
            source,
            config,
            spotter=spotter if how == "in step" else None,
            sequential=how == "in step",
            live=how == "live",
        )
        pipeline.distill(world)
    spent = time.process_time() - started
    signs = read_signs(recording.folder) or []
    scores = evaluate(world, recording.truth, signs, len(source), config.evaluation)
    # Live, the pipeline loads a reader of its own.
    cost = scores.reading.reader_seconds if scores.reading else 0.0
    return Mapped(recording, world, signs, scores, spent, cost if how == "live" else spotter.processor_seconds)


def _facts(mapped: Mapped) -> dict[str, Any]:
    score, cost = mapped.landmarks, mapped.scores.reading
    delays = [delay for delay in mapped.scores.delays.values() if delay is not None]
    angles = [match.angle for match in score.matches if match.angle is not None]
    wholes = [match.whole for match in score.matches if match.whole is not None]
    run = mapped.world.statistics["run"]
    return {
        "frames": mapped.scores.frames,
        "tracked": mapped.scores.frames_tracked,
        "dropped": run["frames_dropped"],
        "ate_rmse_m": round(mapped.scores.ate.rmse, 4),
        "expected": score.readable_signs,
        "found": score.readable_signs - len(score.misses),
        "landmarks": score.landmarks,
        "right": len(score.matches),
        "exact": sum(match.exact for match in score.matches),
        "boards": len(wholes),
        "whole_boards": sum(wholes),
        "pairs": score.duplicates,
        "apart": score.duplicates_apart,
        "facings": len(angles),
        "facing": round((score.facing_share or 0.0) * len(angles)),
        "position_m": [round(match.distance, 3) for match in score.matches],
        "delay_s": [round(delay, 2) for delay in delays],
        "minutes": round(cost.seconds / 60.0, 3) if cost else 0.0,
        "searched": cost.detections if cost else 0,
        "boxes_read": cost.recognitions if cost else 0,
        "reader_s": round(mapped.reader_seconds, 1),
        "processor_s": round(mapped.processor_seconds, 1),
        "load_average": round(os.getloadavg()[0], 1),
    }


def _faults(mapped: Mapped) -> dict[str, Any]:
    """What is wrong, for whoever mends it."""
    score, signs = mapped.landmarks, {sign.id: sign for sign in mapped.signs}
    variants = {mark.id: mark.variants for mark in mapped.world.landmarks()}
    return {
        "missed": [f"{sign.text} ({sign.readable_frames} frames)" for sign in score.misses],
        "strays": [
            {
                "name": stray.name,
                "double_of": stray.duplicate_of,
                "likest": f"{stray.likest} ({stray.similarity:.2f}, {stray.distance:.2f} m)",
                "variants": _commonest(variants[stray.landmark]),
            }
            for stray in score.strays
        ],
        "misnamed": [
            {"name": match.name, "text": match.text, "variants": _commonest(variants[match.landmark])}
            for match in score.matches
            if not match.exact
        ],
        "incomplete": [
            f"{match.name} of {' / '.join(line.text for line in signs[match.sign].lines)}"
            for match in score.matches
            if match.whole is False
        ],
        "misplaced": [f"{match.name} {match.distance:.2f} m" for match in score.matches if match.distance > 0.1],
        "misturned": [f"{match.name} {match.angle:.0f} degrees" for match in score.matches if (match.angle or 0) > 10],
        "slow": [
            f"{signs[key].text} {'never' if delay is None else f'{delay:.1f} s'}"
            for key, delay in mapped.scores.delays.items()
            if delay is None or delay > 1.5
        ],
    }


def _commonest(variants: Any) -> dict[str, int]:
    return dict(sorted(variants.items(), key=lambda each: -each[1])[:8])


def _together(every: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """All malls as if they were one."""
    total: dict[str, Any] = {name: sum(each[name] for each in every) for name in every[0] if name in COUNTED}
    total |= {name: [value for each in every for value in each[name]] for name in ("position_m", "delay_s")}
    total |= {name: sum(each[name] for each in every) for name in ("minutes", "searched", "boxes_read", "reader_s")}
    total |= {name: sum(each[name] for each in every) for name in ("frames", "dropped")}
    return total | {"ate_rmse_m": float(np.median([each["ate_rmse_m"] for each in every]))}


def _row(name: str, facts: dict[str, Any]) -> list[str]:
    minutes = max(facts["minutes"], 1e-9)
    return [
        name,
        _share(facts["found"], facts["expected"]),
        _share(facts["right"], facts["landmarks"]),
        _share(facts["exact"], facts["right"]),
        f"{facts['apart']} of {facts['pairs']}",
        _median(facts["position_m"], 3),
        _share(facts["facing"], facts["facings"]),
        f"{_median(facts['delay_s'], 1)} s",
        f"{facts['searched'] / minutes:.0f}",
        f"{facts['boxes_read'] / minutes:.0f}",
        f"{facts['reader_s'] / minutes:.1f}",
        f"{facts['ate_rmse_m']:.4f}",
        f"{facts['dropped'] / max(facts['frames'], 1):.1%}",
    ]


def _share(part: int, whole: int) -> str:
    return f"{part / whole:.1%} of {whole}" if whole else "none"


def _median(values: Sequence[float], digits: int) -> str:
    return f"{np.median(values):.{digits}f}" if len(values) else "none"
