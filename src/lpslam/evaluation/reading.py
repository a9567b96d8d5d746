"""How well the lines of a photograph are read, by a reader alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from lpslam.config import EvaluationConfig
from lpslam.text.remembering.similarity import comparison_key, similarity


@dataclass(frozen=True, slots=True)
class LineScore:
    """Counts over lines and texts; add them up over photographs.

    Attributes:
        lines: that a person reads.
        found: of these, how many some text is of, however badly read.
        read: how many are read but for one letter in five.
        exact: how many are read exactly but for case and spaces.
        letters: of all lines.
        wrong_letters: that are missing or wrong.
        texts: that the reader gave.
        spurious: of these, how many are of no line.
        unread: the lines that were not read.
    """

    lines: int = 0
    found: int = 0
    read: int = 0
    exact: int = 0
    letters: int = 0
    wrong_letters: int = 0
    texts: int = 0
    spurious: int = 0
    unread: tuple[str, ...] = ()

    def __add__(self, other: "LineScore") -> "LineScore":
        return LineScore(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))


def score_lines(texts: Sequence[str], lines: Sequence[str], config: EvaluationConfig | None = None) -> LineScore:
    """Match what was read in one photograph to its lines, one to one, and count by the thresholds of `config`."""
    config = config or EvaluationConfig()
    keys, wanted = [comparison_key(text) for text in texts], [comparison_key(line) for line in lines]
    likeness = np.array([[similarity(key, line) for line in wanted] for key in keys]).reshape(len(keys), len(wanted))
    rows, columns = linear_sum_assignment(likeness, maximize=True)
    best = np.zeros(len(lines))
    best[columns] = likeness[rows, columns]
    return LineScore(
        lines=len(lines),
        found=int((best >= config.line_similarity).sum()),
        read=int((best >= config.name_similarity).sum()),
        exact=int((best == 1.0).sum()),
        letters=sum(map(len, wanted)),
        wrong_letters=sum(round((1.0 - like) * len(line)) for like, line in zip(best, wanted, strict=True)),
        texts=len(texts),
        # A second reading of a line is superfluous, not spurious.
        spurious=int((likeness.max(axis=1, initial=0.0) < config.line_similarity).sum()),
        unread=tuple(line for line, like in zip(lines, best, strict=True) if like < config.name_similarity),
    )
