import pytest

from lpslam.config import SimulationConfig
from lpslam.simulation.source import MallSource


@pytest.fixture(scope="session")
def mall() -> MallSource:
    """A small world as its camera sees it."""
    return MallSource(3, options=SimulationConfig(loop_length=26.0))


@pytest.fixture(scope="session")
def ideal_mall() -> MallSource:
    """The same world and walk through a camera without noise, blur or depth errors."""
    return MallSource(3, options=SimulationConfig(loop_length=26.0, sensor_noise=False, exposure_time=0.0))
