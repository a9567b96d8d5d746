"""Scores of a language model on an example set: naming, judging and choosing (paper, Table I, Fig. 14 and 15)."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from lpslam.errors import UserError
from lpslam.language.model import Candidate, LanguageModel, Reading


@dataclass(frozen=True, slots=True)
class NamingCase:
    """Readings of one sign and every name that counts as right."""

    readings: tuple[Reading, ...]
    expected: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class JudgingCase:
    """A question and, for each name, the right answer."""

    question: str
    expected: Mapping[str, bool]


@dataclass(frozen=True, slots=True)
class ChoosingCase:
    """A question over landmarks and the names that count as right; empty where nothing there fits."""

    question: str
    landmarks: tuple[str, ...]
    expected: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LanguageCases:
    """An example set of the three uses."""

    naming: tuple[NamingCase, ...] = ()
    judging: tuple[JudgingCase, ...] = ()
    choosing: tuple[ChoosingCase, ...] = ()


@dataclass(frozen=True, slots=True)
class LanguageScore:
    """Right answers out of all, by use as (right, all), and each miss in one line."""

    model: str
    naming: tuple[int, int]
    judging: tuple[int, int]
    choosing: tuple[int, int]
    misses: tuple[str, ...]

    def __str__(self) -> str:
        """One line: "naming 2/2, judging 12/12, choosing 3/3 (offline)"."""
        uses = (("naming", self.naming), ("judging", self.judging), ("choosing", self.choosing))
        return ", ".join(f"{use} {right}/{total}" for use, (right, total) in uses) + f" ({self.model})"


def paper_cases() -> LanguageCases:
    """Return the paper's example set (`benchmarks/language/paper.json`, carried inside an installed package)."""
    packaged = files("lpslam.evaluation") / "paper.json"
    source_tree = Path(__file__).parents[3] / "benchmarks" / "language" / "paper.json"
    return read_cases(packaged if packaged.is_file() else source_tree)


def read_cases(path: Traversable) -> LanguageCases:
    """Read an example set; a file that is not one is a `UserError`."""
    try:
        tree: Any = json.loads(path.read_text(encoding="utf-8"))
        choosing = tree.get("choosing", {})
        return LanguageCases(
            tuple(
                NamingCase(tuple(Reading(*reading) for reading in case["readings"]), tuple(case["expected"]))
                for case in tree.get("naming", [])
            ),
            tuple(JudgingCase(case["question"], dict(case["expected"])) for case in tree.get("judging", [])),
            tuple(
                ChoosingCase(case["question"], _landmarks_of(case, choosing), _as_names(case["expected"]))
                for case in choosing.get("questions", [])
            ),
        )
    except OSError as error:
        raise UserError(f"example set {path} cannot be read ({error.strerror})") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"example set {path} is not one: {error!r}") from error


def _landmarks_of(case: Mapping[str, Any], choosing: Mapping[str, Any]) -> tuple[str, ...]:
    """A question's own landmarks, those of the place that it names, or those of the whole set."""
    if "place" in case:
        return tuple(choosing["places"][case["place"]])
    return tuple(case.get("landmarks", choosing.get("landmarks", [])))


def score_language(model: LanguageModel, cases: LanguageCases) -> LanguageScore:
    """Ask the model every case and count its right answers."""
    misses: list[str] = []
    naming = sum(_naming_is_right(model, case, misses) for case in cases.naming)
    judging = sum(_judging_right(model, case, misses) for case in cases.judging)
    choosing = sum(_choosing_is_right(model, case, misses) for case in cases.choosing)
    return LanguageScore(
        model.model,
        (naming, len(cases.naming)),
        (judging, sum(len(case.expected) for case in cases.judging)),
        (choosing, len(cases.choosing)),
        tuple(misses),
    )


def _naming_is_right(model: LanguageModel, case: NamingCase, misses: list[str]) -> bool:
    answer = model.name(case.readings)
    if answer.name in case.expected:
        return True
    misses.append(f"naming: {answer.name!r}, not {' or '.join(case.expected)} [{answer.evidence}]")
    return False


def _judging_right(model: LanguageModel, case: JudgingCase, misses: list[str]) -> int:
    right = 0
    names = list(case.expected)
    for name, judged in zip(names, model.judge(names, case.question), strict=True):
        if judged.answer == case.expected[name]:
            right += 1
        else:
            misses.append(f"judging {name!r}, {case.question!r}: {judged.answer} [{judged.evidence}]")
    return right


def _choosing_is_right(model: LanguageModel, case: ChoosingCase, misses: list[str]) -> bool:
    landmarks = [Candidate(id_, name) for id_, name in enumerate(case.landmarks)]
    answer = model.choose(case.question, landmarks)
    chosen = None if answer.landmark is None else case.landmarks[answer.landmark]
    if chosen in case.expected if chosen is not None else not case.expected:
        return True
    misses.append(f"choosing, {case.question!r}: {chosen!r}, not {list(case.expected)} [{answer.evidence}]")
    return False


def _as_names(expected: str | Sequence[str] | None) -> tuple[str, ...]:
    if expected is None:
        return ()
    return (expected,) if isinstance(expected, str) else tuple(expected)
