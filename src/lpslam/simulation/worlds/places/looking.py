"""Where someone looks who walks by signs: at one after another, as on the mall's walk."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from lpslam.simulation.signs import Sign
from lpslam.simulation.walk import STEP, gaze
from lpslam.simulation.worlds.places.place import Route

FASTEST = np.radians(40.0)  # radians a second, of a head that turns to a sign
REACH = 2.0  # metres at which what is looked at is thought to be
HIGHEST = 0.35  # radians by which one looks up


def looking_at_signs(route: Route, signs: tuple[Sign, ...]) -> Route:
    """The route with signs as targets where there are some, if it had none; else as it is."""
    if not signs or not route.is_closed or np.isfinite(route.targets).all():
        return route
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(route.points, axis=0), axis=1))])
    count = int(np.ceil(lengths[-1] / route.pace / STEP))
    places = np.linspace(0, lengths[-1], count, endpoint=False)
    positions = np.column_stack([np.interp(places, lengths, route.points[:, axis]) for axis in range(3)])
    way = np.roll(positions, -round(0.3 / route.pace / STEP), axis=0) - positions
    wanted = gaze(positions, np.unwrap(np.arctan2(way[:, 1], way[:, 0])), signs, FASTEST)
    # The pitch that the walk allows is less than a sign over a door needs.
    pitch = np.clip(1.7 * wanted[:, 1], -0.15, HIGHEST)
    directions = np.column_stack([np.cos(wanted[:, 0]), np.sin(wanted[:, 0]), np.tan(pitch)])
    targets = gaussian_filter1d(positions + REACH * directions, 0.2 / STEP, axis=0, mode="wrap")
    looked = np.column_stack([
        np.interp(lengths, places, targets[:, axis], period=float(lengths[-1])) for axis in range(3)
    ])  # fmt: skip
    return replace(route, targets=looked)
