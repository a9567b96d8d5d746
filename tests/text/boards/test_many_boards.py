"""Grouping that looks only at linked pairs gives what grouping that looks at all of them gives."""

import tracemalloc
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from lpslam.config import InstanceConfig, MemoryConfig
from lpslam.text.boards import boards as module
from lpslam.text.boards import overlaps
from lpslam.text.placing.places import Place
from small_maps import small_map


def plainly(links: np.ndarray[Any, Any], divides: np.ndarray[Any, Any]) -> list[list[int]]:
    """The definition: of all pairs of groups the likeliest become one, until none is likely.

    What divides counts of pairs that were compared; the others have no number.
    """

    def score(first: list[int], second: list[int]) -> float:
        divided = divides[np.ix_(first, second)]
        compared = divided[~np.isnan(divided)]
        return float(links[np.ix_(first, second)].max() + compared.mean()) if len(compared) else -np.inf

    groups = [[each] for each in range(len(links))]
    while len(groups) > 1:
        scores = {(a, b): score(groups[a], groups[b]) for a in range(len(groups)) for b in range(a)}
        (a, b), best = max(scores.items(), key=lambda each: each[1])
        if best <= 0.0:
            break
        groups[b] += groups.pop(a)
    return sorted(sorted(group) for group in groups)


@pytest.mark.parametrize("seed", range(12))
def test_the_groups_are_those_of_the_definition(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, count = np.random.default_rng(seed), 24
    world = small_map([f"Sign {number}" for number in range(count)], spacing=0.4)
    places = [place for each in world.text.long_term for place in module_places(each, world)]
    row = {id(place): at for at, place in enumerate(places)}
    near = np.array([[module._are_near(a, b, InstanceConfig()) and a is not b for b in places] for a in places])
    assert 0 < near.sum() < count * (count - 1)
    values = np.round(rng.normal(0.0, 1.5, (count, count)), int(seed % 3))
    links = np.where(near, np.maximum(values, values.T), -np.inf)
    divides = np.where(near, np.minimum(0.0, values + values.T) / 4.0, np.nan)

    def kin(first: Any, second: Any) -> SimpleNamespace:
        a, b = row[id(first)], row[id(second)]
        return SimpleNamespace(link=float(links[a, b]), divide=float(divides[a, b]), names_apart=0.0)

    monkeypatch.setattr(module, "kinship", kin)
    found = [sorted(row[id(place)] for place in group) for group in module.boards(places, InstanceConfig())]
    assert sorted(found) == plainly(links, divides)


def module_places(text_class: Any, world: Any) -> Any:
    from lpslam.text.placing.places import places_of_class

    return places_of_class(text_class, world.world_from_keyframe, world.text.config.instances, world.text.config.memory)


def test_places_far_apart_are_not_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten thousand boards would be fifty million pairs, and two tables of as many numbers."""
    places = many_places(2_000)
    compared = []
    monkeypatch.setattr(overlaps, "overlap", lambda *pair: compared.append(pair) or 0.0)
    assert overlaps.without_overlaps(places, InstanceConfig(), MemoryConfig()) == places
    assert len(compared) < 2 * len(places)
    tracemalloc.start()
    assert [[each] for each in places] == module.boards(places, InstanceConfig())
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 10_000 * len(places)


def many_places(count: int) -> list[Place]:
    """One board copied along rows of 40, four metres apart."""
    world = small_map(["Sign"])
    (one,) = module_places(world.text.long_term[0], world)
    return [
        replace(
            one, id=each * 1000, name=f"Sign {each}", position=np.array([4.0 * (each % 40), 4.0 * (each // 40), 1.0])
        )
        for each in range(count)
    ]
