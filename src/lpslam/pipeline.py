"""The three workflows of LP-SLAM (paper, Fig. 1): runtime text mapping, distilling, navigation."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from lpslam.config import CameraMatchConfig, Config
from lpslam.errors import UserError
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.language.model import LanguageModel
from lpslam.language.offline import embedded_model
from lpslam.mapfile.compatibility import difference_of
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import Answer, ask
from lpslam.poses import StampedPoses
from lpslam.session.localiser import Localiser
from lpslam.session.parts import load_spotter
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.slam.state import SlamEvent, TrackedFrame
from lpslam.sources.in_order import InOrder
from lpslam.sources.live.source import LiveSource, camera_in
from lpslam.sources.open import open_source
from lpslam.sources.pacing import Paced
from lpslam.sources.prefetch import Prefetched
from lpslam.sources.seen_by import SeenBy
from lpslam.text.again.looking import look_again
from lpslam.text.distilling import DEFAULT_QUESTION, distil
from lpslam.text.reading.spotting import TextSpotter
from lpslam.text.remembering.naming import name_class
from lpslam.text.types import Landmark

__all__ = ["Answer", "Localised", "Progress", "ask", "distill", "localise", "run"]


@dataclass(frozen=True, slots=True)
class Progress:
    """Where a run stands after a frame."""

    frame: TrackedFrame
    frames: int
    frames_per_second: float
    keyframes: int
    landmarks: int
    dropped: int = 0


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
    source: FrameSource | Path | str,
    config: Config | None = None,
    *,
    language: LanguageModel | None = None,
    spotter: TextSpotter | None = None,
    text: bool = True,
    sequential: bool = True,
    live: bool = False,
    base: LanguageMap | None = None,
    on_progress: Callable[[Progress], None] = lambda progress: None,
    on_step: Callable[[RgbdFrame, Step, Session], None] = lambda frame, step, session: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> LanguageMap:
    """Runtime text mapping: frame → track → read → class → memory → name → position.

    Args:
        source: RGB-D frames in order of time, or the path of a recording.
        config: thresholds; defaults without.
        language: names classes of misread strings; the embedded model without. Mapping never waits for another: the
            embedded model names at once, and the other's name takes its place when it comes.
        spotter: finds and reads text; the networks of the configuration without.
        text: whether to read at all.
        sequential: read in step with tracking, the same map every time; else in a thread beside it, and a recording is
            played no faster than that can read it.
        live: take the frames at the pace at which they were recorded, as from a camera (one that is connected always
            is): mapping has threads of its own, and frames that come while tracking is busy are dropped. Implies that
            reading is not sequential.
        base: a map of an earlier recording that this one continues; it is changed and returned. Frames of another
            camera are resampled to that of the map.
        on_progress: called after every frame.
        on_step: the same, with the frame, what it brought, and the session, which may be looked at from any thread.
        should_stop: asked before every frame; the map so far is returned when it says yes.

    Raises:
        UserError: the path holds no recording; not one frame of the source can be used, or tracked; or hardly any of
            what the camera of `base` sees is in view.
    """
    if isinstance(source, str | Path):
        source = open_source(Path(source))
    config = config or Config()
    if base is not None:
        source, _ = seen_by_map(source, base, "the map", config.continued_camera)
    camera = camera_in(source)
    live = live or camera is not None
    step: Step | None = None
    with Session(
        source.camera,
        config,
        language=language,
        base=base,
        live=live,
        sequential=sequential,
        spotter=spotter,
        text=text,
        name=source.name,
    ) as session:
        frames = _frames_of(source, config, live, should_stop)
        is_stopped = False
        for frame in frames:
            if is_stopped := should_stop():
                break
            step = session.take(frame)
            session.frames_dropped = _dropped(frames)
            on_step(frame, step, session)
            on_progress(_progress(session, step, _dropped(frames)))
        # A camera has no other end.
        is_stopped = is_stopped and camera is None
        session.frames_skipped = len(frames.faults)
        session.frames_dropped = _dropped(frames)
        world = session.close(hurry=is_stopped)
    # A camera that was stopped before its first picture could not be tried.
    is_untried = session.frames == 0 and should_stop()
    if not (is_stopped or is_untried) and world.trajectory.tracked_count == 0:
        reason = step.reason if step is not None else "it gave none"
        raise UserError(
            f"{source.name}: none of {session.frames} frames can be tracked ({reason}); look at its colour and depth"
            " images ('lpslam convert' writes them as files), and check the depth scale"
        )
    return world


def seen_by_map(
    source: FrameSource, world: LanguageMap, map_path: Path | str, config: CameraMatchConfig
) -> tuple[FrameSource, str]:
    """A source as the camera of a map would see it, and what is to be told of that: nothing where it is its camera.

    Raises:
        UserError: hardly any of what that camera would see is in view.
    """
    difference = difference_of(world.camera, source.camera, config)
    if not difference:
        return source, ""
    said, theirs = f"{map_path} was made with another camera: {difference}", world.camera
    if theirs.width * theirs.height > config.most_enlarged**2 * source.camera.width * source.camera.height:
        raise UserError(f"{said}; so small pictures cannot be enlarged to it: make a map with this camera")
    seen = SeenBy(source, theirs)
    if seen.share < config.least_view:
        raise UserError(
            f"{said}; this one shows {seen.share:.0%} of that one's picture, too little to be found by: make a map with"
            " this camera, or use one that sees more"
        )
    return seen, f"{said}; frames are resampled to it, of which they show {seen.share:.0%}"


def _frames_of(source: FrameSource, config: Config, live: bool, should_stop: Callable[[], bool]) -> FrameSource:
    """Frames in order: a camera's as they come, a recording's ahead of time or, live, at its pace."""
    camera = camera_in(source)
    if camera is not None:
        camera.stop_when(should_stop)
        camera.backlog = config.live.backlog
        return InOrder(source, config.times)
    decoded = Prefetched(InOrder(source, config.times))
    return Paced(decoded, config.live.backlog, should_stop) if live else decoded


def _dropped(frames: FrameSource) -> int:
    dropping = camera_in(frames) or frames
    return dropping.dropped if isinstance(dropping, LiveSource | Paced) else 0


def _progress(session: Session, step: Step, dropped: int) -> Progress:
    rate = session.frames / session.seconds
    return Progress(step.tracked, session.frames, rate, session.keyframes, session.texts, dropped)


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
        source: RGB-D frames in order of time; those of another camera than the map's are resampled to it.
        world: the map.
        config: thresholds; defaults without.
        spotter: finds and reads text; the networks of the configuration without, loaded when first needed.
        text: whether the signs of the map help to find the camera, and to doubt where it was found.
        on_progress: called after every frame.
        should_stop: asked before every frame; what was found so far is returned when it says yes.

    Raises:
        UserError: not one frame of the source can be used, or hardly any of what the map's camera sees is in view.
    """
    config = config or Config()
    source, _ = seen_by_map(source, world, "the map", config.same_camera)
    localiser = Localiser(source.camera, world, config, spotter=spotter, text=text)
    started, landmarks = time.perf_counter(), len(world.text.memory.long_term)
    keyframes = len(world.slam.living_keyframes())
    for frame in _frames_of(source, config, False, should_stop):
        if should_stop():
            break
        step = localiser.take(frame)
        rate = localiser.frames / (time.perf_counter() - started)
        on_progress(Progress(step.tracked, localiser.frames, rate, keyframes, landmarks))
    localiser.finish()
    return Localised(localiser.poses, localiser.frames, localiser.events, localiser.seconds_tracking)


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
        config = world.text.config
        reader, offline = spotter or load_spotter(config.spotting, 0), embedded_model()
        name = partial(name_class, language=offline, config=config)
        look_again(world.text, world.world_from_keyframe, world.camera, reader, name)
    return distil(world.text, world.world_from_keyframe, language or embedded_model(), question)
