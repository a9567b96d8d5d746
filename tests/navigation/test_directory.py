"""Landmarks prepared once answer as those prepared for each question, from many threads and of several maps."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from lpslam.config import NavigationConfig
from lpslam.language.offline import OfflineModel
from lpslam.navigation.asking import Answer, answer
from lpslam.navigation.directory import Directory
from lpslam.text.types import Landmark

QUESTIONS = ("Where can I eat pizza?", "哪里可以买书？", "the toilet next to Starbucks", "Starbucks", "second exit")


def marks(*names: str) -> list[Landmark]:
    return [
        Landmark(1000 * at, name, {name: 3}, np.array([2.0 * at, 0.5, 1.0]), np.array([0.0, 1.0, 0.0]),
                 0.01, 1.0, 0.3, 3, 0.9)
        for at, name in enumerate(names)
    ]  # fmt: skip


MALL = marks("Starbucks", "Pizza Hut", "新华书店", "Toilet", "EXIT 1", "Starbucks", "EXIT 2")
STATION = marks("EXIT 2", "Starbucks", "Tickets", "Pizza Express", "Toilet")
VIEW = (np.array([1.0, 2.0, 1.5]), 0.3)


def said(found: Answer) -> tuple[object, ...]:
    place = None if found.landmark is None else (found.landmark.id, found.landmark.name)
    return place, found.choice, found.distance, found.same_name, [mark.id for mark in found.alternatives], found.stops


def test_a_directory_answers_as_its_landmarks_do() -> None:
    model, known = OfflineModel(), Directory(MALL)
    for question in QUESTIONS:
        fresh = answer(question, MALL, VIEW, OfflineModel(), None, None)
        kept = answer(question, known, VIEW, model, None, None)
        assert said(kept)[:5] == said(fresh)[:5]
        assert fresh.landmark is not None
        others = answer(question, known, VIEW, model, None, None, {fresh.landmark.id})
        assert said(others)[:5] == said(answer(question, MALL, VIEW, model, None, None, {fresh.landmark.id}))[:5]
        assert others.landmark is None or others.landmark.id != fresh.landmark.id


def test_its_thresholds_are_those_of_every_question() -> None:
    model, question = OfflineModel(), "the toilet next to Starbucks"
    near, far = Directory(MALL), Directory(MALL, NavigationConfig(neighbour_reach=0.5, neighbour_gaps=0.5))
    assert answer(question, near, VIEW, model, None, None).landmark is not None
    assert answer(question, far, VIEW, model, None, None).landmark is None
    assert answer(question, far, VIEW, model, None, None, {0}).landmark is None
    alone = Directory(MALL, NavigationConfig(alternatives=0))
    assert answer("Starbucks", near, VIEW, model, None, None).alternatives
    assert not answer("Starbucks", alone, VIEW, model, None, None).alternatives


def test_threads_that_ask_two_maps_of_one_model_get_their_own_maps_answers() -> None:
    model = OfflineModel()
    known = {"mall": Directory(MALL), "station": Directory(STATION)}
    asked = [(name, question) for question in QUESTIONS for name in known] * 20
    alone = {each: said(answer(each[1], known[each[0]], VIEW, OfflineModel(), None, None))[:5] for each in set(asked)}
    with ThreadPoolExecutor(8) as pool:
        given = list(pool.map(lambda each: said(answer(each[1], known[each[0]], VIEW, model, None, None))[:5], asked))
    assert given == [alone[each] for each in asked]


def test_more_maps_than_are_kept_are_still_told_apart() -> None:
    model = OfflineModel()
    maps = [Directory(marks("Starbucks", *(f"Shop {number}" for number in range(size)))) for size in range(1, 12)]
    for known in [*maps, *maps]:
        found = answer(f"Shop {len(known.landmarks) - 2}", known, VIEW, model, None, None)
        assert found.landmark is known.landmarks[-1]
