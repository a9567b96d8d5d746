"""What stands and moves in a place at an instant, how bright its lamps are, and what glass and mirrors show."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.scene import Scene
from lpslam.simulation.worlds.factors import World
from lpslam.simulation.worlds.glazing import Glazing, glaze, glazings_of
from lpslam.simulation.worlds.places.place import Place, Walker
from lpslam.simulation.worlds.raster import View, view_of
from lpslam.simulation.worlds.shaking import eased
from lpslam.simulation.worlds.walking import thinned, walked

DARK = 0.004  # share of the lamps' light while they are off

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """A place during one recording.

    Attributes:
        place: what is drawn.
        glazings: its glass and mirrors.
        dark: (starts, lengths) in seconds of when the lamps are off.
        walkers: who walks by.
    """

    place: Place
    glazings: tuple[Glazing, ...]
    dark: tuple[tuple[float, float], ...]
    walkers: tuple[Walker, ...]

    @classmethod
    def of(cls, place: Place, world: World, visit: int) -> "Stage":
        """A pass through a world, with everyone who might walk there."""
        rng = np.random.default_rng([world.seed, 115, visit])
        seconds = world.frames / world.fps
        times = [(float(rng.uniform(0.3, 0.5)) * seconds, float(rng.uniform(1.5, 4.0)))] if place.goes_dark else []
        return cls(place, glazings_of(place.scene, place.panes), tuple(times), place.walkers)

    def passed_through(self, camera: PinholeCamera, world_from_camera: Array, times: Array) -> "Stage":
        """The stage without those who would hide too much of the views (n, 4, 4) that a camera has at times (n,)."""
        return replace(self, walkers=thinned(self.walkers, camera, world_from_camera, times))

    @property
    def scene_without_walkers(self) -> Scene:
        """What always stands there."""
        return self.place.scene

    def lamps(self, times: Array) -> Array:
        """(m,) share of the lamps' usual light at (m,) seconds."""
        level = np.ones(len(times))
        for start, length in self.dark:
            level *= 1 - (1 - DARK) * eased(times, start, 0.08) * (1 - eased(times, start + length, 0.15))
        return level

    def view(
        self, camera: PinholeCamera, world_from_camera: Array, time: float, *, with_colour: bool = True
    ) -> tuple[View, NDArray[np.uint8]]:
        """What an ideal camera sees at a time, and where it sees it in a mirror (1) or through glass (2)."""
        scene = walked(self.place.scene, self.walkers, time)
        view = view_of(scene, camera, world_from_camera, with_colour=with_colour)
        return view, glaze(view, camera, world_from_camera, self.glazings)

    def normals(self, time: float) -> Array:
        """(faces, 3) unit vectors in the world at a time."""
        return walked(self.place.scene, self.walkers, time).normal
