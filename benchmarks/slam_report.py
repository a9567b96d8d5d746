"""Lines of JSON, tables and pictures of the SLAM benchmark."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.evaluation.trajectory import AteResult
from lpslam.poses import StampedPoses
from lpslam.views.trajectory_plot import draw_trajectories


class Report:
    """Where results go: standard output, and a folder if there is one."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)

    def line(self, **facts: Any) -> None:
        """One result."""
        text = json.dumps(facts, ensure_ascii=False)
        print(text, flush=True)
        if self._folder is not None:
            with (self._folder / "results.jsonl").open("a", encoding="utf-8") as file:
                file.write(text + "\n")

    def table(self, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
        """All results, as Markdown."""
        for row in (headings, ["---"] * len(headings), *rows):
            print(f"| {' | '.join(row)} |", flush=True)

    def picture(self, name: str, truth: StampedPoses, estimate: StampedPoses, ate: AteResult) -> None:
        """A trajectory over the truth."""
        if self._folder is not None:
            draw_trajectories(self._folder / f"{name}.png", truth, estimate, ate, title=name)


def spread(values: Sequence[float], digits: int = 4) -> str:
    """Median and range."""
    low, middle, high = np.min(values), np.median(values), np.max(values)
    return f"{middle:.{digits}f} ({low:.{digits}f}-{high:.{digits}f})"


def across(values: Sequence[float], digits: int = 4) -> float:
    """The median, rounded for a line of JSON."""
    return round(float(np.median(values)), digits)
