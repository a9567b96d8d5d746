"""Renders malls for `words.py`: by day, at 0.3 of the light, and a twin in which only the words are others.

    python benchmarks/words_twins.py DIR 81 82      # day-81, dark-81, twin-81, day-82 ...

Each sign of the twin has the board, colours and size of the first mall's, and another text of the same script and of
about as many letters.
"""

import argparse
import zlib
from copy import deepcopy
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np

from lpslam.config import SimulationConfig
from lpslam.simulation import lexicon, mall
from lpslam.simulation.lettering import is_chinese, paint_board
from lpslam.simulation.source import MallSource
from lpslam.simulation.writer import write_sequence
from lpslam.text.remembering.similarity import comparison_key, similarity

FRAMES = 360
DUPLICATES = 6
UNLIKE = 0.25  # most similarity of a text with the one in its place
LIGHT = {"day": 1.0, "dark": 0.3, "twin": 1.0}


def another(line: str) -> str:
    """A text of the lexicon that says something else in about as many letters."""
    lines = [
        each
        for entry in lexicon.EVERYTHING
        for each in entry.lines("mixed")
        if is_chinese(each) == is_chinese(line) and similarity(comparison_key(each), comparison_key(line)) < UNLIKE
    ]
    nearest = min(abs(len(each) - len(line)) for each in lines)
    lines = [each for each in lines if abs(len(each) - len(line)) <= nearest + 1]
    return lines[zlib.crc32(line.encode()) % len(lines)]


def paint_another(rng: np.random.Generator, lines: tuple[str, ...], *rest: Any) -> Any:
    """As `paint_board`, with other words; chance goes on as if the first ones had been painted."""
    before = deepcopy(rng)
    paint_board(rng, lines, *rest)
    return paint_board(before, tuple(map(another, lines)), *rest)


def main() -> None:
    """Render the malls of the seeds named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("seeds", type=int, nargs="+")
    parser.add_argument("--frames", type=int, default=FRAMES)
    given = parser.parse_args()
    for seed in given.seeds:
        for name, light in LIGHT.items():
            options = SimulationConfig(light=light, duplicates=DUPLICATES)
            with patch.object(mall, "paint_board", paint_another if name == "twin" else paint_board):
                write_sequence(MallSource(seed, given.frames, options=options), given.folder / f"{name}-{seed}")


if __name__ == "__main__":
    main()
