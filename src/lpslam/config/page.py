"""Thresholds of the page that shows a map."""

from lpslam.config.section import Field, Section


class RoomConfig(Section):
    """The picture of a room from above, in its own colours."""

    # Metres a pixel: readings of a keyframe lie 3 cm apart at 3 m, and those of several in between.
    finest: float = Field(default=0.02, gt=0.0, le=1.0)
    # The same of a room that grows, whose picture is made again and again: at 4 m readings lie as far apart.
    growing: float = Field(default=0.04, gt=0.0, le=1.0)
    # Pixels to a side at most; of a larger room they are larger.
    most_pixels: int = Field(default=2400, ge=100, le=20_000)
    # Metres over the camera above which a room is cut: its ceiling would hide it.
    over_the_camera: float = Field(default=0.3, ge=0.0)
    # Metres below the highest point of a pixel in which its colour is seen from above: noise, and slopes.
    top: float = Field(default=0.1, ge=0.0)
    # Metres on each side over which a surface goes on between its readings.
    gap: float = Field(default=0.12, gt=0.0, le=2.0)
    # Percent of the points at each side that may be left out: a few are astray, ...
    stray_percent: float = Field(default=0.5, lt=50.0)
    # ... and metres around the rest.
    around: float = Field(default=0.3, ge=0.0)
    # Pixels: a smaller patch that touches nothing is noise.
    alone: int = Field(default=12, ge=0)


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
    # The room from above.
    room: RoomConfig = RoomConfig()
