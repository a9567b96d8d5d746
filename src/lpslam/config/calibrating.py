"""Thresholds of estimating a calibration from a recording."""

from lpslam.config.section import Field, PositiveFloat, Section

Distortion = tuple[PositiveFloat, PositiveFloat, PositiveFloat, PositiveFloat, PositiveFloat]


class CalibratingConfig(Section):
    """Which frames are used, what is matched, and what is known of lenses beforehand."""

    # Views, that is frames, that are adjusted together; the time grows with their square.
    views: int = Field(default=60, ge=4)
    # Most frames that are looked at; of a longer recording, stretches spread over it.
    frames_read: int = Field(default=1500, ge=10)
    # How many stretches.
    stretches: int = Field(default=5, ge=1)
    # Frames that may be missing between two before the way between them counts as unknown.
    gap_frames: int = Field(default=5, ge=1)
    # Pixels that the picture moves from view to view at least: nearer ones see the same, ...
    near_apart: float = Field(default=25.0, gt=0)
    # ... and at most: farther ones hardly overlap.
    far_apart: float = Field(default=120.0, gt=0)
    # Keypoints a view.
    keypoints: int = Field(default=1000, ge=50)
    # Size of a pyramid level over the next, as keypoints are found: what is found on a coarse one is less exact.
    scale_factor: float = Field(default=1.2, gt=1)
    # Bits by which the descriptors of two matched keypoints may differ, ...
    match_bits: int = Field(default=60, ge=1)
    # ... and share of the second best's distance that the best may have.
    match_ratio: float = Field(default=0.8, gt=0, le=1)
    # Matches that one motion must explain; fewer are chance.
    min_matches: int = Field(default=25, ge=8)
    # RANSAC hypotheses at most a pair.
    trials: int = Field(default=100, ge=1)
    # Pixels by which a match may miss while the lens is only guessed, ...
    first_match_pixels: float = Field(default=10.0, gt=0)
    # ... and when it is nearly known.
    match_pixels: float = Field(default=4.0, gt=0)
    # Points at most; those that most views see.
    points: int = Field(default=4000, ge=20)
    # Levenberg-Marquardt steps at most a round.
    steps: int = Field(default=15, ge=1)
    # Standard deviations beyond which an observation is left out.
    gate: float = Field(default=3.5, gt=0)
    # Pairs of frames for the first guess of the focal length.
    search_pairs: int = Field(default=24, ge=4)
    # Focal lengths that it may have, as shares of the image's width: 150 to 15 degrees across.
    search_focals: tuple[PositiveFloat, PositiveFloat] = (0.13, 3.8)
    # Ratio of the largest to the smallest among nine in ten draws of the pairs; more, and they do not tell.
    max_guess_ratio: float = Field(default=1.5, gt=1)
    # How many are tried between, at equal ratios.
    search_steps: int = Field(default=25, ge=5)
    # Beforehand: standard deviations of the principal point from the middle, as a share of the image's width, ...
    centre_prior: float = Field(default=0.04, gt=0)
    # ... of fx / fy from 1: pixels are square within a few parts in a thousand, ...
    aspect_prior: float = Field(default=0.004, gt=0)
    # ... of the distortion k1, k2, p1, p2, k3 from none: those of a Kinect are 0.26, -0.95, -0.005, 0.003, 1.16.
    distortion_prior: Distortion = (0.4, 1.0, 0.005, 0.005, 1.5)
    # ... and of the seconds that a rolling shutter takes from the first line to the last: 0 to 0.03.
    readout_prior: float = Field(default=0.03, gt=0)
    # Standard deviations that k3 must be from 0 to be used: it bends the corners, where least is seen.
    k3_significance: float = 4.0
    # Share of the focal length that its standard deviation may be; beyond, the recording does not tell it.
    max_focal_sigma: float = Field(default=0.02, gt=0)
    # Fewest views, and observations, that are adjusted.
    min_views: int = Field(default=6, ge=3)
    min_observations: int = Field(default=400, ge=20)
    # Standard deviations by which calibrations of two halves may differ (in the root mean square of their numbers), ...
    half_deviations: float = Field(default=3.0, gt=0)
    # ... or pixels by which they may show the same ray apart, in the mean over the image, whatever they think of
    # their own exactness.
    half_pixels: float = Field(default=1.0, gt=0)
    # Share of the depth scale that its standard deviation may be; beyond, the true path does not tell it.
    max_scale_sigma: float = Field(default=0.01, gt=0)
