"""Recordings by other authors, whose signs are listed line by line: what the map says of them.

    python benchmarks/text_labelled.py FOLDER [--signs FILE] [--seen KEY] [--map FILE] [--out FILE]

`signs.json` is a list of lines: board, text, role (main or primary: what a person calls the board), position (world of
the ground truth), normal, height_m and seen (frames in which it can be read). A line is said where a line of the map,
or the row it stands in (`text_rows.py`), has a likeness of 0.8 within half a metre. A landmark is right if its name
says a line, or lines side by side, of a board; it is whole if all its lines do of that one board.
"""

import argparse
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam import pipeline
from lpslam.camera import transform_points
from lpslam.config import Config
from lpslam.evaluation.report import evaluate
from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.warm_up import warm_up
from lpslam.text.types import Landmark
from slam_recordings import Recording
from text_calibration import calibration_error, error_by_chance
from text_rows import RowLine, likenesses

NEAR, LIKE, SURE, SEEN = 0.5, 0.8, 0.9, 10  # metres, likeness, certainty, frames
MAIN = ("main", "primary")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Painted:
    """A board as it is listed: its lines as they stand on it, and which way its rows run."""

    name: str
    lines: list[RowLine]
    roles: list[str]
    seen: list[int]
    to_board: Array

    @classmethod
    def of(cls, name: str, listed: Sequence[Mapping[str, Any]], seen: str) -> "Painted":
        """From the entries of `signs.json`."""
        normal = np.array(listed[0]["normal"], np.float64)
        right = np.cross([0.0, 0.0, 1.0], normal)
        right /= max(float(np.linalg.norm(right)), 1e-9)
        to_board = np.array([right, np.cross(normal, right), normal])
        lines = [
            RowLine(each["text"], to_board @ np.array(each["position"]), float(each.get("height_m") or 0.0))
            for each in listed
        ]
        return cls(name, lines, [each["role"] for each in listed], [each.get(seen) or 0 for each in listed], to_board)

    def said(self, mark: Landmark, truth_from_map: Array) -> list[RowLine]:
        """A landmark's name and its lines as they stand on this board."""
        told = [(mark.name, mark.position, 0.0)]
        told += [(each.text, each.position, min(each.width, each.height)) for each in mark.lines]
        places = transform_points(truth_from_map, np.array([place for _, place, _ in told])) @ self.to_board.T
        return [RowLine(text, place, letter) for (text, _, letter), place in zip(told, places, strict=True)]


def score(boards: Sequence[Painted], marks: Sequence[Landmark], truth_from_map: Array) -> dict[str, Any]:
    """Count what is found, right and sure; what is not is printed."""
    found = dict.fromkeys(("main", "found", "exact", "called", "lines", "lines_found"), 0)
    best_of: list[tuple[int, Painted | None]] = [(0, None)] * len(marks)
    named, exact = [False] * len(marks), exact_lines(boards, marks, truth_from_map)
    for board in boards:
        likest, called = [0.0] * len(board.lines), [0.0] * len(board.lines)
        for row, mark in enumerate(marks):
            own = board.said(mark, truth_from_map)
            likest = list(map(max, likest, likenesses(board.lines, own, NEAR)))
            called = list(map(max, called, likenesses(board.lines, own[:1], 2.0 * NEAR)))
            like = likenesses(own[1:], board.lines, NEAR)
            name = max(likenesses(own[:1], board.lines, 2.0 * NEAR)[0], *_of(mark.name, mark, like), 0.0)
            named[row] = named[row] or name >= LIKE
            says = sum(one >= LIKE for one in like) if name >= LIKE else 0
            best_of[row] = max(best_of[row], (says, board), key=lambda each: each[0])
        _count(found, board, likest, called)
    whole = [
        is_named and says == len(mark.lines) for is_named, (says, _), mark in zip(named, best_of, marks, strict=True)
    ]
    for mark, is_named, is_whole in zip(marks, named, whole, strict=True):
        if not is_whole:
            lines = [(each.text, round(each.confidence, 2)) for each in mark.lines]
            print("stray" if is_named else "WRONG", repr(mark.name), round(mark.confidence, 2), lines)
    pairs = zip(marks, exact, strict=True)
    said = [(line, mark, one) for mark, own in pairs for line, one in zip(mark.lines, own, strict=True)]
    for line, mark, is_exact in said:
        if line.confidence >= SURE and not is_exact:
            print("sure, not exact", repr(line.text), round(line.confidence, 2), "of", repr(mark.name))
    stated, right = np.array([line.confidence for line, _, _ in said]), np.array([one for _, _, one in said])
    sure = right[stated >= SURE]
    return found | {
        "landmarks": len(marks),
        "right": sum(named),
        "whole": sum(whole),
        "sure": len(sure),
        "sure_exact": int(sure.sum()),
        "all_exact": f"{int(right.sum())} of {len(right)}",
        "error": round(calibration_error(stated, right), 3),
        "by_chance": error_by_chance(stated),
    }


def exact_lines(boards: Sequence[Painted], marks: Sequence[Landmark], truth_from_map: Array) -> list[list[bool]]:
    """Whether each line of each landmark is, by itself or with its row, just what some board says there."""
    exact = [[False] * len(mark.lines) for mark in marks]
    for board in boards:
        for row, mark in enumerate(marks):
            like = likenesses(board.said(mark, truth_from_map)[1:], board.lines, NEAR)
            exact[row] = [before or one >= 1.0 for before, one in zip(exact[row], like, strict=True)]
    return exact


def stated_and_right(
    boards: Sequence[Painted], marks: Sequence[Landmark], truth_from_map: Array
) -> list[tuple[float, bool]]:
    """How surely every line is said to be exact, and whether it is."""
    exact = exact_lines(boards, marks, truth_from_map)
    pairs = zip(marks, exact, strict=True)
    return [(line.confidence, one) for mark, own in pairs for line, one in zip(mark.lines, own, strict=True)]


def _of(name: str, mark: Landmark, like: Sequence[float]) -> list[float]:
    """How like the lines are that have the name in them."""
    return [one for line, one in zip(mark.lines, like, strict=True) if line.text == name]


def _count(found: dict[str, int], board: Painted, likest: Sequence[float], called: Sequence[float]) -> None:
    for line, role, seen, most, name in zip(board.lines, board.roles, board.seen, likest, called, strict=True):
        if seen < SEEN:
            continue
        found["lines"] += 1
        found["lines_found"] += most >= LIKE
        if role in MAIN:
            found["main"] += 1
            found["found"] += most >= LIKE
            found["exact"] += most >= 1.0
            found["called"] += name >= LIKE
        if most < 1.0:
            print("MISSED " if most < LIKE else "inexact", role, board.name, repr(line.text), f"seen {seen}")


def boards_of(file: Path, seen: str = "seen") -> list[Painted]:
    """The boards that a list of lines has."""
    by_board: dict[str, list[Mapping[str, Any]]] = {}
    for each in json.loads(file.read_text()):
        by_board.setdefault(str(each["board"]), []).append(each)
    return [Painted.of(name, listed, seen) for name, listed in sorted(by_board.items())]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--signs", type=Path, help="default: signs.json in the folder")
    parser.add_argument("--seen", default="seen", help="which count of the list tells how often a line can be read")
    parser.add_argument("--map", type=Path, help="a map of the recording that is there already")
    parser.add_argument("--out", type=Path, help="where its map is kept")
    given = parser.parse_args()
    recording, config = Recording.at(given.folder), Config()
    if given.map is not None:
        world = LanguageMap.load(given.map)
    else:
        print(f"kernels ready in {warm_up(print):.1f} s")
        world = pipeline.run(recording.open(), config, sequential=True)
        pipeline.distill(world)
        if given.out is not None:
            world.save(given.out)
    result = evaluate(world, recording.truth, [], len(recording.truth), config.evaluation)
    print(f"ATE {result.ate.rmse:.4f} m, {result.frames_tracked} of {len(recording.truth)} frames tracked")
    boards = boards_of(given.signs or given.folder / "signs.json", given.seen)
    print(json.dumps(score(boards, world.landmarks(), result.ate.truth_from_estimate)))


if __name__ == "__main__":
    main()
