"""The mock mall as one of the places."""

import numpy as np

from lpslam.config import SimulationConfig
from lpslam.simulation.mall import build_mall
from lpslam.simulation.walk import rounded
from lpslam.simulation.worlds.places.place import Place, Route, Solids, ahead

FITTINGS = 0.75  # metres off the walls within which bins, plants and signs stand


def mall(rng: np.random.Generator) -> Place:
    """A loop of shops; its walls, and what stands along them, are solid."""
    built = build_mall(int(rng.integers(10_000, 90_000)), SimulationConfig(loop_length=float(rng.uniform(26.0, 34.0))))
    layout = built.layout
    low, high = layout.outline
    path = rounded(layout.route, radius=1.3)
    if rng.random() < 0.5:
        path = path[::-1]
    points = np.column_stack([path, np.full(len(path), float(rng.uniform(1.3, 1.55)))])
    lower = layout.blocks[:, 0] - FITTINGS
    sides = layout.blocks[:, 1] - layout.blocks[:, 0] + 2 * FITTINGS
    flat, count = np.zeros((len(lower), 1)), len(lower)
    solids = Solids(
        np.array([[*(low + FITTINGS), 0.05], [*(high - FITTINGS), 2.2]]),
        np.column_stack([lower, flat]),
        np.column_stack([sides[:, 0], np.zeros((count, 2))]),
        np.column_stack([np.zeros(count), sides[:, 1], np.zeros(count)]),
        np.full(count, 3.2),
    )
    route = Route(points, ahead(points), True, 0.9, float(rng.uniform(0.5, 1.1)))
    return Place(built.scene, built.signs, route, solids)
