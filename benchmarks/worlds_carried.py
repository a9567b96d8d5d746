"""Set down elsewhere in a world: blank frames, then another place of it, in the map that was made.

Half of the trials see frames of the same pass with new noise, half those of another pass, at another height and pace;
of either, half only localise in the map and half continue it. Frames count from the first that shows a mapped place.
With text the map is read as `lpslam run` makes it, and signs help to find the camera and to doubt where it was found.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import Config
from lpslam.frames import RgbdFrame
from lpslam.poses import StampedPoses
from lpslam.session.copying import copied
from lpslam.session.localiser import Localiser
from lpslam.session.session import Session
from lpslam.slam.map import SlamMap
from lpslam.slam.state import TrackedFrame
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from lpslam.text.reading.spotting import PaddleSpotter
from side_by_side import beside
from slam_recovery import GOOD, PATIENCE, Processor, carry, keeping_the_last
from slam_report import Report
from slam_scores import run, true_pose
from worlds_recordings import WorldRecording

MAPPED_SHARE = 0.5  # of a frame's depth readings that one keyframe has in view: its place is mapped
GRID = 12  # readings across and down of which that is asked
LIKE_DISTANCE = 2.0  # factor between the distances from which both see a point
LIKE_SIDE = 0.5  # cosine between the directions from which they do: 60 degrees apart all things look different
HIDING = 0.8  # of a point's distance: a keyframe that reads less around it sees what stands before it
COARSE = 8  # pixels across and down for each reading of a keyframe that is kept
SEEING = 8  # frames after a start in which the camera must not be blind


@dataclass(frozen=True)
class Task:
    """A world, how often the camera is set down in it, and whether signs are read."""

    recording: WorldRecording
    config: Path | None
    trials: int
    with_text: bool


@dataclass(frozen=True)
class MappedViews:
    """What a map's keyframes have in view: their true poses (n, 4, 4), how far each sees (n, h, w), and the camera."""

    camera_from_world: NDArray[np.float64]
    reach: NDArray[np.float32]
    camera: PinholeCamera

    @classmethod
    def of(
        cls,
        slam_map: SlamMap,
        truth_from_map: NDArray[np.float64],
        camera: PinholeCamera,
        reach: Mapping[float, NDArray[np.float32]],
    ) -> "MappedViews":
        """Of the living keyframes of the map proper; `reach` by their timestamps."""
        home = [int(k) for k in slam_map.living_keyframes() if slam_map.is_home(int(k))]
        poses = [inverse_transform(truth_from_map @ slam_map.world_from_keyframe(k)) for k in home]
        far = [reach[slam_map.frame_of(k)[1]] for k in home]
        return cls(np.array(poses).reshape(-1, 4, 4), np.array(far, np.float32), camera)

    def show(self, frame: RgbdFrame, world_from_camera: NDArray[np.float64]) -> bool:
        """Whether some keyframe has most of what a frame shows in view, from a like distance and side."""
        camera = self.camera
        rows = np.linspace(0, camera.height - 1, GRID).astype(int)
        columns = np.linspace(0, camera.width - 1, GRID).astype(int)
        v, u = (axis.ravel() for axis in np.meshgrid(rows, columns, indexing="ij"))
        depth = frame.depth[v, u].astype(float)
        seen = depth > 0
        if np.count_nonzero(seen) < GRID:
            return False
        pixels = camera.undistort(np.column_stack([u, v])[seen].astype(float))
        points = transform_points(world_from_camera, camera.back_project(pixels, depth[seen]))
        rays = points - world_from_camera[:3, 3]
        for pose, reach in zip(self.camera_from_world, self.reach, strict=True):
            others = points - inverse_transform(pose)[:3, 3]
            lengths = np.linalg.norm(rays, axis=1) * np.linalg.norm(others, axis=1)
            like_side = (rays * others).sum(axis=1) >= LIKE_SIDE * lengths
            x, y, z = transform_points(pose, points).T
            ahead = np.maximum(z, 1e-3)
            across, down = camera.fx * x / ahead + camera.cx, camera.fy * y / ahead + camera.cy
            inside = (z > 0.1) & (across >= 0) & (across < camera.width) & (down >= 0) & (down < camera.height)
            at = (np.column_stack([down, across])[inside] / COARSE).astype(int)
            inside[inside] = ~is_hidden(ahead[inside], reach[at[:, 0], at[:, 1]])
            ratio = ahead / depth[seen]
            if np.mean(inside & like_side & (ratio < LIKE_DISTANCE) & (ratio > 1 / LIKE_DISTANCE)) >= MAPPED_SHARE:
                return True
        return False


def reach_of(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """(h, w) the farthest reading around every eighth pixel of a depth image, metres; 0 where there is none."""
    import cv2

    around = cv2.dilate(depth, np.ones((2 * COARSE + 1, 2 * COARSE + 1), np.uint8))
    return np.asarray(around[COARSE // 2 :: COARSE, COARSE // 2 :: COARSE], np.float32)


def is_hidden(distance: NDArray[np.float64], reach: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(n,) whether all that a keyframe reads around points (n,) is nearer than they are."""
    hidden: NDArray[np.bool_] = (reach > 0) & (reach < HIDING * distance)
    return hidden


def reaching(frames: Iterable[RgbdFrame], reach: dict[float, NDArray[np.float32]]) -> Iterator[RgbdFrame]:
    """The frames; how far each sees is kept by its timestamp."""
    for frame in frames:
        reach[frame.timestamp] = reach_of(frame.depth)
        yield frame


def measure(
    recordings: Sequence[WorldRecording],
    config: Path | None,
    trials: int,
    with_text: bool,
    processes: int,
    report: Report,
) -> None:
    """Map every world, then carry the camera elsewhere in it."""
    rows: list[dict[str, Any]] = []
    for facts in beside(_carried, [Task(recording, config, trials, with_text) for recording in recordings], processes):
        for trial in facts["trials"]:
            report.line(world=facts["world"], factors=facts["factors"], **trial)
        rows.append(facts)
    headings = ["Trials", f"Found within {GOOD}", "Later", "Never", "False", "Not mapped", "Frames until found"]
    every = [trial for row in rows for trial in row["trials"]]
    table = [["all", "", *_cells(every)]]
    for name in ("visit", "grows"):
        table += [
            [name, str(value), *_cells([trial for trial in every if trial[name] == value])]
            for value in sorted({trial[name] for trial in every})
        ]
    for name in rows[0]["factors"]:
        for value in sorted({row["factors"][name] for row in rows}):
            trials_of = [trial for row in rows if row["factors"][name] == value for trial in row["trials"]]
            table.append([name, value, *_cells(trials_of)])
    print()
    report.table(["By", "", *headings], table)


def _cells(trials: Sequence[dict[str, Any]]) -> list[str]:
    verdicts = Counter(trial["verdict"] for trial in trials)
    waits = [trial["frames"] for trial in trials if trial["verdict"] in ("found", "later")]
    return [
        str(len(trials)),
        *(str(verdicts[verdict]) for verdict in ("found", "later", "never", "false", "unmapped")),
        f"{np.median(waits):.0f}, {max(waits)}" if waits else "-",
    ]


def _carried(task: Task) -> dict[str, Any]:
    import cv2

    cv2.setNumThreads(1)
    config = Config.from_yaml(task.config) if task.config else Config()
    recording, source = task.recording, task.recording.open()
    frames: list[RgbdFrame] = []
    reach: dict[float, NDArray[np.float32]] = {}
    seen = reaching(keeping_the_last(Prefetched(source), frames), reach)
    mapped = Mapped.of(seen, source.camera, config, task.with_text)
    facts: dict[str, Any] = {"world": recording.name, "factors": recording.world.factors(), "trials": []}
    if len(mapped.estimate.timestamps) < 3:
        return facts
    truth_from_map = aligned(recording.truth, mapped.estimate)
    views = MappedViews.of(mapped.slam_map, truth_from_map, source.camera, reach)
    rng = np.random.default_rng([recording.world.seed, 117])
    for trial in range(task.trials):
        visit, grows = trial % 2, trial // 2 % 2 == 0
        world = recording.source(visit)
        blind = np.convolve(world.blind, np.ones(SEEING))[SEEING - 1 :]
        starts = np.flatnonzero(blind[: max(1, len(world) - PATIENCE)] == 0)
        start = int(rng.choice(starts)) if len(starts) else 0
        verdict, waited, error = carry(
            mapped.again(grows), frames, world, start, trial + 1, truth_from_map, recording.world.fps, views.show
        )
        facts["trials"].append({
            "trial": trial, "visit": visit, "grows": grows, "start": start, "verdict": verdict, "frames": waited,
            "error_m": error,
        })  # fmt: skip
    return facts


@dataclass(frozen=True)
class Mapped:
    """A map, and how it is used again.

    Attributes:
        slam_map: its keyframes and points.
        estimate: where the camera was while it was made.
        again: the map fresh, to go on with or only to be found in; each is asked for one frame after the other.
    """

    slam_map: SlamMap
    estimate: StampedPoses
    again: Callable[[bool], Processor]

    @classmethod
    def of(cls, frames: Iterable[RgbdFrame], camera: PinholeCamera, config: Config, with_text: bool) -> "Mapped":
        """Of the frames of a camera."""
        return cls._read(frames, camera, config) if with_text else cls._unread(frames, camera, config)

    @classmethod
    def _unread(cls, frames: Iterable[RgbdFrame], camera: PinholeCamera, config: Config) -> "Mapped":
        done = run(RgbdSlam(camera, config.slam), frames)
        arrays = done.slam.map.to_arrays()

        def again(grows: bool) -> RgbdSlam:
            return RgbdSlam(camera, config.slam, base=SlamMap.from_arrays(arrays), grows=grows)

        return cls(done.slam.map, done.estimate, again)

    @classmethod
    def _read(cls, frames: Iterable[RgbdFrame], camera: PinholeCamera, config: Config) -> "Mapped":
        reader = PaddleSpotter(config.text.spotting)
        session = Session(camera, config, spotter=reader)
        for frame in frames:
            session.take(frame)
        world = session.close()

        def again(grows: bool) -> Processor:
            base = copied(world)
            if grows:
                return InSession(Session(camera, config, base=base, spotter=reader))
            return InSession(Localiser(camera, base, config, spotter=reader))

        return cls(world.slam, world.frame_poses(), again)


@dataclass(frozen=True)
class InSession:
    """Frames tracked by a session or a localiser, signs and all."""

    session: Session | Localiser

    def process(self, frame: RgbdFrame) -> TrackedFrame:
        """As `RgbdSlam.process`."""
        return self.session.take(frame).tracked


def aligned(truth: StampedPoses, estimate: StampedPoses) -> NDArray[np.float64]:
    """Truth from map (4×4) by whole poses: positions alone do not say how a camera that only turned was turned."""
    true = np.array([true_pose(truth, timestamp) for timestamp in estimate.timestamps])
    turn = np.einsum("nij,nkj->ik", true[:, :3, :3], estimate.world_from_camera[:, :3, :3])
    left, _, right = np.linalg.svd(turn)
    rotation = left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
    aligned = np.eye(4)
    aligned[:3, :3] = rotation
    aligned[:3, 3] = np.median(true[:, :3, 3] - estimate.positions @ rotation.T, axis=0)
    return aligned
