"""The depth sensor beside the colour camera: where it sits, what it is, and its depth in the colour image."""

from dataclasses import dataclass
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.worlds.factors import World
from lpslam.simulation.worlds.sensing import lidar, structured
from lpslam.simulation.worlds.sensing.flight import TimeOfFlight
from lpslam.simulation.worlds.sensing.lidar import PhoneLidar
from lpslam.simulation.worlds.sensing.registration import register
from lpslam.simulation.worlds.sensing.stereo import ActiveStereo
from lpslam.simulation.worlds.sensing.structured import StructuredLight
from lpslam.simulation.worlds.sensing.surfaces import Picture, Surfaces

UPSAMPLED = 3  # times; a telephone gives its few depths as a smooth picture
DEPTH_SCALES = {"structured": 5000.0, "stereo": 1000.0, "tof": 1000.0, "lidar": 1000.0}
"""Raw units in a metre, as recordings of each kind come."""


class DepthModel(Protocol):
    """A kind of depth sensor."""

    def measure(self, rng: np.random.Generator, seen: Surfaces) -> Picture:
        """(height, width) metres, 0 where nothing is measured."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class DepthRig:
    """A depth sensor beside a colour camera.

    Attributes:
        camera: the sensor's own geometry.
        colour_from_depth: 4×4, rigid.
        model: how it errs.
        scale: factor on everything that it measures.
        beside: pixels (x, y) by which its depth lies beside the colour.
    """

    camera: PinholeCamera
    colour_from_depth: NDArray[np.float64]
    model: DepthModel
    scale: float
    beside: tuple[float, float]

    @classmethod
    def of(cls, world: World, rng: np.random.Generator) -> "DepthRig":
        """The sensor of a world."""
        camera, offset = _geometry(world, rng)
        size = (camera.width, camera.height)
        model: DepthModel
        match world.depth:
            case "structured":
                model = StructuredLight(*size, world.depth_noise, float(rng.choice([4.0, 8.0])))
            case "stereo":
                model = ActiveStereo(
                    *size, world.depth_noise, float(rng.choice([0.05, 0.095])), float(rng.uniform(6.0, 10.0))
                )
            case "tof":
                model = TimeOfFlight(rng, *size, world.depth_noise, float(rng.choice([4.5, 5.5])))
            case _:
                model = PhoneLidar(*size, world.depth_noise)
        colour_from_depth = np.eye(4)
        turn, _ = cv2.Rodrigues(rng.normal(0, 0.003, 3))
        colour_from_depth[:3, :3] = turn
        colour_from_depth[:3, 3] = [offset, *rng.normal(0, 0.001, 2)]
        return cls(camera, colour_from_depth, model, 1.0 + world.depth_scale_error, world.misregistration)

    def measure(self, rng: np.random.Generator, seen: Surfaces, colour: PinholeCamera) -> Picture:
        """Depth in the colour image, (height, width) metres, 0 where there is none."""
        depth, camera = self.scale * self.model.measure(rng, seen), self.camera
        if isinstance(self.model, PhoneLidar):
            depth, camera = _smoothly_larger(depth, camera)
        return register(depth.astype(np.float32), camera, colour, self.colour_from_depth, self.beside)


def _geometry(world: World, rng: np.random.Generator) -> tuple[PinholeCamera, float]:
    """The sensor's image, and how many metres it sits to the right of the colour camera."""
    small = world.width <= 320
    match world.depth:
        case "structured":
            width, height, focal, offset = 640, 480, structured.FOCAL, -0.025
        case "stereo":
            width, height, focal, offset = 640, 480, 385.0, -0.015
            if world.width > 640:
                width, focal = 848, 425.0
        case "tof":
            width, height, focal, offset = 512, 424, float(rng.uniform(355.0, 375.0)), 0.052
        case _:
            focal = 0.5 * lidar.WIDTH / np.tan(np.radians(world.field_of_view / 2))
            width, height, offset = lidar.WIDTH, lidar.HEIGHT, 0.008
            if world.width > 640:
                height = 160
    if small and world.depth in ("structured", "stereo"):
        width, height, focal = width // 2, height // 2, focal / 2
    centre = np.array([width - 1, height - 1]) / 2 + rng.normal(0, 0.006 * width, 2)
    return PinholeCamera(width, height, focal, focal, float(centre[0]), float(centre[1])), offset


def _smoothly_larger(depth: Picture, camera: PinholeCamera) -> tuple[Picture, PinholeCamera]:
    times = UPSAMPLED
    size = (camera.width * times, camera.height * times)
    known = cv2.resize((depth > 0).astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    large = cv2.resize(depth.astype(np.float32), size, interpolation=cv2.INTER_LINEAR)
    centre = (np.array([camera.cx, camera.cy]) + 0.5) * times - 0.5
    larger = PinholeCamera(*size, camera.fx * times, camera.fy * times, float(centre[0]), float(centre[1]))
    return np.where(known > 0.999, large, 0).astype(np.float32), larger
