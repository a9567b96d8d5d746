"""Two views of made-up points in a room, for tests of the focal length."""

import numpy as np
from scipy.spatial.transform import Rotation

from lpslam.sources.rigidity import ViewPair

WIDTH, HEIGHT, FOCAL = 640, 480, 550.0
CENTRE = ((WIDTH - 1) / 2, (HEIGHT - 1) / 2)


def pair(seed: int, degrees: float, shift: float, places: int = 60, noise: float = 1.0, wrong: float = 0.0) -> ViewPair:
    """A view, and one turned so far in some direction and shifted so many metres; a share of the places is wrong."""
    rng = np.random.default_rng(seed)
    pixels = rng.uniform((60, 60), (WIDTH - 60, HEIGHT - 60), (places, 2))
    depth = rng.uniform(1.0, 4.0, places)
    points = np.column_stack([(pixels - CENTRE) / FOCAL * depth[:, None], depth])
    axis = np.append(rng.normal(size=2), 0.3 * rng.normal())
    turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis)).as_matrix()
    direction = rng.normal(size=3)
    moved = points @ turn.T + shift * direction / np.linalg.norm(direction)
    other = moved[:, :2] / moved[:, 2:] * FOCAL + CENTRE + noise * rng.normal(0, 0.4, (places, 2))
    other += (rng.random(places) < wrong)[:, None] * rng.uniform(-80, 80, (places, 2))
    strays = noise * rng.normal(0, 1, (2, places)) * (0.003 + 0.0035 * depth**2)
    return ViewPair(pixels, depth + strays[0], other, moved[:, 2] + strays[1])
