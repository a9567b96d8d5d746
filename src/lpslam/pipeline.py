"""The three workflows of LP-SLAM (paper, Fig. 1): runtime text mapping, distilling, navigation."""

import time
from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lpslam.config import Config, ReadingConfig, SpottingConfig
from lpslam.errors import UserError
from lpslam.frames import FrameSource
from lpslam.language.beside import NamingBeside
from lpslam.language.distrust import choose_trusted
from lpslam.language.model import Candidate, Choice, LanguageModel
from lpslam.language.offline import OfflineModel
from lpslam.mapfile.compatibility import refuse_other_camera
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.priority import READING, yield_to_others
from lpslam.slam.advice import NO_ADVICE, LoopAdvisor
from lpslam.slam.state import SlamEvent, TrackedFrame, TrackingState
from lpslam.slam.system import RgbdSlam
from lpslam.sources.in_order import InOrder
from lpslam.sources.pacing import Paced
from lpslam.sources.prefetch import Prefetched
from lpslam.text.advice.advising import TextAdvisor
from lpslam.text.again.looking import look_again
from lpslam.text.distilling import DEFAULT_QUESTION, distil
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.reading_thread import ReadingThread
from lpslam.text.reading.spotting import PaddleSpotter, TextSpotter
from lpslam.text.reading.spotting_process import SpottingProcess
from lpslam.text.text_map import TextMap
from lpslam.text.types import Landmark


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a run stands after a frame."""

    frame: TrackedFrame
    frames: int
    frames_per_second: float
    keyframes: int
    landmarks: int


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """Where to go, and why.

    Attributes:
        question: as asked.
        landmark: the place; None when nothing in the map serves.
        distance: metres from where the question was asked; None without a landmark.
        choice: what the language model said.
        alternatives: next best, best first.
        here: (3,) map frame, where the question was asked.
        heading: radians counter-clockwise from the map's x axis, which way the asker looks; None where that is unknown.
        same_name: places of the landmark's name, of which it is the nearest.
    """

    question: str
    landmark: Landmark | None
    distance: float | None
    choice: Choice
    alternatives: tuple[Landmark, ...] = ()
    here: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    heading: float | None = None
    same_name: int = 0

    def distance_to(self, landmark: Landmark) -> float:
        """Metres from where the question was asked."""
        return float(np.linalg.norm(landmark.position - self.here))

    def direction_to(self, landmark: Landmark) -> float:
        """Degrees counter-clockwise, in [0, 360), from where the asker looks or, unknown, from the map's x axis."""
        x, y, _ = landmark.position - self.here
        return float(np.degrees(np.arctan2(y, x) - (self.heading or 0.0)) % 360.0)


@dataclass(frozen=True, slots=True, eq=False)
class Localised:
    """Where the camera was in a saved map.

    Attributes:
        poses: of the frames that were found, in the map's frame.
        frames: how many were tried.
        events: what happened to tracking.
        seconds_tracking: of processor and waiting time, without reading.
    """

    poses: StampedPoses
    frames: int
    events: list[SlamEvent]
    seconds_tracking: float


def run(
    source: FrameSource,
    config: Config | None = None,
    *,
    language: LanguageModel | None = None,
    spotter: TextSpotter | None = None,
    text: bool = True,
    sequential: bool = True,
    live: bool = False,
    base: LanguageMap | None = None,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> LanguageMap:
    """Runtime text mapping: frame → track → read → class → memory → name → position.

    Args:
        source: RGB-D frames in order of time.
        config: thresholds; defaults without.
        language: names classes of misread strings; the embedded model without. Mapping never waits for another: the
            embedded model names at once, and the other's name takes its place when it comes.
        spotter: finds and reads text; the networks of the configuration without.
        text: whether to read at all.
        sequential: read in step with tracking, the same map every time; else in a thread beside it, and a recording is
            played no faster than that can read it.
        live: take the frames at the pace at which they were recorded, as from a camera: mapping has threads of its own,
            and frames that come while tracking is busy are dropped. Implies that reading is not sequential.
        base: a map of an earlier recording that this one continues; it is changed and returned.
        on_progress: called after every frame.
        should_stop: asked before every frame; the map so far is returned when it says yes.

    Raises:
        UserError: not one frame of the source can be used, or tracked; or `base` was made with another camera.
    """
    config = config or Config()
    if base is not None:
        refuse_other_camera(base.camera, source.camera, "the map", config.continued_camera)
    text_map = base.text if base else TextMap(config.text)
    words = TextAdvisor(config.text.advice, text_map.memory.classes)
    advisor: LoopAdvisor = words if text and config.text.advice.enabled else NO_ADVICE
    slam = RgbdSlam(source.camera, config.slam, live=live, base=base.slam if base else None, advisor=advisor)
    beside = _naming_beside(language) if text else None
    is_threaded = live or not sequential
    mapper = None
    first_index = 0
    with ExitStack() as resources:
        if text:
            if spotter is None and live and SpottingProcess.is_possible():
                spotter = resources.enter_context(SpottingProcess(config.text.spotting))
            mapper = TextMapper(
                source.camera,
                spotter or _load_spotter(config.text.spotting, READING if live else 0),
                config.text,
                OfflineModel(),
                text_map,
                beside,
                on_sighting=words.note,
                on_doubtful=words.note_doubtful,
                on_lost=words.note_lost,
                points_seen_by=slam.map.points_seen_by,
            )
        if base is not None:
            slam.trajectory, first_index = base.trajectory, base.trajectory.begin_session()
            if mapper is not None:
                mapper.resume(base.world_from_keyframe)
        reader = None
        if mapper is not None and is_threaded:
            reader = resources.enter_context(_reading_thread(mapper, config.text.reading, live))
        reading = reader or mapper
        decoded = Prefetched(InOrder(source))
        frames = Paced(decoded, config.live.backlog, should_stop) if live else decoded
        started, seconds_tracking, count = time.perf_counter(), 0.0, 0
        is_stopped, reason = False, "it gave none"
        # Whatever goes wrong in between, its threads end.
        resources.callback(slam.finish)
        for given in frames:
            if is_stopped := should_stop():
                break
            frame = replace(given, index=first_index + given.index) if first_index else given
            before = time.perf_counter()
            tracked = slam.process(frame)
            seconds_tracking += time.perf_counter() - before
            if reading is not None:
                reading.observe(frame, tracked)
            if reader is not None and not live:
                reader.wait_for_place()
            count, reason = count + 1, tracked.reason
            on_progress(
                Progress(
                    tracked,
                    count,
                    count / (time.perf_counter() - started),
                    len(slam.map.living_keyframes()),
                    len(text_map.memory.long_term),
                )
            )
        if is_stopped and reader is not None:
            reader.abandon()
    if mapper is not None and beside is not None:
        beside.finish(0.0 if is_stopped else config.language.patience_s)
        mapper.take_names()
    if not is_stopped and slam.trajectory.tracked_count == 0:
        raise UserError(
            f"{source.name}: none of {count} frames can be tracked ({reason}); check its depth images and depth scale"
        )
    world = LanguageMap(source.camera, slam.map, slam.trajectory, text_map, source.name)
    if mapper is not None and not is_stopped:
        mapper.look_again(world.world_from_keyframe, should_stop)
    return LanguageMap(
        camera=source.camera,
        slam=slam.map,
        trajectory=slam.trajectory,
        text=text_map,
        source=source.name,
        statistics={
            "run": {
                "frames": count,
                "frames_tracked": slam.trajectory.tracked_count,
                "frames_skipped": len(frames.faults),
                "frames_dropped": frames.dropped if isinstance(frames, Paced) else 0,
                "frames_unread_for_lack_of_time": reader.dropped if reader is not None else 0,
                "keyframes_abandoned": slam.keyframes_abandoned,
                "seconds": time.perf_counter() - started,
                "seconds_tracking_and_mapping": seconds_tracking,
            },
            "reading": asdict(mapper.statistics) if mapper is not None else {},
        },
        events=slam.events,
    )


def localise(
    source: FrameSource,
    world: LanguageMap,
    config: Config | None = None,
    *,
    spotter: TextSpotter | None = None,
    text: bool = True,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Localised:
    """Localisation: find every frame in a saved map, which is only read.

    Frames are read while the camera is lost, and when it was found among signs, until they have been compared.

    Args:
        source: RGB-D frames in order of time, of the camera that made the map.
        world: the map.
        config: thresholds; defaults without.
        spotter: finds and reads text; the networks of the configuration without, loaded when first needed.
        text: whether the signs of the map help to find the camera, and to doubt where it was found.
        on_progress: called after every frame.
        should_stop: asked before every frame; what was found so far is returned when it says yes.

    Raises:
        UserError: not one frame of the source can be used, or the map was made with another camera.
    """
    config = config or Config()
    refuse_other_camera(world.camera, source.camera, "the map", config.same_camera)
    classes = world.text.memory.classes if text and config.text.advice.enabled else []
    words = TextAdvisor(config.text.advice, classes)
    slam = RgbdSlam(source.camera, config.slam, base=world.slam, grows=False, advisor=words if classes else NO_ADVICE)
    reading: TextMapper | None = None
    started, seconds_tracking, count = time.perf_counter(), 0.0, 0
    landmarks = len(world.text.memory.long_term)
    for frame in Prefetched(InOrder(source)):
        if should_stop():
            break
        before = time.perf_counter()
        tracked = slam.process(frame)
        seconds_tracking += time.perf_counter() - before
        if classes and (tracked.is_doubted or tracked.state is TrackingState.LOST):
            reading = reading or TextMapper(
                source.camera,
                spotter or _load_spotter(config.text.spotting, 0),
                config.text,
                on_doubtful=words.note_doubtful,
                on_lost=words.note_lost,
            )
            reading.observe(frame, tracked)
        count += 1
        rate = count / (time.perf_counter() - started)
        on_progress(Progress(tracked, count, rate, len(slam.map.living_keyframes()), landmarks))
    slam.finish()
    poses = StampedPoses(*slam.trajectory.world_from_camera(slam.map))
    return Localised(poses, count, slam.events, seconds_tracking)


def _naming_beside(language: LanguageModel | None) -> NamingBeside | None:
    """Mapping waits for no model but the embedded one; another's names come when they come."""
    if language is None or isinstance(language, OfflineModel):
        return None
    return NamingBeside(language, OfflineModel())


def _reading_thread(mapper: TextMapper, config: ReadingConfig, live: bool) -> ReadingThread:
    """Live, the newest frame is read, and tracking comes first; of a recording none is left out."""
    if live:
        return ReadingThread(mapper, 1, config.live_share, READING)
    return ReadingThread(mapper, config.queue_size)


def _load_spotter(config: SpottingConfig, niceness: int) -> PaddleSpotter:
    # The engine's own threads are as patient as the thread that loads it.
    with ThreadPoolExecutor(1, initializer=partial(yield_to_others, niceness)) as loader:
        return loader.submit(PaddleSpotter, config).result()


def distill(
    world: LanguageMap,
    question: str = DEFAULT_QUESTION,
    *,
    language: LanguageModel | None = None,
    spotter: TextSpotter | None = None,
) -> list[Landmark]:
    """Distilling: names from all evidence, positions by clustering, and the question judged for every name.

    A map that still has crops of unsure texts, for want of time in its run, gets its second looks first.

    Args:
        world: is changed.
        question: what is judged.
        language: names and judges; the embedded model without.
        spotter: reads what is looked at again; the networks of the configuration without, loaded where there are crops.

    Returns:
        All landmarks of the map; `is_landmark` holds the judgement.

    Raises:
        UserError: the question is empty.
    """
    if not question.strip():
        raise UserError("the question is empty; ask what makes a text a landmark, as in: Is this a shop?")
    if any(map(world.text.is_unsure, world.text.crops.by_class)):
        reader = spotter or _load_spotter(world.text.config.spotting, 0)
        look_again(world.text, world.world_from_keyframe, world.camera, reader, OfflineModel())
    return distil(world.text, world.world_from_keyframe, language or OfflineModel(), question).landmarks


def ask(
    world: LanguageMap,
    question: str,
    *,
    language: LanguageModel | None = None,
    position: NDArray[np.float64] | None = None,
    heading: float | None = None,
    excluded: Collection[int] = (),
) -> Answer:
    """Navigation: a question in any language → the landmark that serves it, with its position.

    Args:
        world: the map.
        question: what is wanted.
        language: chooses among the names; the embedded model without. It never sees a position.
        position: (3,) map frame, where the question is asked, or (2,) at the camera's last height; without, where the
            camera was last.
        heading: radians counter-clockwise from the map's x axis, which way the asker looks; without either, as the
            camera looked last.
        excluded: ids of landmarks that are no answer, having been named before.

    Raises:
        UserError: the question is empty.
    """
    if not question.strip():
        raise UserError("the question is empty; ask for a place, as in: Where can I eat pizza?")
    landmarks = [mark for mark in world.landmarks() if mark.id not in excluded]
    here, looked = _last_view(world)
    if position is None:
        heading = looked if heading is None else heading
    else:
        here = np.concatenate([position, here[len(position) :]])
    candidates = [Candidate(mark.id, mark.name, tuple(mark.variants), mark.other_lines) for mark in landmarks]
    choice = choose_trusted(language or OfflineModel(), question, candidates)
    by_id = {mark.id: mark for mark in landmarks}
    if choice.landmark is not None and choice.landmark not in by_id:
        choice = replace(choice, landmark=None, evidence=f"{choice.evidence} (no such landmark: {choice.landmark})")
    others = _known(choice.alternatives, by_id)
    if choice.landmark is None:
        return Answer(question, None, None, choice, others, here, heading)
    same = [mark for mark in landmarks if mark.name == by_id[choice.landmark].name]
    # The same sign may stand at several places: the language model chose the name, the map chooses the nearest.
    chosen = min(same, key=lambda mark: (float(np.linalg.norm(mark.position - here)), mark.id))
    distance = float(np.linalg.norm(chosen.position - here))
    others = tuple(mark for mark in (by_id[choice.landmark], *others) if mark.id != chosen.id)
    return Answer(question, chosen, distance, choice, others, here, heading, len(same))


def _last_view(world: LanguageMap) -> tuple[NDArray[np.float64], float]:
    """Where the camera was last, (3,) map frame, and its heading in radians; the origin before any frame."""
    poses = world.frame_poses().world_from_camera
    if not len(poses):
        return np.zeros(3), 0.0
    forward = poses[-1][:3, 2]
    return poses[-1][:3, 3], float(np.arctan2(forward[1], forward[0]))


def _known(ids: Sequence[int], by_id: dict[int, Landmark]) -> tuple[Landmark, ...]:
    return tuple(by_id[number] for number in ids if number in by_id)
