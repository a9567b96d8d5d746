"""Views of made-up points by a known lens, for tests of the adjustment."""

import numpy as np
from scipy.spatial.transform import Rotation

from lpslam.calibration.adjustment import Observations, State
from lpslam.calibration.lens import project

LENS = np.array([548.0, 549.5, 326.0, 233.0, -0.08, 0.03, 0.001, -0.0015, 0.0, 0.0])
PIXEL_SIGMA, DEPTH_SIGMA = 0.7, 0.004


def room(
    seed: int, views: int = 8, points: int = 250, noise: float = 1.0, turn: float = 0.25, readout: float = 0.0
) -> tuple[Observations, State]:
    """What a camera sees that turns in all directions by about so many radians, and the true state."""
    rng = np.random.default_rng(seed)
    lens = LENS.copy()
    lens[9] = readout
    world = np.column_stack([rng.uniform(-2.5, 2.5, points), rng.uniform(-2, 2, points), rng.uniform(1.5, 4, points)])
    poses = np.tile(np.eye(4), (views, 1, 1))
    poses[1:, :3, :3] = Rotation.from_rotvec(rng.normal(0, turn, (views - 1, 3)) * [0.6, 1.0, 0.6]).as_matrix()
    poses[1:, :3, 3] = rng.normal(0, 0.15, (views - 1, 3))
    view, point = (each.ravel() for each in np.meshgrid(np.arange(views), np.arange(points), indexing="ij"))
    moved = np.einsum("nij,nj->ni", poses[view, :3, :3], world[point]) + poses[view, :3, 3]
    drag = np.repeat(rng.normal(0, 300, (views, 2)), points, axis=0) * rng.uniform(-0.5, 0.5, len(view))[:, None]
    pixels = project(moved, lens, drag).pixels
    inside = (moved[:, 2] > 0.5) & (pixels > 0).all(axis=1) & (pixels < [640, 480]).all(axis=1)
    # What lies far outside is bent back into the image by a strong lens.
    inside &= (np.abs(moved[:, :2]) < 0.8 * moved[:, 2:]).all(axis=1)
    seen_by = np.bincount(point[inside], minlength=points)
    kept = inside & (seen_by[point] > 1)
    used, point = np.unique(point[kept], return_inverse=True)
    view, pixels, drag, depth = view[kept], pixels[kept], drag[kept], moved[kept, 2]
    pixels = pixels + noise * PIXEL_SIGMA * rng.normal(size=pixels.shape)
    inverse = 1 / depth + noise * DEPTH_SIGMA * rng.normal(size=len(depth))
    sigmas = np.full(len(view), PIXEL_SIGMA), np.full(len(view), DEPTH_SIGMA)
    return Observations(view, point, pixels, drag, inverse, *sigmas), State(lens, poses, world[used])


def disturbed(state: State, seed: int) -> State:
    """A first guess: a focal length 4 % off, no distortion, poses and points a little beside."""
    rng = np.random.default_rng(seed)
    lens = np.array([LENS[0] * 1.04, LENS[0] * 1.04, 319.5, 239.5, 0, 0, 0, 0, 0, 0])
    poses = state.camera_from_world.copy()
    poses[1:, :3, 3] += rng.normal(0, 0.01, (len(poses) - 1, 3))
    return State(lens, poses, state.points + rng.normal(0, 0.02, state.points.shape))
