"""A world as a source of frames, drawn as it is read."""

from collections.abc import Iterator
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform
from lpslam.frames import FrameFault, RgbdFrame
from lpslam.simulation.sensor import vignette_of
from lpslam.simulation.signs import Sign
from lpslam.simulation.source import GroundTruth, as_seen
from lpslam.simulation.visibility import SignViews, views_of
from lpslam.simulation.worlds.factors import World
from lpslam.simulation.worlds.motions import Trajectory, move
from lpslam.simulation.worlds.places.building import build_place
from lpslam.simulation.worlds.places.looking import looking_at_signs
from lpslam.simulation.worlds.sensing.exposure import Sensor, exposure_gains
from lpslam.simulation.worlds.sensing.lens import Lens, row_times
from lpslam.simulation.worlds.sensing.rig import DEPTH_SCALES, DepthRig
from lpslam.simulation.worlds.sensing.surfaces import surfaces_of
from lpslam.simulation.worlds.staging import Stage

KNOTS = 9  # instants of a frame's readout at which the pose is computed; rows in between are interpolated
BLIND_COVER = 0.6  # share of the view from which on a covered camera counts as blind
BLIND_LIGHT = 0.05  # brightness of the lamps, against what they usually give, below which it counts as blind
VIEWED = 0.1  # seconds between views in which people may hide only so much
SMALL = 40  # pixels across the pictures by which the exposure is measured

Array = NDArray[np.float64]


class WorldSource:
    """A `FrameSource` that renders a world; the same world and visit give the same frames.

    Args:
        world: its factors; see `draw_world`.
        visit: which pass through that world with that camera; another begins elsewhere, at another height and pace.
    """

    def __init__(self, world: World, visit: int = 0) -> None:
        self.world = world
        self._visit = visit
        self.place = build_place(world.place, world.seed, world.light)
        route = self.place.route
        if world.motion != "robot":
            route = looking_at_signs(route, self.place.signs)
        self.trajectory: Trajectory = move(
            world.motion, world.seed, visit, route, self.place.solids, len(self) / world.fps
        )
        rng = np.random.default_rng([world.seed, 109])
        self.true_camera = _camera(world, rng)
        times = np.arange(0.0, len(self) / world.fps, VIEWED)
        self._stage = Stage.of(self.place, world, visit).passed_through(
            self.true_camera, self.trajectory.poses(times), times
        )
        self._lens = Lens.of(self.true_camera)
        self._rig = DepthRig.of(world, rng)
        vignette = vignette_of(self.true_camera, float(rng.uniform(0.05, 0.35)))
        self._sensor = Sensor(vignette, world.grain, world.shutter_time)

    @property
    def name(self) -> str:
        """The word world and the seed."""
        return self.world.name

    @cached_property
    def camera(self) -> PinholeCamera:
        """The calibration as it is stated, which in some worlds is a little wrong."""
        true, factor = self.true_camera, 1.0 + self.world.focal_error
        return PinholeCamera(
            true.width, true.height, true.fx * factor, true.fy * factor, true.cx, true.cy, true.distortion,
            true.depth_scale, true.fps,
        )  # fmt: skip

    @property
    def faults(self) -> list[FrameFault]:
        """Always empty: every frame can be drawn."""
        return []

    @cached_property
    def timestamps(self) -> Array:
        """(frames,) seconds."""
        return np.arange(len(self)) / self.world.fps

    @cached_property
    def depth_timestamps(self) -> Array:
        """(frames,) seconds as the recording states them; a hidden delay is not stated."""
        late = self.world.depth_delay if self.world.delay == "stamped" else 0.0
        return np.maximum(self.timestamps + late, 0.0)

    @cached_property
    def ground_truth(self) -> GroundTruth:
        """The true poses, in the middle of the exposure of the middle row."""
        return GroundTruth(self.timestamps, self.trajectory.poses(self.timestamps))

    @cached_property
    def blind(self) -> NDArray[np.bool_]:
        """(frames,) whether the camera sees nothing: it is covered, or the lamps are off."""
        covered = self.trajectory.covered(self.timestamps) > BLIND_COVER
        return np.asarray(covered | (self._stage.lamps(self.timestamps) < BLIND_LIGHT))

    @cached_property
    def sign_views(self) -> list[SignViews]:
        """How each sign is seen in the frames in which the camera is not blind."""
        times = self.timestamps[~self.blind]
        half = self.world.shutter_time / 2
        middle, opened, closed = (self.trajectory.poses(times + shift) for shift in (0.0, -half, half))
        scene = self._stage.scene_without_walkers
        return [views_of(sign, scene, self.true_camera, middle, opened, closed) for sign in self.place.signs]

    @cached_property
    def signs(self) -> list[Sign]:
        """All signs with the number of frames in which each is readable, and from when on."""
        times = self.timestamps[~self.blind]
        return [as_seen(sign, views, times) for sign, views in zip(self.place.signs, self.sign_views, strict=True)]

    def __len__(self) -> int:
        """Number of frames."""
        return self.world.frames

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Draw the frames in order."""
        for index in range(len(self)):
            yield self.frame(index)

    def frame(self, index: int, noise: int = 0) -> RgbdFrame:
        """Draw one frame as a recording of it is read; another `noise` is another measurement from the same place."""
        rgb, raw = self.exposed(index, noise)
        if self.world.compression == "jpeg":
            rgb = np.asarray(cv2.imdecode(np.frombuffer(self.compressed(rgb), np.uint8), cv2.IMREAD_COLOR))[..., ::-1]
        depth = raw.astype(np.float32) * np.float32(1.0 / self.camera.depth_scale)
        return RgbdFrame(index, float(self.timestamps[index]), np.ascontiguousarray(rgb), depth)

    def compressed(self, rgb: NDArray[np.uint8]) -> bytes:
        """A picture as the world's camera stores it: JPEG, or PNG without loss."""
        # Level 1 is three times as fast as the default at a tenth more size.
        suffix, options = ".png", [cv2.IMWRITE_PNG_COMPRESSION, 1]
        if self.world.compression == "jpeg":
            suffix, options = ".jpg", [cv2.IMWRITE_JPEG_QUALITY, self.world.jpeg_quality]
        return bytes(cv2.imencode(suffix, rgb[..., ::-1], options)[1].tobytes())

    def exposed(self, index: int, noise: int = 0) -> tuple[NDArray[np.uint8], NDArray[np.uint16]]:
        """(height, width, 3) colour before compression and (height, width) raw depth of one frame."""
        rng = np.random.default_rng([self.world.seed, 113, index, self._visit, noise])
        time = float(self.timestamps[index])
        cover = float(self.trajectory.covered(np.array([time]))[0])
        level = self.world.light_level * float(self._stage.lamps(np.array([time]))[0])
        world_from_camera = self.trajectory.poses(np.array([time]))[0]
        view, _ = self._stage.view(self._lens.canvas, world_from_camera, time)
        opened, closed = self._shutter(time, world_from_camera)
        light = self._lens.shoot(view.colour, view.depth, opened, closed)
        rgb = self._sensor.develop(rng, light, level, self._gains[index], cover)
        depth = self._measured(rng, time + self.world.depth_delay, world_from_camera, view.colour)
        if cover > 0:
            depth[round((1.0 - cover) * len(depth)) :] = 0
        raw = np.clip(np.rint(depth * self.camera.depth_scale), 0, 65535).astype(np.uint16)
        return rgb, raw

    def _measured(
        self, rng: np.random.Generator, time: float, world_from_canvas: Array, colour: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """What the depth sensor says of an instant, in the colour image."""
        rig = self._rig
        world_from_depth = self.trajectory.poses(np.array([time]))[0] @ rig.colour_from_depth
        view, glazing = self._stage.view(rig.camera, world_from_depth, time, with_colour=False)
        normals = self._stage.normals(time) @ world_from_depth[:3, :3]
        canvas_from_depth = inverse_transform(world_from_canvas) @ world_from_depth
        seen = surfaces_of(
            rig.camera, view, glazing, normals, self.place.scene.gloss, colour, self._lens.canvas, canvas_from_depth
        )
        return rig.measure(rng, seen, self.true_camera)

    def _shutter(self, time: float, world_from_canvas: Array) -> tuple[Array, Array]:
        """(height, 3, 4) canvas from camera for every row, when its shutter opens and when it closes."""
        height = self.true_camera.height
        knots = np.linspace(0, height - 1, KNOTS)
        times = np.interp(knots, np.arange(height), row_times(time, height, self.world.readout))
        ends = []
        for shift in (-0.5, 0.5):
            moved = inverse_transform(world_from_canvas) @ self.trajectory.poses(
                times + shift * self.world.shutter_time
            )
            # Within a frame the camera turns by a few degrees at most: rotations may be interpolated as matrices.
            flat = moved[:, :3].reshape(KNOTS, 12)
            rows = np.column_stack([np.interp(np.arange(height), knots, flat[:, i]) for i in range(12)])
            ends.append(rows.reshape(height, 3, 4))
        return ends[0], ends[1]

    @cached_property
    def _gains(self) -> Array:
        """(frames, 3) of the exposure control, which sees small pictures of all frames."""
        c = self.true_camera
        shrink = c.width / SMALL
        small = PinholeCamera(
            SMALL, round(c.height / shrink), c.fx / shrink, c.fy / shrink, c.cx / shrink, c.cy / shrink
        )
        lamps = self.world.light_level * self._stage.lamps(self.timestamps)
        bare = 1.0 - self.trajectory.covered(self.timestamps)
        grey = [
            float(self._stage.view(small, pose, time)[0].colour.mean())
            for time, pose in zip(self.timestamps.tolist(), self.ground_truth.world_from_camera, strict=True)
        ]
        rng = np.random.default_rng([self.world.seed, 111, self._visit])
        return exposure_gains(np.array(grey) * lamps * bare, rng, self.world.fps, self.world.control == "hunting")


def _camera(world: World, rng: np.random.Generator) -> PinholeCamera:
    """The colour camera as it is."""
    fx = 0.5 * world.width / float(np.tan(np.radians(world.field_of_view / 2)))
    cx, cy = (np.array([world.width, world.height]) - 1) / 2 + rng.normal(0, 0.008 * world.width, 2)
    return PinholeCamera(
        world.width, world.height, round(fx, 3), round(fx * float(rng.uniform(0.997, 1.003)), 3), round(float(cx), 3),
        round(float(cy), 3), world.distortion, DEPTH_SCALES[world.depth], world.fps,
    )  # fmt: skip
