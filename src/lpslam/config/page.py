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
    # Metres, the same of a map that grows, which is sent while it is tracked: at 4 m readings lie as far apart.
    growing_cube: float = Field(default=0.04, gt=0.0, le=1.0)
    # Points of a map that grows: of a mall's floor; where there would be more, cubes of twice the side are taken.
    growing_points: int = Field(default=600_000, ge=0)
    # Pictures of a sign on its card: its best sightings, from several sides.
    pictures: int = Field(default=3, ge=0)
    # Bytes of all pictures of signs in one self-contained file; the best of each come first.
    file_picture_bytes: int = Field(default=1_500_000, ge=0)
    # Metres around a landmark, beyond its own reach, within which a picture was taken of it.
    picture_reach: float = Field(default=0.4, ge=0.0)
