"""Every threshold that the paper or this project names, in one typed tree.

Defaults live here; a YAML file may override any of them (`Config.from_yaml`). Units are in the names or the comment.
"""

from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lpslam.errors import UserError


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class FeatureConfig(_Section):
    """ORB features and their depth."""

    count: int = 1000  # keypoints a frame; fewer lose accuracy in poor texture, more cost time
    levels: int = 8  # pyramid levels
    scale_factor: float = 1.2  # size of a level over the next
    fast_threshold: int = 20  # grey values a corner's arc must differ by
    fast_threshold_in_empty_cell: int = 7  # grey values, where the first threshold finds nothing
    cell_pixels: int = 35  # side of the cells in which the threshold adapts
    virtual_baseline: float = 0.08  # metres; scales u_r only, weights come from the depth noise model
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
    # Smallest side of a region in the probability map, pixels: smaller ones are specks.
    min_region_side: float = Field(default=3.0, ge=0)
    # Most boxes of one image; beyond it the image is texture, not text.
    max_boxes: int = Field(default=200, ge=1)
    # Share of width and height at the image's rim that a box must not touch: text cut off there misleads (Fig. 11).
    border_margin: float = Field(default=0.01, ge=0, lt=0.5)
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
    # Score at which a class moves to long-term memory; a sighting adds its confidence, so three sure ones are enough.
    promotion: float = Field(default=2.3, gt=0)
    # Largest score, so that what was looked at for long can still be forgotten.
    ceiling: float = Field(default=10.0, gt=0)
    # What forgetting takes from every class's score in each frame at 30 frames a second (0.006 = 0.18 a second).
    forgetting: float = Field(default=0.006, ge=0)
    # Seconds between sightings that count in full; quicker ones see the same picture again and count for their share.
    full_sighting_interval: float = Field(default=0.15, gt=0)
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
    # Steepest view of a surface that is believed, degrees between ray and normal.
    max_view_angle: float = Field(default=80.0, gt=0, lt=90)


class InstanceConfig(_Section):
    """From observations to places (III-H)."""

    # Rounds of trimming and the share of farthest observations dropped in each (the paper's 20 %).
    rounds: int = Field(default=3, ge=0)
    drop_share: float = Field(default=0.2, ge=0, lt=1)
    # Observations of one class farther apart than this, metres, are different places.
    place_distance: float = Field(default=1.0, gt=0)
    # How far apart, metres, opposite facings count as: more than place_distance, so two sides are two places.
    facing_distance: float = Field(default=1.2, ge=0)
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
    # Share of the sightings of the less seen line in which both were seen.
    seen_together: float = Field(default=0.4, ge=0, le=1)


class ReadingConfig(_Section):
    """Which frames are read."""

    # Seconds between frames that are read; a text needs three sightings while the camera passes.
    interval: float = Field(default=0.165, ge=0)
    # A frame is blurred when its variance of the Laplacian is below this share of the running median ...
    blur_share: float = Field(default=0.35, ge=0)
    # ... of so many frames; reading then waits for a sharper one, no longer than so many intervals.
    blur_window: int = Field(default=15, ge=1)
    blur_patience: float = Field(default=2.0, ge=0)


class TextConfig(_Section):
    """Reading and remembering (III-B to III-H)."""

    reading: ReadingConfig = ReadingConfig()
    spotting: SpottingConfig = SpottingConfig()
    memory: MemoryConfig = MemoryConfig()
    placement: PlacementConfig = PlacementConfig()
    instances: InstanceConfig = InstanceConfig()


class Config(_Section):
    """The whole tree."""

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
        except yaml.YAMLError as error:
            raise UserError(f"configuration {path} is not YAML: {' '.join(str(error).split())}") from error
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UserError(f"configuration {path}: {where}: {first['msg']}") from error
