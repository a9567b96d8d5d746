"""Thresholds of the page that shows a map."""

from pydantic import Field

from lpslam.config.section import Section


class PageConfig(Section):
    """What of a map a page shows, and how much."""

    # Metres, the side of the cubes of which each has one point: readings of a keyframe lie 3 cm apart at 3 m.
    cube: float = Field(default=0.02, gt=0.0, le=1.0)
    # Points beside a server: of a whole floor of a mall; 8 bytes each.
    points: int = Field(default=1_500_000, ge=0)
    # Points in one self-contained file: 11 bytes each as text, of the ten megabytes that a mail takes.
    file_points: int = Field(default=600_000, ge=0)
    # Points of a map that grows: made anew every few seconds, behind tracking.
    growing_points: int = Field(default=150_000, ge=0)
    # Pixels across a cut-out of a sign on its card at most: as wide as the card on a fine screen.
    crop_width: int = Field(default=480, ge=16, le=4096)
    # Bytes of all cut-outs in one self-contained file; those of the surest landmarks come first.
    file_crop_bytes: int = Field(default=1_500_000, ge=0)
