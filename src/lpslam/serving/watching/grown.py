"""What the page's process knows of the growing map."""

import threading
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import Config
from lpslam.ground.grid import build_grid
from lpslam.ground.scans import Scans, room_from_above
from lpslam.navigation.directory import Directory
from lpslam.navigation.known import last_view
from lpslam.page.growing import GrowingPoints
from lpslam.page.pictures import RoomPicture, picture_of
from lpslam.serving.watching.wire import Ground, Signs


@dataclass(frozen=True, slots=True, eq=False)
class KnownSoFar:
    """What an answer needs of the map (`serving.questions.Known`)."""

    name: str = ""
    version: str = "0"
    directory: Directory = field(default_factory=lambda: Directory(()))
    view: tuple[NDArray[np.float64], float] = field(default_factory=lambda: (np.zeros(3), 0.0))


class Grown:
    """The map so far; messages are taken in one thread, and pictures made in another.

    Args:
        config: thresholds of the ground, the page and questions.

    Attributes:
        known: for questions; replaced, never changed.
        room: rises whenever a scan is new, or one has moved so far that it is seen.
    """

    def __init__(self, config: Config) -> None:
        self.config = config
        self._lock = threading.Lock()
        self._scans: Scans | None = None
        self._keyframes: dict[int, NDArray[np.float64]] = {}
        self._poses: NDArray[np.float64] = np.empty((0, 4, 4))
        self._drawn: dict[int, NDArray[np.float64]] = {}
        self._points, self._sending = GrowingPoints(config.page), threading.Lock()
        self.room = 0
        self.known = KnownSoFar()

    @classmethod
    def anything(cls, config: Config) -> "Grown":
        """A room of one view, in which nothing is seen but a floor."""
        camera, grown = PinholeCamera(64, 48, 60.0, 60.0, 31.5, 23.5), cls(config)
        scans = Scans(camera, config.ground.width)
        scans.take(0, np.zeros((48, 64, 3), np.uint8), np.full((48, 64), 2.0, np.float32))
        looks_down = np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0], [0, 0, 0, 1]])
        grown.take_ground(Ground(camera, looks_down[None], {0: looks_down}, scans.to_arrays()))
        return grown

    @property
    def poses(self) -> NDArray[np.float64]:
        """(n, 4, 4) `world_from_camera`."""
        return self._poses

    def take_signs(self, signs: Signs) -> None:
        """Know the landmarks as they are now."""
        old = self.known
        directory = Directory(signs.landmarks, self.config.navigation)
        self.known = KnownSoFar("", str(int(old.version) + 1), directory, last_view(self._poses))

    def take_ground(self, ground: Ground) -> None:
        """Know the way and the scans as they are now."""
        with self._lock:
            self._poses = ground.poses
            # At the end only the way is told.
            self._keyframes = dict(ground.keyframes) or self._keyframes
            if ground.scans and len(ground.scans["keyframe"]):
                new = Scans.from_arrays(ground.camera, ground.scans, self.config.ground.width)
                if self._scans is None:
                    self._scans = new
                else:
                    self._scans.add(new)
            if self._differs():
                self._drawn, self.room = self._keyframes, self.room + 1
        self.known = KnownSoFar("", self.known.version, self.known.directory, last_view(ground.poses))

    def _differs(self) -> bool:
        """Whether a keyframe with a scan came, went, or moved by more than a pixel of the picture."""
        old, new, pixel = self._drawn, self._keyframes, self.config.page.room.growing
        if old.keys() != new.keys():
            return True
        return any(np.abs(new[each][:3, 3] - pose[:3, 3]).max() > pixel for each, pose in old.items())

    def update_points(self) -> bool:
        """Take new scans and places into the points that are sent; whether there were any."""
        with self._lock:
            scans, keyframes = None if self._scans is None else self._scans.copy(), self._keyframes
        if scans is None:
            return False
        with self._sending:
            return self._points.update(scans, keyframes)

    def points_since(self, version: int) -> bytes:
        """As `GrowingPoints.since`."""
        with self._sending:
            return self._points.since(version)

    def picture(self) -> RoomPicture | None:
        """The room from above, as far as it was seen; None before anything was."""
        with self._lock:
            if self._scans is None:
                return None
            scans, keyframes, poses = self._scans.copy(), self._keyframes, self._poses
        cloud, colours = scans.cloud(keyframes.get)
        grid = build_grid(scans, keyframes.get, self.config.ground, poses[:, :3, 3])
        # While it grows, a picture is made soon rather than small and fine.
        room = self.config.page.room
        above = room_from_above(cloud, colours, poses[:, :3, 3], room)
        return picture_of(*above, grid, room, compression=3, finest=room.growing)
