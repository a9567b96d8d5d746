"""Every threshold that the paper or this project names, in one typed tree.

Defaults live here; a YAML file may override any of them (`Config.from_yaml`). Units are in the names or the comment.
"""

from pathlib import Path
from typing import Literal

from lpslam.config.calibrating import CalibratingConfig
from lpslam.config.ground import GroundConfig, WayConfig
from lpslam.config.navigation import NavigationConfig
from lpslam.config.page import PageConfig, RoomConfig
from lpslam.config.pairing import PairingConfig
from lpslam.config.places import FittingConfig, LocatingConfig, LoopConfig, PlacesConfig
from lpslam.config.registering import RegistrationCheckConfig
from lpslam.config.robots import RobotConfig
from lpslam.config.section import Field, PositiveFloat, Section
from lpslam.config.serving import JobsConfig, ServingConfig, WatchingConfig
from lpslam.config.slam import (
    DepthDelayConfig,
    DepthRangeConfig,
    FarPointConfig,
    FeatureConfig,
    KeyframeConfig,
    LevellingConfig,
    MappingConfig,
    PictureConfig,
    SensorNoiseConfig,
    ShutterConfig,
    SlamConfig,
    SurfaceConfig,
    TrackingConfig,
    TurningConfig,
)
from lpslam.config.text import (
    AdviceConfig,
    InstanceConfig,
    MemoryConfig,
    PatternConfig,
    PlacementConfig,
    ReadingConfig,
    SecondLookConfig,
    SightingConfig,
    SpottingConfig,
    TextConfig,
)
from lpslam.errors import UserError

__all__ = [
    "AdviceConfig",
    "CalibratingConfig",
    "CalibrationCheckConfig",
    "CameraMatchConfig",
    "Config",
    "DepthDelayConfig",
    "DepthRangeConfig",
    "EvaluationConfig",
    "FarPointConfig",
    "FeatureConfig",
    "FittingConfig",
    "FocalCheckConfig",
    "GroundConfig",
    "InstanceConfig",
    "JobsConfig",
    "KeyframeConfig",
    "LanguageConfig",
    "LevellingConfig",
    "LiveConfig",
    "LocatingConfig",
    "LoopConfig",
    "MappingConfig",
    "MemoryConfig",
    "NavigationConfig",
    "PageConfig",
    "PairingConfig",
    "PatternConfig",
    "PictureConfig",
    "PlacementConfig",
    "PlacesConfig",
    "ReadingConfig",
    "RegistrationCheckConfig",
    "RobotConfig",
    "RoomConfig",
    "SecondLookConfig",
    "SensorNoiseConfig",
    "ServingConfig",
    "ShutterConfig",
    "SightingConfig",
    "SimulationConfig",
    "SlamConfig",
    "SpottingConfig",
    "SurfaceConfig",
    "TextConfig",
    "TimesConfig",
    "TrackingConfig",
    "TurningConfig",
    "WatchingConfig",
    "WayConfig",
]


class SimulationConfig(Section):
    """The mock mall and the camera that walks through it."""

    # Length of the closed route, metres; shorter than 24 leaves no room for shops inside the loop.
    loop_length: float = Field(default=32.0, ge=24.0, le=400.0)
    # One loop, or two that share a corridor.
    layout: Literal["loop", "figure-eight"] = "loop"
    # Brightness of the lamps; 0.3 is a mall after closing time.
    light: float = Field(default=1.0, gt=0.0, le=2.0)
    # Fastest turn of the camera, degrees a second; 134 is a hurried head.
    max_turn_rate: float = Field(default=45.0, gt=5.0, le=200.0)
    # Walking pace, metres a second.
    speed: float = Field(default=1.0, gt=0.1, le=3.0)
    # Which languages the signs show.
    language: Literal["mixed", "chinese", "english"] = "mixed"
    # Names that the mall shows for sure, as the lexicon spells them; as many as there are places for their kind.
    featured: tuple[str, ...] = ()
    # How many signs repeat the words of another one.
    duplicates: int = Field(default=0, ge=0)
    # Signs that repeat another one's words and look about so many metres from it: one pair a number, if there is room.
    duplicate_distances: tuple[PositiveFloat, ...] = ()
    # Whether names that differ by one letter are shown for sure: GAP and GAO, EXIT and EXIT 2.
    similar_names: bool = False
    # Share of the shops with a double-sided sign that stands out of the wall.
    projecting_share: float = Field(default=0.35, ge=0.0, le=1.0)
    # Once around the route, or around it and back again: then double-sided signs are seen from both sides.
    way: Literal["around", "there-and-back"] = "around"
    # Shutter time in good light, seconds; in the dark it doubles.
    exposure_time: float = Field(default=0.006, ge=0.0, le=0.03)
    # Noise, vignetting, exposure drift and depth errors; off for tests of geometry.
    sensor_noise: bool = True


class EvaluationConfig(Section):
    """When an estimate counts as right."""

    # Seconds between two poses that are compared: at most two thirds of a frame.
    association_tolerance: float = Field(default=0.02, gt=0)
    # Eq. 3 similarity of a landmark's name with a sign's text: one letter in five may be wrong.
    name_similarity: float = Field(default=0.8, gt=0, le=1)
    # The same from which a reading is of a line of a photograph at all, however badly it is read.
    line_similarity: float = Field(default=0.5, gt=0, le=1)
    # Metres between a landmark and the sign that it is.
    landmark_distance: float = Field(default=1.0, gt=0)
    # Fewest frames in which a sign must be readable before it is expected in the map.
    readable_frames: int = Field(default=10, ge=0)
    # Degrees between a landmark's normal and its sign's.
    facing_angle: float = Field(default=10.0, gt=0)
    # Metres from which two signs of the same words are two places.
    duplicate_distance: float = Field(default=2.0, ge=0)


class LanguageConfig(Section):
    """How a hosted or local chat model is asked; the embedded model needs none of it."""

    # Seconds to wait for one answer; a local model on a slow machine needs its time.
    timeout_s: float = Field(default=60.0, gt=0)
    # Times that a busy or failing server is asked before the embedded model answers.
    attempts: int = Field(default=3, ge=1)
    # Seconds before the second attempt; doubles with each further one.
    backoff_s: float = Field(default=1.0, ge=0)
    # Longest pause that a server may ask for, seconds; one that wants more is not waited for.
    longest_wait_s: float = Field(default=20.0, ge=0)
    # Seconds for which a server that failed in every attempt is left alone: a map of names must not wait for each.
    rest_s: float = Field(default=30.0, ge=0)
    # Times in a row that what a busy server left open of a batch is put again, after its rest, without an answer.
    rounds: int = Field(default=3, ge=0)
    # Questions put at the same time; more than this earns a 429 from most accounts.
    at_once: int = Field(default=4, ge=1)
    # Most calls of one process, retries included: thousands of signs must not cost more than was meant.
    max_calls: int = Field(default=1000, ge=0)
    # Most tokens of one process, in and out; the call that passes it is the last one.
    max_tokens: int = Field(default=500_000, ge=0)
    # Whether answers are kept on disk, in this user's cache folder: the same question is paid for once.
    cache: bool = True
    # Seconds that a run waits at its end for names that were asked for beside mapping; 'lpslam distill' asks again.
    patience_s: float = Field(default=30.0, ge=0)
    # Names of landmarks that a question is put with, always in the order of the map, so that a server keeps what it has
    # read of them; of a larger map those that fit the question and what the model says would serve it.
    landmarks_sent: int = Field(default=1000, ge=1, le=9000)
    # Of a larger map, so many are sent once the model has said what would serve.
    landmarks_found: int = Field(default=200, ge=1, le=9000)
    # Signs of one request when many are named or judged: more of them make long answers, and sway one another.
    signs_together: int = Field(default=25, ge=1)
    # Longest name sent with a question, code points; a place has a shorter one.
    name_length: int = Field(default=60, ge=1)
    # Other readings of a landmark that are sent along.
    aliases_sent: int = Field(default=2, ge=0)
    # Spellings of a sign that is to be named, surest first; rarer ones say nothing new.
    readings_sent: int = Field(default=12, ge=1)
    # Longest question sent, code points.
    question_length: int = Field(default=400, ge=1)
    # Eq. 3 similarity that a chosen name must have with some reading: a model chooses, it does not invent.
    name_similarity: float = Field(default=0.5, ge=0, le=1)


class FocalCheckConfig(Section):
    """Whether the focal length fits how the picture moves: what is compared, and when it is doubted."""

    # Pairs of frames, spread over the recording; 0: the focal length is not checked. Ten take a third of a second.
    pairs: int = Field(default=10, ge=0)
    # Seconds between the frames of a pair: time for a hand or a robot to turn by five degrees.
    apart_s: float = Field(default=0.33, gt=0)
    # Corners followed a pair; more say the same.
    corners: int = Field(default=120, ge=10)
    # Of which so many must be found again and have depth.
    min_places: int = Field(default=25, ge=8)
    # Median motion of the picture, pixels; less tells nothing.
    min_motion: float = 4.0
    # Metres within which a depth is used: sensors are blind below, and noisy beyond.
    depth_reach: tuple[float, float] = (0.3, 8.0)
    # Share of the depth by which the eight pixels around may differ; more is an edge.
    depth_edge: float = Field(default=0.03, gt=0)
    # Standard deviations: pixels by flow, a lens' distortion and rolling shutter included, ...
    pixel_sigma: float = Field(default=1.0, gt=0)
    # ... metres of depth at any distance, ...
    depth_sigma: float = Field(default=0.003, gt=0)
    # ... and metres a square metre more.
    depth_sigma_quadratic: float = 0.0035
    # Focal lengths that are tried, as ratios to the stated one, rising.
    ratios: tuple[PositiveFloat, ...] = (0.4, 0.5, 0.63, 0.8, 1.0, 1.25, 1.6, 2.0, 2.5)
    # Fewest pairs that can judge.
    min_pairs: int = Field(default=4, ge=2)
    # Ratio of the better focal length to the stated one, or the other way round: distortion that is left out moves it
    # by up to 6 %, and depth that is not registered to colour by 12 %.
    doubtful_ratio: float = Field(default=1.2, gt=1)
    # Times that the pairs are drawn anew, with replacement, ...
    redraws: int = Field(default=300, ge=1)
    # ... and share of these draws that must say so: no single pair decides.
    min_agreement: float = Field(default=0.99, gt=0.5, le=1)
    # Share by which the pairs must bend more at the stated focal length: where nothing turned, nothing is told.
    min_gain: float = 0.05


class ContinuityConfig(Section):
    """When frames of one folder are those of two recordings."""

    # Seconds without a frame from which it is asked: whoever goes on with a walk goes on within the hour.
    longest_gap_s: float = Field(default=3600.0, gt=0)
    # Frames on either side: fewer are stamps that are wrong.
    least_frames: int = Field(default=3, ge=2)
    # One less the correlation of small pictures, up to which they go on: then the clock was set, and the walk is one.
    most_unlike: float = Field(default=0.5, gt=0, le=1)


class EncodingCheckConfig(Section):
    """When raw numbers are no depth but its inverse, or carry flags: right recordings stay below half of it."""

    # Frames, spread over the recording, that are looked at.
    frames: int = Field(default=8, ge=1)
    # Patches across a picture, each a plane or none.
    patches: int = Field(default=8, ge=2)
    # Median share of depth by which a plane's readings stray: sensors' noise.
    planar: float = Field(default=0.01, gt=0)
    # Share of depth that is added to both, so that rounding decides nothing.
    noise: float = Field(default=1e-5, gt=0)
    # Share of depth by which a plane must change within its patch: one that is seen frontally tells nothing.
    least_slope: float = Field(default=0.15, gt=0)
    # Times that one way must be nearer to a plane.
    clear: float = Field(default=1.5, gt=1)
    # Patches that must speak for inverse depth, and times those that speak for depth.
    least_patches: int = Field(default=8, ge=1)
    majority: float = Field(default=4.0, ge=1)
    # Large differences between neighbours, and how near to a power of two they must be, as a share of it, ...
    least_steps: int = Field(default=200, ge=1)
    step_share: float = Field(default=0.02, gt=0, lt=0.5)
    # ... and share of them that must be: by chance it is twice that, in recordings up to 0.07.
    most_by_chance: float = Field(default=0.4, gt=0, lt=1)


class CalibrationCheckConfig(Section):
    """When a calibration is doubted: beyond what is usual is said, beyond what is possible is refused."""

    # Degrees seen across the image's width: RGB-D cameras see 43 (telephoto) to 120 (wide).
    usual_view: tuple[float, float] = (35.0, 125.0)
    # The same; beyond it the focal length is in other units or of other images.
    possible_view: tuple[float, float] = (10.0, 160.0)
    # By which share fx and fy may differ: pixels are square within a few parts in a thousand.
    aspect: float = Field(default=0.05, gt=0)
    # Share of width or height that the principal point may be off the centre; lenses sit within 5 %.
    centre_offset: float = Field(default=0.1, gt=0, lt=0.5)
    # Median depth, metres: sensors are blind below 0.3 and rooms seldom wider than 10; half of a view beyond 8 is lost.
    usual_median_depth: tuple[float, float] = (0.5, 8.0)
    # Beyond this, metres, tracking has nothing to stand on.
    possible_median_depth: tuple[float, float] = (0.1, 40.0)
    # Metres beyond which a twentieth of the readings must not lie: consumer sensors end at 10.
    usual_far_depth: float = Field(default=12.0, gt=0)
    # Metres at which a twentieth of the readings begins, in the frame that sees farthest, where no scale is stated.
    usual_farthest: tuple[float, float] = (2.0, 10.0)
    # Median depth, metres, that makes another depth scale worth proposing.
    room_depth: tuple[float, float] = (0.7, 7.0)
    # Frames, spread over the recording, whose depth is looked at: 50 ms in all.
    depth_frames: int = Field(default=7, ge=1)
    # Seconds between colour and depth; at 45 degrees a second 12 ms move the image by 5 pixels.
    usual_lag: float = Field(default=0.012, gt=0)
    # Seconds within which a lag between clocks keeps steady: cameras stamp to the millisecond.
    steady_lag: float = Field(default=0.002, gt=0)
    # Fewest frames from which a lag is judged.
    timing_frames: int = Field(default=10, ge=3)
    # By the motion of the picture.
    focal: FocalCheckConfig = FocalCheckConfig()
    # By contours of things.
    registration: RegistrationCheckConfig = RegistrationCheckConfig()
    # By the planes and the steps in its depth.
    encoding: EncodingCheckConfig = EncodingCheckConfig()
    # By what lies between its frames.
    continuity: ContinuityConfig = ContinuityConfig()


class CameraMatchConfig(Section):
    """How far two calibrations of one camera may differ, for frames to be used with a saved map as they are."""

    # Share of the focal length: calibrating the same camera twice gives as much.
    focal_share: float = Field(default=0.01, gt=0)
    # Pixels of the principal point, the same.
    centre_pixels: float = Field(default=8.0, gt=0)
    # Pixels by which two distortions may place the same ray apart, anywhere in the image.
    distortion_pixels: float = Field(default=5.0, gt=0)
    # Share of the picture of a map's camera that another camera must show, whose frames are resampled to it.
    least_view: float = Field(default=0.2, gt=0, le=1)
    # Times by which the sides of its pictures may be enlarged for that: more shows nothing of what the map's show.
    most_enlarged: float = Field(default=4.0, ge=1)


class TimesConfig(Section):
    """Frames whose times leap ahead: one corrupt stamp must not make all that follow come too late."""

    # Seconds after the frame before from which a recording's frame waits for the next, which tells whether it is true.
    recorded_leap_s: float = Field(default=1.0, gt=0)
    # The same of frames that come one by one: longer than a robot's pictures stay away, but when it rests.
    stepped_leap_s: float = Field(default=10.0, gt=0)
    # Seconds from which a recording's last frame, which none confirms, is left out: one played live would wait so long.
    last_leap_s: float = Field(default=10.0, gt=0)
    # Times the gap before it: a gap up to this is the pace of a slow camera.
    slower: float = Field(default=2.0, ge=1)
    # Times that a picture may come again, byte for byte: a slow camera does that, one that hangs goes on.
    repeats: int = Field(default=1, ge=0)


class LiveConfig(Section):
    """Frames as they come from a camera."""

    # Frames that may wait while tracking is busy, a tenth of a second at 30 a second: a delay is better than a gap.
    backlog: int = Field(default=3, ge=1)


class Config(Section):
    """The whole tree."""

    calibration: CalibrationCheckConfig = CalibrationCheckConfig()

    calibrating: CalibratingConfig = CalibratingConfig()

    # To find a camera in a map, ...
    same_camera: CameraMatchConfig = CameraMatchConfig()
    # ... and to let the map grow: its old keyframes are adjusted by the new recording's calibration.
    continued_camera: CameraMatchConfig = CameraMatchConfig().model_copy(
        update={"focal_share": 0.001, "centre_pixels": 0.5, "distortion_pixels": 0.5}
    )

    language: LanguageConfig = LanguageConfig()

    evaluation: EvaluationConfig = EvaluationConfig()

    times: TimesConfig = TimesConfig()

    pairing: PairingConfig = PairingConfig()

    live: LiveConfig = LiveConfig()

    serving: ServingConfig = ServingConfig()

    page: PageConfig = PageConfig()

    robots: RobotConfig = RobotConfig()

    simulation: SimulationConfig = SimulationConfig()

    slam: SlamConfig = SlamConfig()

    text: TextConfig = TextConfig()

    ground: GroundConfig = GroundConfig()

    ways: WayConfig = WayConfig()

    navigation: NavigationConfig = NavigationConfig()

    @classmethod
    def from_yaml(cls, path: Path) -> "Config":
        """Read overrides from a YAML file; unknown or ill-typed keys are a `UserError`."""
        from pydantic import ValidationError

        from lpslam.config.hostile_yaml import yaml_of
        from lpslam.regular_files import text_of

        try:
            return cls.model_validate(yaml_of(text_of(path, "configuration")) or {})
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UserError(f"configuration {path}: {where}: {first['msg']}") from error
        except ValueError as error:
            raise UserError(f"configuration {path} is not YAML: {error}") from error
