"""How robots are listened to and told, over ROS 2."""

from lpslam.config.section import Field, Section


class RobotConfig(Section):
    """Topics, frames of reference and how often what is told."""

    # Topics as RealSense's driver names them; depth must be registered to the colour.
    colour_topic: str = Field(default="/camera/color/image_raw", min_length=1)
    depth_topic: str = Field(default="/camera/aligned_depth_to_color/image_raw", min_length=1)
    info_topic: str = Field(default="/camera/color/camera_info", min_length=1)
    # Before all topics and services that are told.
    namespace: str = "/lpslam"
    # Frames as REP-105 names them. Without one of odometry, what the camera hangs on in the end hangs below the map.
    map_frame: str = Field(default="map", min_length=1)
    odom_frame: str = ""
    # Whose pose is told; the camera's without.
    base_frame: str = ""
    # Whether pictures that get lost are asked for again: a driver that publishes with best effort then is not heard.
    reliable: bool = False
    # Seconds by which a transform may be older than a picture: odometry comes ten times a second at least.
    transform_s: float = Field(default=0.2, gt=0)
    # Seconds between two tellings of landmarks, whose places move with the map; new ones are told at once.
    landmarks_s: float = Field(default=2.0, gt=0)
    # Seconds between two grids: each takes a copy of the map, tenths of a second on a large one.
    grid_s: float = Field(default=10.0, gt=0)
    # Seconds of silence on a topic after which it is said, and between two sayings of what was skipped.
    silence_s: float = Field(default=5.0, gt=0)
    # Letters of a question that is taken; what is read of it is `language.question_length`.
    question_letters: int = Field(default=4000, ge=1)
