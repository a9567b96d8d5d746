"""The whole map: geometry, trajectory and words, as it is used and as it is kept on disk."""

from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.config import GroundConfig, RoomConfig
from lpslam.errors import UserError
from lpslam.ground.grid import Grid, build_grid, build_grids
from lpslam.ground.scans import Scans, room_from_above
from lpslam.mapfile.container import read_map_file, write_map_file
from lpslam.mapfile.schema import refuse_other_camera_or_run, refuse_strangers
from lpslam.poses import StampedPoses
from lpslam.slam.map import SlamMap
from lpslam.slam.state import EventKind, SlamEvent
from lpslam.slam.trajectory import Trajectory
from lpslam.text.again.crops import CropStore
from lpslam.text.correcting.corrections import Corrections
from lpslam.text.placing.patterned import Patterns
from lpslam.text.sightings import SightingStore
from lpslam.text.text_map import TextMap
from lpslam.text.types import Landmark


@dataclass(slots=True, eq=False, weakref_slot=True)
class LanguageMap:
    """A map whose landmarks are the words in the scene.

    Attributes:
        camera: what it was made with.
        slam: keyframes and points.
        trajectory: every frame, relative to its keyframe.
        text: what was read and remembered.
        source: name of the recording.
        statistics: counts and times of the run that made it, by part.
        events: what happened to tracking and to the map in that run.
        scans: what keyframes saw, kept small; None in maps of older programs.
    """

    camera: PinholeCamera
    slam: SlamMap
    trajectory: Trajectory
    text: TextMap
    source: str = ""
    statistics: dict[str, dict[str, float]] = field(default_factory=dict)
    events: list[SlamEvent] = field(default_factory=list)
    scans: Scans | None = None

    def landmarks(self) -> list[Landmark]:
        """Every text in long-term memory, at every place where it stands, whatever its judgement.

        Texts seen only from sub-maps that were never merged have no place in the map frame and are left out.
        """
        return self.text.landmarks(self.world_from_keyframe)

    def world_from_keyframe(self, keyframe: int) -> NDArray[np.float64] | None:
        """4×4 pose of a keyframe in the map frame; None in a sub-map that was never merged."""
        return self.slam.world_from_keyframe(keyframe) if self.slam.is_home(keyframe) else None

    def frame_poses(self) -> StampedPoses:
        """Camera poses of all tracked frames in the map frame, after all corrections."""
        return StampedPoses(*self.trajectory.world_from_camera(self.slam))

    def keyframe_poses(self) -> StampedPoses:
        """Camera poses of the keyframes in the map frame."""
        living = [k for k in self.slam.living_keyframes().tolist() if self.slam.is_home(k)]
        poses = [self.slam.world_from_keyframe(keyframe) for keyframe in living]
        return StampedPoses(self.slam.timestamps()[living], np.array(poses).reshape(-1, 4, 4))

    def cloud(self) -> NDArray[np.float64]:
        """(n, 3) positions of the map points, metres, map frame."""
        return self.slam.point_positions()

    def grid(self, config: GroundConfig | None = None, height: float | None = None) -> Grid | None:
        """Ground to walk on and what stands in the way; None where no floor was seen, or nothing was kept of it.

        Args:
            config: thresholds; the defaults without.
            height: metres, at which somebody is on the storey that is wanted, of those that lie above one another; that
                on which the map ends, without.
        """
        if self.scans is None or not len(self.scans):
            return None
        _, poses = self.trajectory.world_from_camera(self.slam)
        return build_grid(self.scans, self.pose_of_scan, config or GroundConfig(), poses[:, :3, 3], height)

    def grids(self, config: GroundConfig | None = None) -> list[Grid]:
        """The ground of every storey, lowest first; none where no floor was seen, or nothing was kept of it."""
        if self.scans is None or not len(self.scans):
            return []
        _, poses = self.trajectory.world_from_camera(self.slam)
        return build_grids(self.scans, self.pose_of_scan, config or GroundConfig(), poses[:, :3, 3])

    def coloured_cloud(self) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
        """(n, 3) points of all scans, metres, map frame, and their (n, 3) red, green, blue."""
        if self.scans is None:
            return np.empty((0, 3)), np.empty((0, 3), np.uint8)
        return self.scans.cloud(self.pose_of_scan)

    def room_from_above(self, config: RoomConfig | None = None) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
        """As `coloured_cloud`, lowest first and without what a ceiling would hide the room with."""
        return room_from_above(*self.coloured_cloud(), self.frame_poses().positions, config)

    def pose_of_scan(self, keyframe: int) -> NDArray[np.float64] | None:
        """4×4 of a keyframe that the map still has."""
        is_there = 0 <= keyframe < self.slam.keyframe_count and self.slam.is_alive(keyframe)
        return self.world_from_keyframe(keyframe) if is_there else None

    def save(self, path: Path | str) -> bytes:
        """Write the map to one file, whole or not at all.

        Returns:
            What tells its content from any other map's (`identity_of`).

        Raises:
            UserError: the place cannot be written, or holds a file that is no map of a known version.
        """
        arrays: dict[str, NDArray[Any]] = {f"slam.{name}": array for name, array in self.slam.to_arrays().items()}
        arrays |= {f"trajectory.{name}": array for name, array in self.trajectory.to_arrays().items()}
        arrays |= {f"crops.{name}": array for name, array in self.text.crops.to_arrays().items()}
        pictures = self.text.sightings.to_arrays(self.text.is_remembered)
        arrays |= {f"sightings.{name}": array for name, array in pictures.items()}
        arrays |= {f"patterns.{name}": array for name, array in self.text.patterns.to_arrays().items()}
        if self.scans is not None:
            kept = [each for each in self.scans.keyframes if self.slam.is_alive(each)]
            arrays |= {f"scans.{name}": array for name, array in self.scans.to_arrays(kept).items()}
        documents = {
            "camera": asdict(self.camera),
            "text": self.text.to_document(),
            "run": {"source": self.source, "statistics": self.statistics, "events": [asdict(e) for e in self.events]},
        }
        if self.text.corrections.revision:
            documents["corrections"] = self.text.corrections.to_document()
        return write_map_file(path, documents, arrays, created=datetime.now(UTC).isoformat(timespec="seconds"))

    @classmethod
    def load(cls, path: Path | str) -> "LanguageMap":
        """Read a map.

        Raises:
            UserError: there is none, or it is damaged, or of a newer version.
        """
        contents = read_map_file(path)
        try:
            refuse_other_camera_or_run(contents.documents["camera"], contents.documents["run"])
            camera = dict(contents.documents["camera"])
            camera["distortion"] = tuple(camera["distortion"])
            run = contents.documents["run"]
            text = TextMap.from_document(contents.documents["text"])
            text.crops = CropStore.from_arrays(_part(contents.arrays, "crops."), text.config.again)
            pictures = _part(contents.arrays, "sightings.")
            text.sightings = SightingStore.from_arrays(pictures, text.config.sightings)
            text.patterns = Patterns.from_arrays(_part(contents.arrays, "patterns."))
            if "corrections" in contents.documents:
                text.corrections = Corrections.from_document(contents.documents["corrections"])
            lens = PinholeCamera(**camera)
            scans = _part(contents.arrays, "scans.")
            slam = SlamMap.from_arrays(_part(contents.arrays, "slam."))
            hung = {name: contents.arrays[name] for name in _HUNG if name in contents.arrays}
            refuse_strangers(text, slam.keyframe_count, hung)
            return cls(
                camera=lens,
                slam=slam,
                trajectory=Trajectory.from_arrays(_part(contents.arrays, "trajectory.")),
                text=text,
                source=str(run["source"]),
                statistics=dict(run["statistics"]),
                events=[SlamEvent(**{**event, "kind": EventKind(event["kind"])}) for event in run["events"]],
                scans=Scans.from_arrays(lens, scans, GroundConfig().width) if scans else None,
            )
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise UserError(f"{path} is damaged: {' '.join(str(error).split())}; map the recording again") from error


_HUNG = ("trajectory.keyframe", "scans.keyframe")
"""Columns that name keyframes of the map; words and crops name others."""


def _part(arrays: dict[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
