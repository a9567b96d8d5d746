"""Thresholds of the ground: what is kept of keyframes, what a reading shows, and how robots go."""

from lpslam.config.section import Field, PositiveFloat, Section


class GroundConfig(Section):
    """From what keyframes saw to a grid of free and occupied cells."""

    # Whether keyframes keep small depth and colour images, without which there is neither a grid nor a coloured cloud.
    enabled: bool = True
    # Pixels across them; a pixel of 0.6 degrees covers 4 cm at 4 m, less than a cell.
    width: int = Field(default=96, ge=16, le=640)
    # Metres a cell.
    resolution: float = Field(default=0.05, ge=0.01, le=1.0)
    # Most cells to a side: 400 m; more is a broken map.
    most_cells: int = Field(default=8000, ge=100, le=20000)
    # Metres over the ground from which something is in the way, ...
    obstacle_height: float = Field(default=0.05, gt=0)
    # ... and from which a robot passes below it.
    robot_height: float = Field(default=1.5, gt=0)
    # Metres by which ground may lie lower than before it, noise apart: more is a drop.
    drop: float = Field(default=0.08, gt=0)
    # Degrees that ground may rise or fall: a ramp for wheelchairs has 3.5, a steep one 7.
    steepest: float = Field(default=10.0, ge=0, le=45)
    # How far up level ground looks at least: the cosine of 30 degrees, since noise tilts small surfaces.
    least_up: float = Field(default=0.87, gt=0, le=1)
    # Metres by which the floor lies below the camera at least.
    least_camera_height: float = Field(default=0.15, ge=0)
    # Metres by which it lies below at most: what lies deeper is another storey.
    most_camera_height: float = Field(default=2.5, gt=0)
    # Readings of level surfaces in a scan, from which one may be the floor.
    min_floor_readings: int = Field(default=40, ge=3)
    # Metres: heights are counted in steps that noise near the camera does not fill.
    floor_step: float = Field(default=0.02, gt=0)
    # Share of the strongest level's surface that makes a lower one a floor: tables stand on something.
    floor_share: float = Field(default=0.3, gt=0, le=1)
    # Metres by which a carried camera rises and falls, within which levels of several scans are one.
    carried_height: float = Field(default=0.15, gt=0)
    # How heights stray by distance, metres and metres a square metre: its shape; the size is found.
    usual_noise: tuple[PositiveFloat, PositiveFloat] = (0.003, 0.003)
    # Share of the scans that must have seen a floor.
    min_floor_share: float = Field(default=0.08, ge=0, le=1)
    # Metres by which a camera's height over the floor changes while it is carried.
    height_change: float = Field(default=0.6, gt=0)
    # Metres between storeys that lie above one another at least: nobody stands upright in less.
    storey_height: float = Field(default=2.0, gt=0)
    # Share of the smaller one's ground below or above which the other's lies; at a ramp's ends they meet only.
    storey_overlap: float = Field(default=0.1, ge=0, le=1)
    # Metres around the floor in which readings of level surfaces tell its noise; noise of three sigma beyond it is not
    # told from things in the way.
    floor_band: float = Field(default=0.2, gt=0)
    # Metres from the camera that are looked at: always, and at most.
    nearest: float = Field(default=2.0, gt=0)
    farthest: float = Field(default=8.0, gt=0)
    # Log odds that a scan adds to a cell: in which it sees something, ground, or through which its rays pass.
    occupied_odds: float = Field(default=0.9, gt=0)
    free_odds_down: float = Field(default=0.5, gt=0)
    passed_odds_down: float = Field(default=0.15, ge=0)
    # Metres over the ground below which rays leave no room for what they do not hit: a step, seldom anything else, ...
    low_ray: float = Field(default=0.15, ge=0)
    # ... and log odds from which a cell is free: at once where ground is seen, after two scans that look low over it.
    free_from_down: float = Field(default=0.3, ge=0)
    # Metres over the ground below which rays leave room for benches and pots only, which stand beside walls; ...
    over_furniture: float = Field(default=0.7, ge=0)
    # ... scans of such rays that make a cell free, farther from anything in the way than so many metres.
    looked_over: int = Field(default=2, ge=1)
    furniture: float = Field(default=0.5, ge=0)
    # Most that is believed, so that what has changed is seen before long.
    most_odds: float = Field(default=3.5, gt=0)
    # Pixels of a scan to each side from which a surface is told, ...
    surface_reach: int = Field(default=2, ge=1, le=20)
    # ... and metres, and share of the distance, by which it may be uneven there.
    surface_bend: tuple[PositiveFloat, PositiveFloat] = (0.005, 0.0075)
    # Metres that ground may have risen where it was not seen: more is a step.
    unseen_climb: float = Field(default=0.1, ge=0)
    # Share of the difference to a reading of ground by which the ground that is walked along follows it.
    followed_share: float = Field(default=0.3, gt=0, le=1)
    # Metres around a camera that was carried there: nothing stands.
    trodden: float = Field(default=0.2, ge=0)
    # Readings in a cell that make something of it; fewer in proportion: far away a thin thing has one in a scan.
    least_readings: int = Field(default=2, ge=1)


class WayConfig(Section):
    """How a robot goes, and where it stands before a sign."""

    # Metres from the robot's middle to its rim.
    robot_radius: float = Field(default=0.25, gt=0)
    # Metres from what is in the way that are kept where there is room, and how much longer a way may be for it.
    comfort: float = Field(default=0.2, ge=0)
    comfort_cost: float = Field(default=0.5, ge=0)
    # Metres a second.
    speed: float = Field(default=1.0, gt=0)
    # Metres before a sign at which people stand to read it: nearest, best and farthest.
    goal_near: float = Field(default=0.6, gt=0)
    goal_best: float = Field(default=1.0, gt=0)
    goal_far: float = Field(default=1.8, gt=0)
    # Degrees to the side of straight ahead from which a sign may be faced.
    goal_aside: float = Field(default=50.0, gt=0, lt=90)
    # Metres around a start in which ground to stand on is looked for: the camera is carried at arm's length.
    start_reach: float = Field(default=0.6, ge=0)
