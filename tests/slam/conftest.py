from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import settings
from rendered_walk import RenderedWalk, render

# The first call of a kernel compiles it or loads it from disk: no example may be judged by the clock.
settings.register_profile("kernels", deadline=None)
settings.load_profile("kernels")


@pytest.fixture(scope="session")
def rendered_walk(once: Callable[[str, Callable[[Path], object]], Path]) -> RenderedWalk:
    """Sixty frames of a mall with the true path."""
    return RenderedWalk(once("rendered", render))
