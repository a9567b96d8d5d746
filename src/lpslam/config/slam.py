"""Thresholds of SLAM."""

from lpslam.config.places import FittingConfig, LocatingConfig, LoopConfig, PlacesConfig
from lpslam.config.section import Field, Section


class FeatureConfig(Section):
    """ORB features and their depth."""

    count: int = Field(default=1000, ge=1, le=100_000)  # keypoints a frame; fewer lose accuracy, more cost time
    levels: int = Field(default=8, ge=2, le=16)  # pyramid levels
    scale_factor: float = Field(default=1.2, gt=1)  # size of a level over the next
    fast_threshold: int = Field(default=12, ge=1, le=255)  # grey values a corner's arc must differ by, once smoothed
    faintest_threshold: int = Field(default=2, ge=1, le=255)  # grey values, where the first finds nothing, ...
    noise_multiple: float = Field(default=4.0, ge=0)  # ... and so many times what is left of the picture's noise
    sparse_share: float = Field(default=0.5, ge=0, le=1)  # of a level's quota; fewer, and faint ones count everywhere
    cell_pixels: int = Field(default=35, ge=1)  # side of the cells in which the threshold adapts
    virtual_baseline: float = Field(default=0.08, gt=0)  # metres; scales u_r only, weights come from the noise model
    min_depth: float = 0.3  # metres; structured-light and stereo sensors are blind below
    max_depth: float = 8.0  # metres; beyond, the noise of consumer sensors exceeds 15 cm
    depth_edge_radius: int = 2  # pixels of the neighbourhood in which a depth must agree
    depth_edge_tolerance: float = 0.03  # share of the depth; more is an edge, whose depth may be the other side's


class SensorNoiseConfig(Section):
    """How far keypoints and depth readings stray: the weights of every adjustment."""

    pixel_sigma: float = Field(default=0.7, gt=0)  # pixels, at any level: blur, rolling shutter, depth registration
    level_pixel_sigma: float = Field(default=0.5, gt=0)  # pixels of the level at which a corner is found: its rounding
    depth_sigma: float = Field(default=0.003, gt=0)  # metres, at any distance: registration and rounding
    depth_sigma_quadratic: float = 0.0035  # metres a square metre: disparity noise of structured light and stereo


class ShutterConfig(Section):
    """Rolling shutter: how long a picture's rows take, estimated from pairs of views in different motion."""

    readout: float | None = None  # seconds from the first row to the last, where it is known; 0 for a global shutter
    views: int = Field(default=12, ge=2)  # latest views that are kept for comparing
    compared: int = Field(default=3, ge=1)  # of them, those that moved most differently, compared with each new one
    interval: float = 0.1  # seconds between views that are compared; nearer ones see the same
    settled_interval: float = 2.0  # the same, once it is settled: only to notice that it was wrong
    least_difference: float = 0.15  # radians a second between the views; 30 ms bend them by 2 pixels then
    min_matches: int = Field(default=60, ge=12)  # points of a pair that must agree; fewer hardly hold seven unknowns
    largest_sigma: float = 0.005  # seconds; a pair that knows less says nothing
    longest: float = 0.06  # seconds; no camera takes longer, what would is a pair gone wrong
    pairs: int = Field(default=120, ge=1)  # latest pairs that count; with so many it is settled
    # With fewer it is settled as well, where the least change would be more than all that is left in doubt.
    settled_pairs: int = Field(default=40, ge=1)
    min_pairs: int = Field(default=6, ge=2)  # before which nothing is corrected: each may be wrong by its velocities
    certain_sigmas: float = 3.0  # by which another readout must differ from the present one
    least_change: float = 0.001  # seconds, the same; less is not worth straightening all keyframes
    noticed_pixels: float = 0.2  # by which another velocity must bend the image for the frame to be optimised again
    keyframes: int = Field(default=200, ge=0)  # latest ones that are straightened again when the readout changes
    revised_frames: int = Field(default=300, ge=0)  # latest frames whose poses are optimised anew when it changes
    longest_gap: float = 0.15  # seconds between two frames that tell a velocity; more, and it has changed between


class DepthDelayConfig(Section):
    """How much later than colour depth is taken, estimated from views in motion."""

    longest: float = Field(default=0.048, gt=0)  # seconds to either side that are tried; more is another frame's depth
    steps: int = Field(default=8, ge=2)  # times tried to either side, 6 ms apart: a pixel or two in a turn
    interval: float = 0.2  # seconds between views that are asked; nearer ones say the same
    settled_interval: float = 2.0  # the same, once there are `views`: only to notice that it was wrong
    least_motion: float = 50.0  # pixels a second; slower, and 20 ms move depth by less than a pixel
    min_observers: int = Field(default=3, ge=1)  # keyframes that must see a point: its place is not one depth's then
    most_points: int = Field(default=250, ge=3)  # of a view that are asked; more only cost time
    min_points: int = Field(default=30, ge=3)  # that must have depth at all times tried; fewer are easily one surface
    largest_sigma: float = Field(default=0.004, gt=0)  # seconds; a view that knows less says nothing
    views: int = Field(default=60, ge=2)  # latest ones that count
    min_views: int = Field(default=6, ge=1)  # that move one way, and as many the other, before anything is said
    certain_sigmas: float = 3.0  # by which another delay must differ from what was said
    least_change: float = 0.006  # seconds, the same; half of what quick turns begin to suffer from


class DepthRangeConfig(Section):
    """Depth that is too long or too short by its range, estimated from the map."""

    knots: float = Field(default=0.5, gt=0)  # metres between distances at which the excess is estimated
    anchored: float = Field(default=1.5, ge=0)  # metres; nearer readings are believed, all others compared with them
    drift: float = Field(default=0.015, gt=0)  # by which the excess usually differs from a knot to the next
    min_observers: int = Field(default=3, ge=2)  # keyframes that must see a point; two agree on wrong matches
    largest_share: float = Field(default=0.04, gt=0)  # of a point's distance, to which pixels must tell it
    min_readings: int = Field(default=3, ge=1)  # of a keyframe at a distance, of which the median counts
    reading_error: float = Field(default=0.03, gt=0)  # by which one of them is off, as a share of the distance ...
    common_error: float = Field(default=0.01, gt=0)  # ... and by which all of a keyframe's at one distance are
    # Times as many keyframes must see a keyframe's points as when it voted last, for it to vote anew: 1 ms each.
    renewed_observers: float = Field(default=1.1, ge=1)
    reach_readings: int = Field(default=30, ge=1)  # of a keyframe, which tell how far the sensor reaches ...
    reach_share: float = Field(default=0.98, gt=0, le=1)  # ... by this quantile: the last few may be false
    certain_gain: float = Field(default=6.0, ge=0)  # times what is left, that a curve must explain; 0: never corrected
    refined_gain: float = Field(default=4.0, ge=0)  # the same, once depth is corrected: that it is wrong is known
    most_unexplained: float = Field(default=10.0, ge=1)  # χ² a vote that may remain: else votes contradict one another
    most_changes: int = Field(default=8, ge=0)  # of the curve in a recording; one that needs more does not settle
    least_change: float = Field(default=0.02, ge=0)  # the same; what sensors state as their accuracy is not corrected


class TrackingConfig(Section):
    """From frame to pose."""

    motion_radius: float = 15.0  # pixels at the finest level around the prediction by constant velocity
    local_map_radius: float = 4.0  # pixels at the finest level around a local map point's projection
    local_map_radius_frontal: float = 2.5  # the same where the point is seen from nearly the side it was seen from ...
    frontal_cosine: float = 0.998  # ... by the cosine between the two viewing directions
    min_view_cosine: float = 0.5  # the same; a patch seen from more than 60° aside looks different
    hamming_loose: int = 100  # bits; where a window limits the search
    hamming_strict: int = 60  # bits; where nothing but the descriptor decides: 80 % of true and 2 % of wrong pairs pass
    ratio_local_map: float = 0.8  # best over second best on the same level
    ratio_brute_force: float = 0.75  # best over second best in the whole image
    min_motion_matches: int = 20  # fewer, and the window is doubled, then the reference keyframe is tried
    min_pose_inliers: int = 10  # fewer cannot hold six degrees of freedom against outliers
    min_inliers: int = 30  # after the local map; fewer is lost
    min_recovery_inliers: int = 50  # to leave the lost state; stricter, since a wrong place ruins the map
    weak_inliers: int = 60  # fewer is reported as weak
    bearings_below: int = 120  # map points in the last view; fewer, and keypoints without depth help to hold the turn
    local_keyframes: int = 60  # most covisible keyframes whose points are searched
    pose_rounds: int = Field(default=4, ge=1)  # rounds of outlier judgement
    pose_iterations: int = 10  # Gauss-Newton steps a round at most
    doubtful_share: float = Field(default=0.9, ge=0, le=1)  # of the matches; fewer agree, and hypotheses are tried
    hypotheses: int = Field(default=300, ge=1)  # at most; where two thirds are wrong, 300 meet three right points
    unconfirmed_weight: float = Field(default=0.3, ge=0, le=1)  # of a point that one keyframe saw: it may be someone
    crowd_metres: float = Field(default=0.5, gt=0)  # points so near each other are one witness: they move together
    crowd_share: float = Field(default=0.08, gt=0, le=1)  # of the picture's width; the same of points without distance
    min_judges: int = Field(default=30, ge=4)  # points seen by two keyframes; from so many on only they tell agreement
    agreeing_sigmas: float = Field(default=4.0, gt=0)  # of a keypoint; farther off before refinement, it disagrees
    blur_ratio: float = 0.35  # share of the usual gradient energy below which a frame is called blurred
    followed_points: int = Field(default=250, ge=0)  # keypoints followed by optical flow between ORB frames; 0: never
    flow_window: int = Field(default=15, ge=5)  # pixels; side of the patch that is followed
    flow_levels: int = Field(default=2, ge=0)  # pyramid levels above the image: 2 reach 30 px beyond the prediction
    flow_steps: int = Field(default=12, ge=1)  # iterations a level at most
    flow_precision: float = Field(default=0.03, gt=0)  # pixels; a smaller step ends the iteration
    min_agreement: float = Field(default=0.6, ge=0, le=1)  # share of what is followed that one motion must explain
    min_followed: int = 60  # inliers; fewer, and the frame is matched with the map at once
    min_followed_share: float = Field(default=0.7, ge=0, le=1)  # of those followed first, the same
    anchor_interval: float = Field(default=0.1, ge=0)  # seconds after which a frame is matched with the map anyway
    anchor_travel: float = Field(default=0.08, ge=0)  # of the image's width that the picture moves, the same
    pictured_travel: float = Field(default=0.03, ge=0)  # the same while a frame is exposed; whole pictures tell then
    longest_exposure: float = Field(default=0.033, gt=0)  # seconds; automatic exposure takes no more, even in the dark
    bridged_travel: float = Field(default=1.5, ge=0)  # of the same, over which frames that showed nothing are bridged
    steady_share: float = Field(default=0.5, ge=0)  # of `motion_radius`; predictions farther off, and flow goes first
    coast_seconds: float = Field(default=0.5, ge=0)  # for which the motion carries the pose where a frame shows nothing
    coast_metres: float = Field(default=0.5, ge=0)  # by which the position may be wrong where only the turn is told
    backtracked_seconds: float = Field(default=1.0, ge=0)  # before the camera is found, in which frames are placed late
    strict_seconds: float = 1.0  # after relocalising, in which `min_recovery_inliers` must be matched
    predictable_gap: float = Field(default=0.08, gt=0)  # seconds between frames; more, and a turn has changed its pace
    long_gap: float = Field(default=0.3, gt=0)  # seconds without frames after which the same: nothing was predicted
    recovery_candidates: int = Field(default=4, ge=1)  # places tried a frame when lost
    carried_speed: float = Field(default=2.0, gt=0)  # m/s; a camera that is carried unseen is not faster: a quick walk
    told_drift: float = Field(default=0.3, gt=0)  # m/s by which a way that surfaces and corners tell may be wrong
    swerve_distance: float = Field(default=0.1, ge=0)  # metres besides, by which a pose may miss what motion foretells
    recovery_sweep: int = Field(default=3, ge=0)  # further keyframes a frame, whatever they look like: all in turn
    doubt_seconds: float = Field(default=3.0, ge=0)  # after relocalising, in which signs may speak against the place
    submap_after: float = Field(default=0.5, ge=0)  # seconds of usable but unknown views after which a sub-map begins


class SurfaceConfig(Section):
    """Alignment of whole images, where keypoints do not say where a frame was taken."""

    width: int = Field(default=160, ge=16)  # pixels across; noise of the shades is averaged, slopes of depth stay
    around: float = Field(default=4.0, gt=0)  # pixels; shades that change more slowly are the light's and the lens's
    thinned: int = Field(default=2, ge=1)  # pixels of a row to one that is asked: neighbours err alike
    steps: int = Field(default=15, ge=1)  # of Gauss-Newton at most
    settled: float = Field(default=0.05, gt=0)  # sigmas of what images say; a smaller step is the last one
    edge: float = Field(default=0.1, gt=0)  # of the depth; neighbours that differ by more are of two surfaces
    guess_speed: float = Field(default=0.3, gt=0)  # m/s; sigma of the guess, which fills in what images do not say
    guess_turn: float = Field(default=0.5, gt=0)  # rad/s; the same of its turn
    guess_sigmas: float = Field(default=6.0, gt=0)  # of the guess; images that are farther off slid along a pattern
    lead: float = Field(default=1.3, ge=1)  # of a shift over the next best one; with less it may be that one
    least_shade: float = Field(default=0.05, gt=0)  # grey values; sigma of the shades at least: they were rounded
    least_shared: float = Field(default=0.4, gt=0, le=1)  # of the reference's pixels with depth must be in view
    least_measured: float = Field(default=0.1, gt=0, le=1)  # of the pixels must have depth in both images
    least_agreement: float = Field(default=0.8, ge=0, le=1)  # of the pixels' depths, within three sigmas; ...
    proven_agreement: float = Field(default=0.5, ge=0, le=1)  # ... where the shades are alike, depth may be poor
    least_likeness: float = Field(default=5.0, gt=0)  # sigmas of shades that have nothing in common
    least_contrast: float = Field(
        default=4.0, ge=0
    )  # grey values; a picture with less is blank or dark, as is one with
    blank_contrast: float = Field(default=4.0, gt=0)  # less than so many times the noise of neighbours
    told_share: float = Field(default=0.33, gt=0)  # of the guess's sigma; images that tell no better do not hold
    least_noise: float = Field(default=0.4, gt=0)  # of the supposed sigma: the median of nine readings leaves so much
    renewed_share: float = Field(default=0.8, gt=0, le=1)  # of the reference in view; less, and the next one is taken
    least_shrink: int = Field(default=4, ge=1)  # pixels to one: neighbours share no reading, shades have less noise
    nearest: float = Field(default=0.05, gt=0)  # metres before the camera; what is nearer is not seen
    shade_doubt: float = Field(default=2.8, ge=1)  # of their sigma: noise of shades is smoothed over eight pixels
    first_shade: float = Field(default=5.0, gt=0)  # grey values; sigma of the shades before they are compared
    untold_metres: float = Field(default=0.2, ge=0)  # of the way to where the map goes on: less than a loop mends
    untold_seconds: float = Field(default=0.05, ge=0)  # of its turn, the same: a turn hardly changes in so short a time
    held_seconds: float = Field(default=10.0, ge=0)  # for which images alone tell the way; they drift by a twentieth


class PictureConfig(Section):
    """Neighbouring keyframes aligned as whole pictures, which holds them together where corners are blurred."""

    enabled: bool = True
    longest_gap: float = Field(default=1.0, gt=0)  # seconds between two keyframes; images of more share too little
    judged_first: int = Field(default=16, ge=1)  # ways round three keyframes that are looked at before ...
    judged_every: int = Field(default=8, ge=2)  # ... only one in so many keyframes: an alignment costs 5 ms
    most_disagreement: float = Field(default=150.0, gt=0)  # χ² with the map; for more, most pixels must agree ...
    unusual: float = Field(default=1.75, gt=1)  # ... and differ by less than so many times the ...
    remembered_steps: int = Field(default=30, ge=1)  # ... median of the newest steps that it did not deny
    largest_excess: float = Field(default=1000.0, gt=0)  # of the variance that pictures say; beyond, they hold nothing
    # Times the variance that ways round show: what is wrong alike in all three (lens, scale, delay) closes them too.
    unseen_errors: float = Field(default=15.0, ge=1)
    remembered_gaps: int = Field(default=100, ge=1, le=100_000)  # newest ways round, of which the median is taken
    # χ² (six degrees of freedom) of a way round before any is known: pixels share their errors with five around them;
    supposed_gap: float = Field(default=25.0, gt=0)
    supposed_gaps: int = Field(default=5, ge=1, le=1000)  # ... and for how many ways round that counts
    most_surprise: float = Field(default=3.0, gt=0)  # sigmas of a guess; a fast frame's step is no farther from its own
    kept_pictures: int = Field(default=20, ge=2)  # keyframes: those of a doubted place wait so long


class FarPointConfig(Section):
    """Points where no depth was read, of which the direction is known first and the distance later."""

    most: int = Field(default=150, ge=0)  # made of one keyframe; 0: none
    in_view: int = Field(default=500, ge=0)  # points a keyframe sees; with more, no far ones are needed
    least_depths: int = Field(default=30, ge=1)  # keypoints with depth that tell how far the sensor reaches ...
    reach_share: float = Field(default=0.95, gt=0, le=1)  # ... by this quantile: the last few may be false
    hole_width: float = Field(default=0.025, gt=0)  # of the image's width; so far around a keypoint ...
    hole_share: float = Field(default=0.05, gt=0)  # ... fewer pixels than this have depth; edges and shadows have more
    sure_share: float = Field(default=0.05, gt=0)  # of the inverse depth, below which its sigma makes a point sure
    behind_sigmas: float = Field(default=2.0, gt=0)  # behind infinity; such a point was matched wrongly or moves
    farthest: float = Field(default=1000.0, gt=0)  # metres at which what has no parallax is put


class TurningConfig(Section):
    """The camera's turn between two pictures, where nothing else says where a frame was taken."""

    width: int = Field(default=320, ge=32)  # pixels across at most; noise and blur leave no more
    corners: int = Field(default=200, ge=3)  # followed at most
    corner_quality: float = Field(default=0.01, gt=0, lt=1)  # of the best corner's strength, at least
    corner_distance: float = Field(default=0.02, ge=0)  # of the width between corners: they are spread over the picture
    window: int = Field(default=15, ge=5)  # pixels, in which a corner is followed
    levels: int = Field(default=4, ge=0)  # of the pyramid: 16 times the window's reach
    min_corners: int = Field(default=20, ge=3)  # followed; fewer may agree on anything
    pixels: float = Field(default=1.5, gt=0)  # of the small picture, within which a corner agrees with a turn
    agreement: float = Field(default=0.6, ge=0, le=1)  # of the corners; for less, something else turns as well


class KeyframeConfig(Section):
    """When a frame becomes a keyframe."""

    max_interval: float = 1.0  # seconds after which a keyframe is wanted whatever is seen
    min_interval: float = 0.1  # seconds; denser ones see the same
    tracked_share: float = 0.8  # of the most matches since the last keyframe; fewer, and a keyframe is wanted
    urgent_share: float = 0.6  # of the same; fewer, and a keyframe is wanted however young the last one is
    foresight: float = 0.1  # seconds ahead for which the fall of the matches is drawn on
    due_share: float = 0.95  # the same, once `max_interval` has passed
    known_matches: int = 150  # map points matched, from which a view may be known already ...
    known_distance: float = 0.08  # ... where a keyframe is nearer than this, metres, ...
    known_turn: float = 0.12  # ... and looks the same way within this angle, radians
    close_depth: float = 3.5  # metres; nearer points fix translation
    close_tracked: int = 100  # fewer close points tracked, and ...
    close_untracked: int = 70  # ... more close keypoints without a point: a keyframe is wanted
    point_depth: float = 5.0  # metres; nearer keypoints become points, weighted by their depth's noise
    points_in_view: int = 500  # map points a keyframe should see; farther keypoints become points until it does
    min_start_depths: int = 80  # keypoints with depth that the first keyframe of a map needs ...
    start_patience: float = Field(default=1.0, ge=0)  # ... for so many seconds of waiting; then ...
    patient_start_depths: int = 30  # ... so many do: as many as hold a frame in the map


class MappingConfig(Section):
    """Local mapping beside tracking."""

    covisible_points: int = 15  # shared points that make two keyframes covisible
    neighbours: int = 10  # best covisible keyframes for fusing, ...
    second_neighbours: int = 2  # ... and of each of them its own best ones
    triangulated_neighbours: int = 10  # best covisible keyframes searched for new points without near depth; 0: none
    triangulation_ratio: float = Field(default=0.8, gt=0)  # best over second best along an epipolar line, same level
    max_depth_uncertainty: float = Field(default=0.1, gt=0)  # share of its depth to which a new point must be known
    scale_tolerance: float = Field(default=1.8, ge=1)  # factor between ratios of distances and of pyramid levels
    min_triangulated_observations: int = 3  # keyframes; as `min_observations`, for points that two rays alone made
    fuse_hamming: int = 60  # bits; a fused point must look the same
    fuse_radius: float = 3.0  # pixels at the finest level
    adjusted_keyframes: int = 16  # most covisible keyframes that a local adjustment frees
    first_iterations: int = 4  # of local adjustment, before outliers go
    iterations: int = 3  # after
    min_found_share: float = 0.25  # of the frames that should see a new point and do
    min_observations: int = 2  # keyframes that must see a point two keyframes after its birth
    redundant_share: float = 0.9  # of a keyframe's close points seen by others: it goes
    redundant_observers: int = 3  # how many others must see each


class LevellingConfig(Section):
    """Levelling the map by the floor."""

    max_tilt: float = 0.7  # radians the first camera may look up or down or lean
    min_height: float = 0.25  # metres below the camera
    min_share: float = 0.05  # of the image that the surface must fill
    min_whole_share: float = 0.2  # of the surface's samples that have it all around
    min_spread: float = 0.15  # metres between the three samples of a hypothesis; nearer ones are noise
    hypotheses: int = 600  # planes tried; a tenth of the samples on the floor gives one good one in two hundred
    thickness: float = 0.015  # metres off the plane that still agree at the camera, ...
    thickness_quadratic: float = 0.003  # ... and metres a square metre more with depth
    max_views: int = 15  # keyframes whose floors are averaged


class SlamConfig(Section):
    """RGB-D visual SLAM."""

    features: FeatureConfig = FeatureConfig()
    noise: SensorNoiseConfig = SensorNoiseConfig()
    shutter: ShutterConfig = ShutterConfig()
    delay: DepthDelayConfig = DepthDelayConfig()
    ranges: DepthRangeConfig = DepthRangeConfig()
    tracking: TrackingConfig = TrackingConfig()
    surfaces: SurfaceConfig = SurfaceConfig()
    pictures: PictureConfig = PictureConfig()
    far_points: FarPointConfig = FarPointConfig()
    turning: TurningConfig = TurningConfig()
    places: PlacesConfig = PlacesConfig()
    locating: LocatingConfig = LocatingConfig()
    fitting: FittingConfig = FittingConfig()
    keyframes: KeyframeConfig = KeyframeConfig()
    mapping: MappingConfig = MappingConfig()
    loops: LoopConfig = LoopConfig()
    levelling: LevellingConfig = LevellingConfig()
