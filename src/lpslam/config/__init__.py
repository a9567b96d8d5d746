"""Every threshold that the paper or this project names, in one typed tree.

Defaults live here; a YAML file may override any of them (`Config.from_yaml`). Units are in the names or the comment.
"""

from pathlib import Path
from typing import Literal

from lpslam.config.calibrating import CalibratingConfig
from lpslam.config.checks import CalibrationCheckConfig, ContinuityConfig, EncodingCheckConfig, FocalCheckConfig
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
    "ContinuityConfig",
    "DepthDelayConfig",
    "DepthRangeConfig",
    "EncodingCheckConfig",
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
