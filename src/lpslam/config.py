"""Every threshold that the paper or this project names, in one typed tree.

Defaults live here; a YAML file may override any of them (`Config.from_yaml`). Units are in the names or the comment.
"""

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, field_validator

from lpslam.errors import UserError


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @field_validator("*")
    @classmethod
    def _refuse_negative(cls, value: Any) -> Any:
        """None of the thresholds means anything below nought."""
        if isinstance(value, int | float) and value < 0:
            raise ValueError("must not be negative")
        return value


class FeatureConfig(_Section):
    """ORB features and their depth."""

    count: int = Field(default=1000, ge=1)  # keypoints a frame; fewer lose accuracy in poor texture, more cost time
    levels: int = Field(default=8, ge=2, le=16)  # pyramid levels
    scale_factor: float = Field(default=1.2, gt=1)  # size of a level over the next
    fast_threshold: int = 20  # grey values a corner's arc must differ by
    fast_threshold_in_empty_cell: int = 7  # grey values, where the first threshold finds nothing
    cell_pixels: int = Field(default=35, ge=1)  # side of the cells in which the threshold adapts
    virtual_baseline: float = Field(default=0.08, gt=0)  # metres; scales u_r only, weights come from the noise model
    min_depth: float = 0.3  # metres; structured-light and stereo sensors are blind below
    max_depth: float = 8.0  # metres; beyond, the noise of consumer sensors exceeds 15 cm
    depth_edge_radius: int = 2  # pixels of the neighbourhood in which a depth must agree
    depth_edge_tolerance: float = 0.03  # share of the depth; more is an edge, whose depth may be the other side's


class SpottingConfig(_Section):
    """Finding and reading text in one image (III-B)."""

    # OpenVINO where it is installed, ONNX Runtime elsewhere; both give the same texts.
    engine: Literal["auto", "openvino", "onnxruntime"] = "auto"
    # Threads of the engine: one leaves the other core to tracking.
    threads: int = Field(default=1, ge=1)
    # Longest image side the detector sees, pixels; enlarging small images costs more than it finds.
    detection_side: int = Field(default=960, ge=64)
    # DBNet's published thresholds: a pixel is text above the first, a box is kept above the second mean probability.
    text_probability: float = Field(default=0.3, gt=0, lt=1)
    box_score: float = Field(default=0.5, ge=0, le=1)
    # By how much a region is grown back, times area over perimeter (the network learns shrunk regions).
    growth_ratio: float = Field(default=1.6, ge=0)
    # Share of its smallest rectangle below which a region's own quadrilateral is used: text seen aslant is none.
    slant_area: float = Field(default=0.9, ge=0, le=1)
    # Smallest side of a region in the probability map, pixels: smaller ones are specks.
    min_region_side: float = Field(default=3.0, ge=0)
    # Most boxes of one image; beyond it the image is texture, not text.
    max_boxes: int = Field(default=200, ge=1)
    # Share of width and height at the image's rim that a box must not touch: text cut off there misleads (Fig. 11).
    border_margin: float = Field(default=0.02, ge=0, lt=0.5)
    # Boxes lower than this, pixels, are not read: their letters are guesses.
    min_letter_height: float = Field(default=10.0, ge=0)
    # Widest rectified line, pixels at 48 pixels high; longer lines are squeezed.
    max_line_width: int = Field(default=1280, ge=48)
    # Lines recognised at once.
    recognition_batch: int = Field(default=4, ge=1)
    # Texts surer than this are kept (0 to 1); below it most are texture.
    min_confidence: float = Field(default=0.6, ge=0, le=1)
    # Fewest letters or digits of a text: single ones are mostly logos ("A").
    min_letters: int = Field(default=2, ge=1)
    # Longest text kept, characters; scene text is untrusted.
    max_length: int = Field(default=80, ge=1)


class MemoryConfig(_Section):
    """Similarity classification and long-short-term memory (III-C, III-D)."""

    # Eq. 3 similarity from which two texts are held to be homologous.
    similarity: float = Field(default=0.6, ge=0, le=1)
    # The same for texts read at a spot where the class was read before: being there is evidence too.
    similarity_in_place: float = Field(default=0.4, ge=0, le=1)
    # Score at which a class moves to long-term memory; a sighting adds its confidence, so three sure ones are enough.
    promotion: float = Field(default=2.3, gt=0)
    # Largest score, so that what was looked at for long can still be forgotten.
    ceiling: float = Field(default=10.0, gt=0)
    # What forgetting takes from every class's score in each frame at 30 frames a second (0.006 = 0.18 a second).
    forgetting: float = Field(default=0.006, ge=0)
    # Seconds between sightings that count in full; quicker ones see the same picture again and count for their share.
    full_sighting_interval: float = Field(default=0.15, gt=0)
    # What a sighting counts at most: one that comes twice that long after the last, and says the same, is a look of its
    # own and no repeated slip. Where frames are few, two sure ones are enough.
    independent_weight: float = Field(default=1.5, ge=1)
    # Longest score history of a class, samples; thinned by half when full.
    history: int = Field(default=512, ge=8)


class PlacementConfig(_Section):
    """Where a text box stands (III-F)."""

    # Share of the box, about its centre, whose depth is used: detected boxes are looser than the board.
    inner_share: float = Field(default=0.85, gt=0, le=1)
    # Depths that are believed, metres.
    min_depth: float = Field(default=0.3, gt=0)
    max_depth: float = Field(default=10.0, gt=0)
    # Most pixels of a box that enter the plane fit.
    samples: int = Field(default=600, ge=16)
    # Fewest pixels with depth, and the share of the box's pixels they must be.
    min_samples: int = Field(default=12, ge=3)
    min_depth_share: float = Field(default=0.15, ge=0, le=1)
    # Triples tried by the plane fit.
    trials: int = Field(default=64, ge=1)
    # Inlier band of the plane in inverse depth, 1/m: three sigma of a sensor whose error is 2.2 mm x depth squared.
    inverse_depth_band: float = Field(default=0.008, gt=0)
    # Share of the depths that must agree with the plane; below it the median depth is used instead.
    min_inlier_share: float = Field(default=0.5, gt=0, le=1)
    # What lies beyond an end of the text, and nearer than its surface by more than so many metres plus so large a share
    # of the depth, hides the rest of it; steps less than that are frames and mouldings. Half of the pixels must agree,
    # so the noise of one, 10 cm at 6 m, is no reason for more.
    hiding_step: float = Field(default=0.1, ge=0)
    hiding_step_share: float = Field(default=0.01, ge=0)
    # Share of the pixels beyond an end that must be nearer.
    hiding_share: float = Field(default=0.5, gt=0, le=1)
    # Share of the pixels of an end of the text that must lie off its plane, by as much, for it to be two texts.
    stepping_share: float = Field(default=0.7, gt=0, le=1)
    # Steepest view of a surface that is believed, degrees between ray and normal.
    max_view_angle: float = Field(default=80.0, gt=0, lt=90)


class InstanceConfig(_Section):
    """From observations to places (III-H)."""

    # Rounds of trimming and the share of farthest observations dropped in each (the paper's 20 %).
    rounds: int = Field(default=3, ge=0)
    drop_share: float = Field(default=0.2, ge=0, lt=1)
    # Observations of one class farther apart than this, metres, are different places.
    place_distance: float = Field(default=1.0, gt=0)
    # How far apart, metres, opposite facings count as: more than place_distance, so a text faces one way.
    facing_distance: float = Field(default=1.2, ge=0)
    # Opposite facings no farther apart than this, metres, are the two sides of one sign.
    sign_thickness: float = Field(default=0.3, ge=0)
    # Fewest observations of a place, unless the class has no other.
    min_observations: int = Field(default=2, ge=1)
    # Two texts that overlap by more than this share of the smaller are readings of the same paint.
    overlap: float = Field(default=0.5, gt=0, le=1)
    # Lines of one board: gap between them in letter heights, and largest ratio of their letter heights.
    line_gap: float = Field(default=0.9, ge=0)
    line_height_ratio: float = Field(default=3.0, ge=1)
    # Distance of their surfaces, metres, and angle between their normals, degrees, that lines of one board may have.
    line_offset: float = Field(default=0.08, ge=0)
    line_angle: float = Field(default=30.0, ge=0)
    # Largest difference of their grounds' colours, as a share of the brighter (0.01 to 0.05 on one board): two books
    # may lie on one table.
    line_ground_difference: float = Field(default=0.15, ge=0)
    # Box height, pixels, at which a text must have been seen once to be a landmark: letters of 10 pixels.
    min_landmark_height: float = Field(default=15.0, ge=0)
    # The same for texts without a Latin letter: Chinese that is smaller is misread, often as digits.
    min_landmark_height_ideographs: float = Field(default=20.0, ge=0)
    # Texts that move faster than this, metres a second, over at least so many metres, are carried by someone.
    carried_speed: float = Field(default=0.2, gt=0)
    carried_distance: float = Field(default=0.4, gt=0)


class ReadingConfig(_Section):
    """Which frames are read."""

    # Seconds between frames that are read; a text needs three sightings while the camera passes.
    interval: float = Field(default=0.165, ge=0)
    # The same after a text was seen that was read fewer times than follows, for so many seconds: it may be gone soon.
    new_text_interval: float = Field(default=0.06, ge=0)
    new_text_patience: float = Field(default=0.5, ge=0)
    # Readings of a text at its place after which it is only read again when it is seen better than before.
    settled_sightings: int = Field(default=8, ge=1)
    # A frame is blurred when its variance of the Laplacian is below this share of the running median ...
    blur_share: float = Field(default=0.35, ge=0)
    # ... of so many frames; reading then waits for a sharper one, no longer than so many intervals.
    blur_window: int = Field(default=15, ge=1)
    blur_patience: float = Field(default=2.0, ge=0)
    # Share of the time that live reading may take: on two cores, tracking, mapping and the camera need the rest.
    live_share: float = Field(default=0.7, gt=0, le=1)
    # Frames worth reading that may wait beside tracking (2 MB each); the oldest is dropped when one more comes.
    queue_size: int = Field(default=64, ge=1)


class AdviceConfig(_Section):
    """What texts tell loop closing: which places to try, and which cannot be the same."""

    # Whether loop closing is told at all.
    enabled: bool = True
    # Keyframes up to the newest whose texts stand for where the camera is, ...
    recent_keyframes: int = Field(default=12, ge=1)
    # ... in so many metres around it: farther ones are as uncertain as the way to them.
    reach: float = Field(default=10.0, gt=0)
    # Keyframes of the same sub-map nearer than this are the way just walked, not a return.
    apart_keyframes: int = Field(default=30, ge=1)
    # Readings of a text at its place that propose, and that veto: a slip comes once or twice.
    min_sightings: int = Field(default=2, ge=1)
    veto_sightings: int = Field(default=3, ge=1)
    # Mean confidence of readings that veto, and the share of them that must say nearly the same.
    veto_confidence: float = Field(default=0.85, ge=0, le=1)
    veto_unanimity: float = Field(default=0.7, ge=0, le=1)
    # Sightings of a class nearer than this, metres, are one text; texts nearer than this are one board and count once.
    same_place: float = Field(default=0.6, gt=0)
    board_size: float = Field(default=0.5, ge=0)
    # Metres and degrees by which two texts may stand otherwise to one another than two texts read before.
    distance_tolerance: float = Field(default=0.3, gt=0)
    facing_tolerance: float = Field(default=25.0, gt=0, lt=90)
    # A text that stands at n places counts 1/n; a constellation must count as much as this to propose.
    min_rarity: float = Field(default=1.0, gt=0)
    # Most keyframes proposed at a time, and how far, metres and degrees, they may be from where the texts say.
    proposals: int = Field(default=2, ge=0)
    view_distance: float = Field(default=3.0, gt=0)
    view_turn: float = Field(default=45.0, gt=0)
    # Eq. 3 similarity from which texts agree, and below which they contradict each other.
    alike: float = Field(default=0.5, ge=0, le=1)
    unlike: float = Field(default=0.35, ge=0, le=1)
    # Texts in the same spot that must contradict each other, while none agrees, for a veto.
    contradictions: int = Field(default=2, ge=2)


class TextConfig(_Section):
    """Reading and remembering (III-B to III-H)."""

    reading: ReadingConfig = ReadingConfig()
    spotting: SpottingConfig = SpottingConfig()
    memory: MemoryConfig = MemoryConfig()
    placement: PlacementConfig = PlacementConfig()
    instances: InstanceConfig = InstanceConfig()
    advice: AdviceConfig = AdviceConfig()


class SensorNoiseConfig(_Section):
    """How far keypoints and depth readings stray: the weights of every adjustment."""

    pixel_sigma: float = Field(default=0.7, gt=0)  # pixels, at any level: blur, rolling shutter, depth registration
    level_pixel_sigma: float = Field(default=0.5, gt=0)  # pixels of the level at which a corner is found: its rounding
    depth_sigma: float = Field(default=0.003, gt=0)  # metres, at any distance: registration and rounding
    depth_sigma_quadratic: float = 0.0035  # metres a square metre: disparity noise of structured light and stereo


class TrackingConfig(_Section):
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
    local_keyframes: int = 60  # most covisible keyframes whose points are searched
    pose_rounds: int = Field(default=4, ge=1)  # rounds of outlier judgement
    pose_iterations: int = 10  # Gauss-Newton steps a round at most
    doubtful_share: float = Field(default=0.7, ge=0, le=1)  # of the matches; fewer agree, and a majority is looked for
    majority_trials: int = Field(default=100, ge=1)  # RANSAC hypotheses at most; half wrong matches need about 70
    min_judges: int = Field(default=30, ge=4)  # points seen by two keyframes; from so many on only they make a majority
    majority_pixels: float = Field(default=4.0, gt=0)  # reprojection error of those who agree, before refinement
    blur_ratio: float = 0.35  # share of the usual gradient energy below which a frame is called blurred
    followed_points: int = Field(default=250, ge=0)  # keypoints followed by optical flow between ORB frames; 0: never
    flow_window: int = Field(default=15, ge=5)  # pixels; side of the patch that is followed
    flow_levels: int = Field(default=2, ge=0)  # pyramid levels above the image: 2 reach 30 px beyond the prediction
    flow_steps: int = Field(default=12, ge=1)  # iterations a level at most
    flow_precision: float = Field(default=0.03, gt=0)  # pixels; a smaller step ends the iteration
    min_agreement: float = Field(default=0.6, ge=0, le=1)  # share of what is followed that one motion must explain
    min_followed: int = 60  # inliers; fewer, and the frame is matched with the map at once
    min_followed_share: float = Field(default=0.7, ge=0, le=1)  # of those followed first, the same
    anchor_interval: float = Field(default=0.09, ge=0)  # seconds after which a frame is matched with the map anyway
    strict_seconds: float = 1.0  # after relocalising, in which `min_recovery_inliers` must be matched
    predictable_gap: float = Field(default=0.08, gt=0)  # seconds between frames; more, and a turn has changed its pace
    long_gap: float = Field(default=0.3, gt=0)  # seconds without frames after which the same: nothing was predicted
    recovery_candidates: int = Field(default=4, ge=1)  # places tried a frame when lost
    doubt_seconds: float = Field(default=3.0, ge=0)  # after relocalising, in which signs may speak against the place
    submap_after: float = Field(default=1.0, ge=0)  # seconds of usable but unknown views after which a sub-map begins


class KeyframeConfig(_Section):
    """When a frame becomes a keyframe."""

    max_interval: float = 1.0  # seconds after which a keyframe is wanted whatever is seen
    min_interval: float = 0.1  # seconds; denser ones see the same
    tracked_share: float = 0.8  # of the most matches since the last keyframe; fewer, and a keyframe is wanted
    due_share: float = 0.95  # the same, once `max_interval` has passed
    known_matches: int = 150  # map points matched, from which a view may be known already ...
    known_distance: float = 0.08  # ... where a keyframe is nearer than this, metres, ...
    known_turn: float = 0.12  # ... and looks the same way within this angle, radians
    close_depth: float = 3.5  # metres; nearer points fix translation
    close_tracked: int = 100  # fewer close points tracked, and ...
    close_untracked: int = 70  # ... more close keypoints without a point: a keyframe is wanted
    point_depth: float = 5.0  # metres; nearer keypoints become points, weighted by their depth's noise
    points_in_view: int = 500  # map points a keyframe should see; farther keypoints become points until it does
    min_start_depths: int = 150  # keypoints with depth that the first keyframe needs


class MappingConfig(_Section):
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


class LocatingConfig(_Section):
    """Finding the pose of a view from its appearance alone: after loss, for loops and for merging."""

    matched_keyframes: int = Field(default=4, ge=1)  # the candidate and its best covisible ones, matched by descriptor
    guided_keyframes: int = Field(default=15, ge=1)  # the same, whose points are then searched by projection
    min_matches: int = Field(default=15, ge=4)  # by descriptor; fewer are chance
    trials: int = Field(default=300, ge=1)  # RANSAC hypotheses at most; half wrong matches need about 100
    trial_pixels: float = Field(default=8.0, gt=0)  # reprojection error of a hypothesis' inliers, pixels
    min_trial_inliers: int = Field(default=12, ge=4)  # fewer agree by chance
    wide_search: float = Field(default=3.0, ge=1)  # factor on the tracking windows in the first guided search
    guess_search: float = Field(default=8.0, ge=1)  # the same around a pose that signs tell: 20 to 30 pixels
    min_inliers: int = Field(default=50, ge=10)  # map points that must agree in the end; a wrong place ruins the map
    hidden_share: float = Field(default=0.1, gt=0, lt=1)  # nearer by this share of the depth hides a map point
    depth_tolerance: float = Field(default=0.06, gt=0)  # share of the depth by which map and sensor may differ
    min_depth_agreement: float = Field(default=0.7, ge=0, le=1)  # share of the inliers that must agree in depth
    min_seen_share: float = Field(default=0.25, ge=0, le=1)  # of the points that should be seen from there
    spread_cells: int = Field(default=4, ge=1)  # rows and columns of the image by which spread is judged ...
    min_spread: int = Field(default=6, ge=1)  # ... and how many of the cells must hold an inlier
    rival_share: float = Field(default=0.6, ge=0, le=1)  # of the best place's inliers that make another one a rival ...
    rival_distance: float = Field(default=0.5, ge=0)  # ... if it is farther off than this, metres: neither is believed
    disowned_radius: float = Field(default=3.0, ge=0)  # metres around a place that signs have spoken against


class PlacesConfig(_Section):
    """From scores of single keyframes to places."""

    considered: int = Field(default=30, ge=1)  # best keyframes that may stand for a place
    group: int = 10  # best covisible keyframes whose scores count with a keyframe's own
    least_share: float = Field(default=0.75, ge=0, le=1)  # of the best place's score together that a place must have


class LoopConfig(_Section):
    """Knowing again a place that was mapped before, and making the map one there."""

    min_keyframes_apart: int = Field(default=10, ge=1)  # keyframes; nearer ones are the way just walked, not a return
    pause: int = 10  # keyframes after closing a loop in which none is looked for: what was fused must settle
    covisible_points: int = Field(default=15, ge=1)  # shared points of keyframes that belong to one place
    candidates: int = Field(default=3, ge=1)  # most places tried a keyframe; each costs a brute-force matching
    votes: int = Field(default=3, ge=1)  # keyframes that must find the same correction, each by its own keypoints
    vote_neighbours: int = 4  # covisible keyframes asked at once; else the next keyframes are waited for
    vote_distance: float = 0.1  # metres between keyframes that vote, or ...
    vote_turn: float = 4.0  # ... degrees: the same picture twice is no second witness
    patience: int = 2  # keyframes that may fail to see a place before its votes are forgotten
    agreement_distance: float = Field(default=0.08, gt=0)  # metres by which votes may differ: noise at 4 m and drift
    agreement_turn: float = Field(default=1.5, gt=0)  # degrees, the same
    drift_allowance: float = 0.3  # metres that a correction may measure however short the way, ...
    drift_share: float = 0.04  # ... and more by this share of it: RGB-D drifts by one or two per cent
    turn_allowance: float = 5.0  # degrees, the same, ...
    turn_rate: float = 0.5  # ... and degrees a metre
    seam_keyframes: int = Field(default=15, ge=1)  # on either side of the seam, between which duplicates are fused
    essential_points: int = Field(default=100, ge=1)  # shared points that make two keyframes an edge of the pose graph
    loop_weight: float = Field(default=100.0, gt=0)  # of a verified tie over a metre walked: drift belongs to the way
    lever: float = Field(default=3.0, gt=0)  # metres that a radian counts as: the distance of what is seen
    iterations: int = Field(default=20, ge=1)  # of the pose graph at most; it takes three or four
    first_adjusting: int = 4  # iterations of the full adjustment before outliers go, ...
    adjusting: int = 6  # ... and after


class LevellingConfig(_Section):
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


class SlamConfig(_Section):
    """RGB-D visual SLAM."""

    features: FeatureConfig = FeatureConfig()
    noise: SensorNoiseConfig = SensorNoiseConfig()
    tracking: TrackingConfig = TrackingConfig()
    places: PlacesConfig = PlacesConfig()
    locating: LocatingConfig = LocatingConfig()
    keyframes: KeyframeConfig = KeyframeConfig()
    mapping: MappingConfig = MappingConfig()
    loops: LoopConfig = LoopConfig()
    levelling: LevellingConfig = LevellingConfig()


class SimulationConfig(_Section):
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


class EvaluationConfig(_Section):
    """When an estimate counts as right."""

    # Seconds between two poses that are compared: at most two thirds of a frame.
    association_tolerance: float = Field(default=0.02, gt=0)
    # Eq. 3 similarity of a landmark's name with a sign's text: one letter in five may be wrong.
    name_similarity: float = Field(default=0.8, gt=0, le=1)
    # Metres between a landmark and the sign that it is.
    landmark_distance: float = Field(default=1.0, gt=0)
    # Fewest frames in which a sign must be readable before it is expected in the map.
    readable_frames: int = Field(default=10, ge=0)
    # Degrees between a landmark's normal and its sign's.
    facing_angle: float = Field(default=10.0, gt=0)
    # Metres from which two signs of the same words are two places.
    duplicate_distance: float = Field(default=2.0, ge=0)


class LanguageConfig(_Section):
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
    # Names of landmarks that a question is put with; of a larger map, those that fit best and one of every kind.
    landmarks_sent: int = Field(default=60, ge=1, le=9000)
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


class CalibrationCheckConfig(_Section):
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


class CameraMatchConfig(_Section):
    """How far two calibrations of one camera may differ, for a recording to be used with a saved map."""

    # Share of the focal length: calibrating the same camera twice gives as much.
    focal_share: float = Field(default=0.01, gt=0)
    # Pixels of the principal point, the same.
    centre_pixels: float = Field(default=8.0, gt=0)
    # Pixels by which two distortions may place the same ray apart, anywhere in the image.
    distortion_pixels: float = Field(default=5.0, gt=0)


class LiveConfig(_Section):
    """Frames as they come from a camera."""

    # Frames that may wait while tracking is busy, a tenth of a second at 30 a second: a delay is better than a gap.
    backlog: int = Field(default=3, ge=1)


class Config(_Section):
    """The whole tree."""

    calibration: CalibrationCheckConfig = CalibrationCheckConfig()

    same_camera: CameraMatchConfig = CameraMatchConfig()

    language: LanguageConfig = LanguageConfig()

    evaluation: EvaluationConfig = EvaluationConfig()

    live: LiveConfig = LiveConfig()

    simulation: SimulationConfig = SimulationConfig()

    slam: SlamConfig = SlamConfig()

    text: TextConfig = TextConfig()

    @classmethod
    def from_yaml(cls, path: Path) -> "Config":
        """Read overrides from a YAML file; unknown or ill-typed keys are a `UserError`."""
        import yaml

        try:
            tree: Any = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
            return cls.model_validate(tree)
        except OSError as error:
            raise UserError(f"configuration {path} cannot be read ({error.strerror})") from error
        except UnicodeDecodeError as error:
            raise UserError(f"configuration {path} is not a text file; write it as YAML in UTF-8") from error
        except yaml.YAMLError as error:
            raise UserError(f"configuration {path} is not YAML: {' '.join(str(error).split())}") from error
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UserError(f"configuration {path}: {where}: {first['msg']}") from error
