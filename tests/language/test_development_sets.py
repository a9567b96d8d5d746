"""The embedded model on this project's own signs and questions, with floors that a change must not fall below."""

import time
from pathlib import Path

import pytest

from lpslam.evaluation.language import LanguageCases, read_cases, score_language
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel

SETS = Path(__file__).parents[2] / "benchmarks" / "language"


@pytest.fixture(scope="module")
def cases() -> LanguageCases:
    return read_cases(SETS / "development.json")


def test_the_sets_are_large_enough_to_mean_something(cases: LanguageCases) -> None:
    assert sum(len(case.expected) for case in cases.judging) >= 60
    assert len(cases.choosing) >= 60
    assert sum(not case.expected for case in cases.choosing) >= 12


@pytest.mark.parametrize("name", ["development", "second", "third", "fourth", "fifth", "sixth"])
def test_floors(model: OfflineModel, name: str) -> None:
    score = score_language(model, read_cases(SETS / f"{name}.json"))
    named, judged, chosen = (right / max(total, 1) for right, total in (score.naming, score.judging, score.choosing))
    assert named >= 0.9 or score.naming[1] == 0, score.misses
    assert judged >= 0.95 or score.judging[1] == 0, score.misses
    assert chosen >= 0.95, score.misses


def test_everyday_questions_in_seven_languages(model: OfflineModel) -> None:
    cases = read_cases(SETS / "everyday.json").choosing
    assert len(cases) >= 2900
    right = wrong = 0
    for case in cases:
        answer = model.choose(case.question, [Candidate(at, name) for at, name in enumerate(case.landmarks)])
        name = None if answer.landmark is None else case.landmarks[answer.landmark]
        is_right = name in case.expected if name is not None else not case.expected
        right, wrong = right + is_right, wrong + (name is not None and not is_right)
    assert right >= 0.88 * len(cases)
    assert wrong <= 0.07 * len(cases)


def test_names_of_rendered_signs_as_the_recogniser_reads_them(model: OfflineModel) -> None:
    groups = read_cases(SETS / "readings.json").naming
    assert len(groups) >= 60
    right = score_language(model, LanguageCases(naming=groups)).naming[0]
    commonest = sum(max(group.readings, key=lambda each: each.count).text in group.expected for group in groups)
    assert right >= 0.85 * len(groups)
    assert right > commonest, "naming is worth something"


def test_what_nothing_serves_is_answered_with_none(model: OfflineModel, cases: LanguageCases) -> None:
    unserved = [case for case in cases.choosing if not case.expected]
    score = score_language(model, LanguageCases(choosing=tuple(unserved)))
    assert score.choosing[0] >= 0.9 * len(unserved), score.misses


def test_answers_are_quick_at_hundreds_of_landmarks(model: OfflineModel, cases: LanguageCases) -> None:
    names = [name for case in cases.judging for name in case.expected]
    landmarks = [Candidate(id_, f"{names[id_ % len(names)]} {id_ // len(names) or ''}") for id_ in range(400)]
    model.choose("Where can I eat pizza?", landmarks)
    times = []
    for question in ("I'm thirsty", "我想买手机", "ピアノを買いたい", "Where is the toilet?", "Ich habe Hunger"):
        start = time.process_time()
        model.choose(question, landmarks)
        times.append(time.process_time() - start)
    assert sorted(times)[len(times) // 2] < 0.06
