"""Thresholds of reading and remembering."""

from typing import Literal

from lpslam.config.section import Field, PositiveFloat, Section


class SpottingConfig(Section):
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
    # The same mean of a bent region itself, from which it is a box although its rectangle's is less: of letters on an
    # arc half of the rectangle is empty. Those of drawn boards have 0.63 to 0.84.
    arc_score: float = Field(default=0.55, ge=0, le=1)
    # By how much a region is grown back, times area over perimeter (the network learns shrunk regions).
    growth_ratio: float = Field(default=1.6, ge=0)
    # Share of its smallest rectangle below which a region's own quadrilateral is used: text seen aslant is none.
    slant_area: float = Field(default=0.9, ge=0, le=1)
    # Smallest side of a region in the probability map, pixels: smaller ones are specks.
    min_region_side: float = Field(default=3.0, ge=0)
    # Most boxes of one image; beyond it the image is texture, not text.
    max_boxes: int = Field(default=200, ge=1)
    # Boxes lower than this, pixels, are not read: their letters are guesses.
    min_letter_height: float = Field(default=10.0, ge=0)
    # Widest rectified line, pixels at 48 pixels high; longer lines are squeezed.
    max_line_width: int = Field(default=1280, ge=48)
    # Widths of a letter, in its heights, below which a line is read again as wide as letters are from straight ahead:
    # the network takes a step every sixth of the height, and a letter needs two.
    narrow_letters: float = Field(default=0.3, ge=0)
    widened_letters: float = Field(default=0.45, gt=0)
    # Lines recognised at once.
    recognition_batch: int = Field(default=4, ge=1)
    # Texts surer than this are kept (0 to 1); below it most are texture.
    min_confidence: float = Field(default=0.6, ge=0, le=1)
    # Fewest letters or digits of a text: single ones are mostly logos ("A"). An ideograph, a word of its own, counts
    # for two.
    min_letters: int = Field(default=2, ge=1)
    # Longest text kept, characters; scene text is untrusted.
    max_length: int = Field(default=500, ge=1)


class MemoryConfig(Section):
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
    # Readings of one view repeat their slips: n of them are worth n to this power. After so many seconds without a
    # sighting, the next one belongs to another visit, and so to another view.
    repetition: float = Field(default=0.4, ge=0, le=1)
    visit_pause: float = Field(default=2.0, gt=0)
    # Longest score history of a class, samples; thinned by half when full.
    history: int = Field(default=512, ge=8)


class PlacementConfig(Section):
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
    # Share of the text's length that must have so much: one who walks by has it on a few letters alone.
    min_covered_share: float = Field(default=0.5, ge=0, le=1)
    # Where a sign gives no depth, its surface is sought so many letter heights around it: first in the depth image, ...
    surroundings: float = Field(default=1.0, gt=0)
    # ... then among the map's points, of which so many must lie there.
    surroundings_of_points: float = Field(default=3.0, gt=0)
    min_points: int = Field(default=8, ge=3)
    # Share of what is around a slanted text that must lie at depths between those of its ends: else it is two things.
    between_share: float = Field(default=0.1, ge=0, le=1)
    # Metres, standard deviation: a sign need not lie in the surface around it.
    surroundings_uncertainty: float = Field(default=0.3, ge=0)
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


class InstanceConfig(Section):
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
    # Texts farther apart than so many letter heights, edge to edge, are not asked whether they are on one board.
    board_reach: float = Field(default=6.0, gt=0)
    # Box height, pixels, at which a text must have been seen once to be a landmark: letters of 10 pixels.
    min_landmark_height: float = Field(default=15.0, ge=0)
    # The same for texts without a Latin letter: Chinese that is smaller is misread, often as digits.
    min_landmark_height_ideographs: float = Field(default=20.0, ge=0)
    # Probability that a text is all that is painted, where no view showed that it ends, from which it is a landmark:
    # below it is likelier a piece.
    least_whole: float = Field(default=0.5, ge=0, le=1)
    # Texts that move faster than this, metres a second, over at least so many metres, are carried by someone.
    carried_speed: float = Field(default=0.2, gt=0)
    carried_distance: float = Field(default=0.4, gt=0)
    # Positions more uncertain than this, metres, count only if none within so many metres is surer.
    doubtful_uncertainty: float = Field(default=0.2, gt=0)
    doubtful_distance: float = Field(default=3.0, ge=0)
    # Seconds without a sighting after which the next one belongs to another visit.
    visit_pause: float = Field(default=2.0, gt=0)


class ReadingConfig(Section):
    """Which frames are read."""

    # Seconds between frames that are read; a text needs three sightings while the camera passes.
    interval: float = Field(default=0.165, ge=0)
    # The same after a text was seen that was read fewer times than follows, for so many seconds: it may be gone soon.
    new_text_interval: float = Field(default=0.06, ge=0)
    new_text_patience: float = Field(default=0.5, ge=0)
    # In between only the part of the image is searched where such texts are, unless that is more than this share of it.
    window_share: float = Field(default=0.7, ge=0, le=1)
    # Readings of a text at its place after which it is only read again when it is seen better than before; half of
    # them where its name is this sure already.
    settled_sightings: int = Field(default=8, ge=1)
    settled_certainty: float = Field(default=0.97, ge=0, le=1)
    # Where it is not, half of them must be of letters as large as they are now but for this factor.
    unsure_better: float = Field(default=1.25, gt=1)
    # What said nothing in half as many views at its place is read again from so many times the size on: ...
    vain_better: float = Field(default=1.25, gt=1)
    # A text that is not found is read where it stands until so many more readings said something else than said it:
    # what fails so often goes on failing (of 49, 48 and 21 readings in a café 20, one and none said it).
    unfound_patience: int = Field(default=3, ge=1)
    # It is so where the way to the camera makes at least this cosine with its normal, and so many metres before the
    # camera: more aslant or nearer letters are not read.
    unfound_cosine: float = Field(default=0.5, ge=0, le=1)
    unfound_distance: float = Field(default=0.2, ge=0)
    # Seen better: so many times as large, in pixels of height times the cosine of the angle, until it is as large as
    # the recogniser can use; or reaching farther than any reading of it by this factor.
    better_size: float = Field(default=1.5, gt=1)
    full_size: float = Field(default=72.0, gt=0)
    # Box height, pixels, that is better than anything below it: what was never seen so large may not be believed
    # (`min_landmark_height_ideographs`).
    believed_height: float = Field(default=20.0, ge=0)
    longer: float = Field(default=1.15, gt=1)
    # A frame is blurred when its variance of the Laplacian is below this share of the running median ...
    blur_share: float = Field(default=0.35, ge=0)
    # ... of so many frames; reading then waits for a sharper one, no longer than so many intervals.
    blur_window: int = Field(default=15, ge=1)
    blur_patience: float = Field(default=2.0, ge=0)
    # Share of the time that live reading may take: on two cores, tracking, mapping and the camera need the rest.
    live_share: float = Field(default=0.7, gt=0, le=1)
    # Frames worth reading that may wait beside tracking; while so many do, a recording waits. With more, tracking runs
    # ahead of what decides how soon to read again.
    queue_size: int = Field(default=1, ge=1)
    # The same of a camera: the newest is read first, the others when none newer waits, and at the end, which takes ten
    # seconds where it is quick, and as many times as long as a frame takes longer. So many are worth reading in 13 s.
    live_queue_size: int = Field(default=96, ge=1)
    # Bytes that they may take: 24 frames as they are, or, packed as all but the newest soon are, two hundred.
    live_queue_bytes: int = Field(default=50_000_000, ge=1)


class PatternConfig(Section):
    """Which remembered texts are pieces of a pattern: by what was refused where they stand, and how they are spelt."""

    # Probability that what was read often enough to be remembered is a pattern, before anything else is known of it:
    # few walls have more friezes than signs.
    probability: float = Field(default=0.05, gt=0, lt=1)
    # The share of views that are refused, as beta distributions (refused, read). Of patterns any share is as likely as
    # any other; of texts it is one in two hundred in the mean, and of most none.
    refused_of_patterns: tuple[PositiveFloat, PositiveFloat] = (1.0, 1.0)
    refused_of_texts: tuple[PositiveFloat, PositiveFloat] = (0.05, 10.0)
    # Log odds for each piece close by that says the same, or has the same shapes, and how many of them count: motifs
    # come again along a wall, words hardly ever; a row of four says all that a longer one does.
    twin: float = Field(default=2.0, ge=0)
    most_twins: int = Field(default=3, ge=0)
    # Widths within which such a piece is close by: menus and exits repeat themselves farther apart.
    twin_reach: float = Field(default=4.0, ge=0)
    # Metres by which a pattern may stand before or behind a text that is read in it: both are placed by noisy depth.
    depth: float = Field(default=0.25, gt=0)
    # Share of the smaller of two boxes that both cover from which they are of one thing; boxes of one text in two views
    # share more, of neighbours less.
    covered: float = Field(default=0.5, gt=0, le=1)


class AdviceConfig(Section):
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
    # Share of a text's height by which a corner may be seen elsewhere than it stands: boxes are as loose as that.
    corner_tolerance: float = Field(default=0.5, gt=0)
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


class SecondLookConfig(Section):
    """Texts whose name stays unsure: read once more from all their views together."""

    # Whether crops are kept and looked at.
    enabled: bool = True
    # Names surer than this are not looked at again.
    sure: float = Field(default=0.97, ge=0, le=1)
    # Crops of a class: the mean of a dozen has a third of the noise, and more are nearly the same view.
    crops: int = Field(default=12, ge=1)
    # Bytes of one crop and of all; letters that fill more of the image are read at their full size anyhow.
    crop_bytes: int = Field(default=1 << 18, ge=1)
    all_bytes: int = Field(default=1 << 25, ge=1)
    # Height, pixels, at which a text is drawn, and the ground around it in heights: the detector looks for its ends.
    line_height: float = Field(default=48.0, gt=0)
    margin: float = Field(default=0.7, ge=0)
    # Longest side of the drawing, pixels.
    longest: int = Field(default=1280, ge=48)
    # Correlation with the sharpest view from which a view is averaged with it.
    alike: float = Field(default=0.6, ge=0, le=1)
    # Pixels that second looks may search, as a share of those that reading has searched.
    share: float = Field(default=0.15, ge=0)


class SightingConfig(Section):
    """Pictures of texts as they were seen best, kept in the map for whoever wants to see a sign."""

    # Whether they are kept.
    enabled: bool = True
    # Sightings of a class: of the places at which it may stand, and from two sides.
    of_class: int = Field(default=3, ge=1)
    # Times as large as the worst that is kept, from which one is kept instead: steps that an eye sees.
    better: float = Field(default=1.15, ge=1.0)
    # Letter heights around a text that are in its picture: the board, and what it hangs on.
    margin: float = Field(default=1.0, ge=0.0)
    # Pixels to a side at most: as wide as a card on a fine screen.
    width: int = Field(default=480, ge=16, le=4096)
    # Of JPEG: letters stay sharp, and a picture is about 15 KB.
    quality: int = Field(default=85, ge=1, le=100)
    # Bytes of all: some hundred boards.
    all_bytes: int = Field(default=1 << 23, ge=1)


class TextConfig(Section):
    """Reading and remembering (III-B to III-H)."""

    reading: ReadingConfig = ReadingConfig()
    spotting: SpottingConfig = SpottingConfig()
    memory: MemoryConfig = MemoryConfig()
    placement: PlacementConfig = PlacementConfig()
    instances: InstanceConfig = InstanceConfig()
    patterns: PatternConfig = PatternConfig()
    advice: AdviceConfig = AdviceConfig()
    again: SecondLookConfig = SecondLookConfig()
    sightings: SightingConfig = SightingConfig()
