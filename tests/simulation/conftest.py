from collections.abc import Iterator
from functools import cache

import pytest

from lpslam.config import SimulationConfig
from lpslam.simulation import source
from lpslam.simulation.mall import Mall, build_mall
from lpslam.simulation.source import MallSource

SMALL = SimulationConfig(loop_length=26.0)


@cache
def _small_world() -> Mall:
    return build_mall(3, SMALL)


def _built(seed: int, options: SimulationConfig) -> Mall:
    of_the_world = options.model_copy(update={"sensor_noise": True, "exposure_time": SMALL.exposure_time})
    return _small_world() if (seed, of_the_world) == (3, SMALL) else build_mall(seed, options)


@pytest.fixture(scope="session", autouse=True)
def small_world_built_once() -> Iterator[None]:
    """The world of `mall`, which is not changed, is the same for all who ask for it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(source, "build_mall", _built)
        yield


@pytest.fixture
def built_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """In this test every world is built, however often it comes."""
    monkeypatch.setattr(source, "build_mall", build_mall)


@pytest.fixture(scope="session")
def mall() -> MallSource:
    """A small world as its camera sees it."""
    return MallSource(3, options=SMALL)


@pytest.fixture(scope="session")
def ideal_mall() -> MallSource:
    """The same world and walk through a camera without noise, blur or depth errors."""
    return MallSource(3, options=SimulationConfig(loop_length=26.0, sensor_noise=False, exposure_time=0.0))
