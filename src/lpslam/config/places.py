"""Thresholds of places: where in the map a view was taken, and where the map meets itself."""

from lpslam.config.section import Field, Section


class FittingConfig(Section):
    """Laying the map's points on the surfaces that a view's depth shows, from where a sign says that it was taken."""

    width: int = Field(default=160, ge=16)  # pixels across; the median of nine readings has a third of their noise
    slope_pixels: int = Field(default=2, ge=1)  # pixels to the neighbours by which a surface's slope is measured
    edge: float = Field(default=0.1, gt=0)  # of the depth; neighbours that differ by more are of two surfaces
    sign_pixels: int = Field(default=4, ge=1)  # pixels about a sign's middle whose surface is the sign's, at least
    sign_metres: float = Field(default=0.05, gt=0)  # sigma of where a sign stands in the map, ...
    loosening: float = Field(default=6.0, ge=1)  # ... times so much in the second half: it is read late
    start_metres: float = Field(default=0.15, gt=0)  # sigma of a pose without a sign, the same, ...
    start_radians: float = Field(default=0.05, gt=0)  # ... and of its turn: the drift of some frames without the map
    looks_doubt: float = Field(
        default=4.0, ge=1
    )  # times these, of a pose by what looks alike: far walls tell no better
    fresh_seconds: float = Field(default=0.5, ge=0)  # for which a sign is where it was seen in the picture, about
    steps: int = Field(default=30, ge=1)  # of Gauss-Newton
    first_metres: float = Field(default=0.4, gt=0)  # at 3 m, by which a point may lie off its surface first, ...
    narrowing: float = Field(default=0.8, gt=0, lt=1)  # ... times so much with each step, ...
    least_metres: float = Field(default=0.06, gt=0)  # ... down to so much: points of a map are no better known
    least_points: int = Field(default=40, ge=6)  # on surfaces; fewer lie on some anywhere
    least_agreement: float = Field(default=0.8, ge=0, le=1)  # of the points on surfaces or before them, share on them
    strays: float = Field(default=0.15, gt=0)  # metres by which the pose by keypoints may differ from that by surfaces


class LocatingConfig(Section):
    """Finding the pose of a view from its appearance alone: after loss, for loops and for merging."""

    matched_keyframes: int = Field(default=4, ge=1)  # the candidate and its best covisible ones, matched by descriptor
    guided_keyframes: int = Field(default=15, ge=1)  # the same, whose points are then searched by projection
    min_matches: int = Field(default=15, ge=4)  # by descriptor; fewer are chance
    trials: int = Field(default=300, ge=1)  # RANSAC hypotheses at most; half wrong matches need about 100
    trial_pixels: float = Field(default=8.0, gt=0)  # reprojection error of a hypothesis' inliers, pixels
    min_trial_inliers: int = Field(default=12, ge=4)  # fewer agree by chance
    wide_search: float = Field(default=3.0, ge=1)  # factor on the tracking windows in the first guided search
    guess_search: float = Field(default=8.0, ge=1)  # the same around a pose that signs tell: 20 to 30 pixels
    anchor_reach: float = Field(default=2.0, gt=0)  # metres around a sign in which its keypoints are matched: one front
    min_anchored: int = Field(default=6, ge=1)  # of them that must agree with it on a pose
    min_inliers: int = Field(default=50, ge=10)  # map points that must agree in the end; a wrong place ruins the map
    hidden_share: float = Field(default=0.1, gt=0, lt=1)  # nearer by this share of the depth hides a map point
    depth_tolerance: float = Field(default=0.06, gt=0)  # share of the depth by which map and sensor may differ
    min_depth_agreement: float = Field(default=0.7, ge=0, le=1)  # share of the inliers that must agree in depth
    min_alike_agreement: float = Field(default=0.65, ge=0, le=1)  # of what looks alike, at least, must be seen there
    min_unique_agreement: float = Field(
        default=0.3, ge=0, le=1
    )  # of it, at least, that looks so nowhere else in the map
    max_missing_share: float = Field(default=0.2, ge=0, le=1)  # of what should be seen, where nothing of it is seen
    min_seen_share: float = Field(default=0.1, ge=0, le=1)  # of what should be seen; real rooms show little again
    min_told_share: float = Field(default=0.05, ge=0, le=1)  # the same where signs tell: afar, corners are others
    looked_at: int = Field(default=120, ge=1)  # points that a picture is asked for: they tell a share to a tenth
    looked_around: int = Field(default=2, ge=0)  # pixels around its place, on its level, in which a point may stand
    looked_beside: int = Field(default=24, ge=1)  # pixels, the same, to the places with which its own is compared
    min_there_share: float = Field(default=0.5, ge=0, le=1)  # of them, at least, that stand there: most, ...
    looked_for: int = Field(default=400, ge=1)  # points, where it is asked whether something of a place is not there
    looked_together: int = Field(default=20, ge=4)  # of them that stand together: a sign beside a door
    # Times as likely that a group is not there as that it is, over all groups: up to 60,000 at right places, parts of
    # which light and side make less like than others; from 10^7 on at most look-alikes.
    lacking_odds: float = Field(default=1e6, gt=1)
    there_lead: float = Field(default=0.1, ge=0, le=1)  # ... unless of another place so much more does
    spread_cells: int = Field(default=4, ge=1)  # rows and columns of the image by which spread is judged ...
    min_spread: int = Field(default=6, ge=1)  # ... and how many of the cells must hold an inlier
    rival_share: float = Field(default=0.6, ge=0, le=1)  # of the best place's inliers that make another one a rival ...
    rival_distance: float = Field(default=0.5, ge=0)  # ... if it is farther off than this, metres
    rival_evidence: float = Field(default=2.0, ge=0)  # sigmas by which a view must speak for the one place against it
    sure_inliers: int = Field(default=100, ge=10)  # that are believed at once, if ...
    sure_alike_agreement: float = Field(default=0.8, ge=0, le=1)  # ... so much of what looks alike is there; else ...
    sure_views: int = Field(default=3, ge=1)  # ... so many views in a row must find the same place
    agreement_distance: float = Field(default=0.1, gt=0)  # metres by which one place may differ in the next frame
    disowned_radius: float = Field(default=3.0, ge=0)  # metres around a place that signs have spoken against


class PlacesConfig(Section):
    """From scores of single keyframes to places."""

    considered: int = Field(default=30, ge=1)  # best keyframes that may stand for a place
    group: int = 10  # best covisible keyframes whose scores count with a keyframe's own
    least_share: float = Field(default=0.75, ge=0, le=1)  # of the best place's score together that a place must have


class LoopConfig(Section):
    """Knowing again a place that was mapped before, and making the map one there."""

    min_keyframes_apart: int = Field(default=10, ge=1)  # keyframes; nearer ones are the way just walked, not a return
    pause: int = 10  # keyframes after closing a loop in which none is looked for: what was fused must settle
    covisible_points: int = Field(default=15, ge=1)  # shared points of keyframes that belong to one place
    candidates: int = Field(default=3, ge=1)  # most places tried a keyframe; each costs a brute-force matching
    merge_candidates: int = Field(default=3, ge=0)  # keyframes of other sub-maps tried however little they look alike
    last_views: int = Field(default=100, ge=0)  # of smaller sub-maps at most, from which the rest is sought at the end
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
