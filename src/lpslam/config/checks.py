"""What a recording is checked for when it is opened: its calibration, its depth, and whether it is one walk."""

from lpslam.config.registering import RegistrationCheckConfig
from lpslam.config.section import Field, PositiveFloat, Section


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
