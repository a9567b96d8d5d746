"""Scores of a map, as JSON and as lines for the terminal."""

from dataclasses import asdict
from typing import Any

from lpslam.evaluation.landmarks import LandmarkScore
from lpslam.evaluation.report import Evaluation
from lpslam.views.drawable import printable


def score_record(scores: Evaluation) -> dict[str, Any]:
    """All scores as JSON can hold them."""
    ate = scores.ate
    return {
        "ate_rmse_m": ate.rmse,
        "ate_mean_m": ate.mean,
        "ate_median_m": ate.median,
        "ate_max_m": ate.max,
        "poses_compared": ate.count,
        "path_length_m": scores.path_length,
        "frames": scores.frames,
        "frames_mapped": scores.frames_mapped,
        "frames_tracked": scores.frames_tracked,
        "share_tracked": scores.share_tracked,
        "landmarks": None if scores.landmarks is None else asdict(scores.landmarks),
        "delays_s": scores.delays,
        "median_delay_s": scores.median_delay,
        "reading": None if scores.reading is None else asdict(scores.reading),
    }


def score_facts(scores: Evaluation) -> dict[str, str]:
    """The scores in a few lines; names from the world are made fit to be printed."""
    ate = scores.ate
    mapped = f"; the map was made of {scores.frames_mapped}" if scores.frames_mapped < scores.frames else ""
    facts = {
        "ATE RMSE": f"{ate.rmse:.4f} m (max {ate.max:.4f} m, {ate.count} poses, path {scores.path_length:.1f} m)",
        "frames tracked": f"{scores.frames_tracked} of {scores.frames} ({scores.share_tracked:.1%}){mapped}",
    }
    if (score := scores.landmarks) is not None:
        facts |= _landmark_facts(score)
    if scores.median_delay is not None:
        facts["remembered after"] = f"{scores.median_delay:.1f} s, from when it could first be read (median)"
    if (cost := scores.reading) is not None:
        facts["reading a minute"] = (
            f"{cost.detections_a_minute:.0f} images searched, {cost.recognitions_a_minute:.0f} boxes read, "
            f"{cost.reader_seconds_a_minute:.1f} s of processor time"
        )
    return facts


def _landmark_facts(score: LandmarkScore) -> dict[str, str]:
    facts = {
        "recall": f"{_percent(score.recall)} of {score.readable_signs} readable signs",
        "precision": f"{_percent(score.precision)} of {score.landmarks} landmarks",
        "exact names": _percent(score.exact_name_share),
        "names of all lines": _percent(score.whole_name_share),
        "median position error": "none matched"
        if score.median_position_error is None
        else f"{score.median_position_error:.3f} m",
        "facing right": _percent(score.facing_share),
        "duplicates apart": f"{score.duplicates_apart} of {score.duplicates} pairs" if score.duplicates else "no pairs",
        "missed": ", ".join(printable(sign.text) for sign in score.misses) or "none",
        "false or double": ", ".join(printable(stray.name) for stray in score.strays) or "none",
    }
    return facts


def _percent(share: float | None) -> str:
    return "none" if share is None else f"{share:.1%}"
