"""Made-up views of boxes before a wall, by a colour camera and a depth camera beside it."""

import cv2
import numpy as np

from lpslam.frames import RgbdFrame
from lpslam.sources.registering.displacement import DepthDisplacement

WIDTH, HEIGHT = 320, 240


def boxes_before_a_wall(
    seed: int, displacement: DepthDisplacement, depth_size: tuple[int, int] = (WIDTH, HEIGHT)
) -> RgbdFrame:
    """Each box has a grey value and a depth of its own; depth shows it where the displacement says."""
    rng = np.random.default_rng(seed)
    colour = np.full((HEIGHT, WIDTH), 120.0) + rng.normal(0.0, 3.0, (HEIGHT, WIDTH))
    depth = np.full((depth_size[1], depth_size[0]), 4.0, np.float32)
    for z in sorted(rng.uniform(1.0, 3.0, 8), reverse=True):
        first = rng.uniform((0, 0), (WIDTH - 80, HEIGHT - 80))
        corners = np.array([first, first + rng.uniform(30, 80, 2)])
        (u0, v0), (u1, v1) = np.rint(corners).astype(int)
        colour[v0:v1, u0:u1] = rng.uniform(0.0, 255.0)
        # The other way round: from colour's pixels to those of depth.
        middle = (np.array([WIDTH, HEIGHT]) - 1.0) / 2.0
        back = (corners - middle - displacement.shift - np.array(displacement.parallax) / z) / displacement.scale
        (u0, v0), (u1, v1) = np.rint(back + (np.array(depth_size) - 1.0) / 2.0).astype(int).clip(0)
        depth[v0:v1, u0:u1] = z
    gray = cv2.GaussianBlur(colour.clip(0, 255).astype(np.uint8), (0, 0), 0.8)
    return RgbdFrame(seed, seed / 30, np.repeat(gray[:, :, None], 3, axis=2), depth)
