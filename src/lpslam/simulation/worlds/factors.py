"""What a world is made of, and how a seed draws it.

A set is a run of seeds. Within it each factor goes through all its values in a shuffled order before any comes again,
so that any part of a set, and the whole of it, shows every value of every factor about equally often. From the 40th
seed of a thousand on, every factor is drawn by itself.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from lpslam.errors import UserError

FACTORS: dict[str, tuple[str, ...]] = {
    "depth": ("structured", "stereo", "tof", "lidar"),
    "motion": ("handheld", "rotation", "pans", "stop-and-go", "robot", "humanoid", "set-down", "bag"),
    "place": (*("mall", "corridor", "shop-fronts", "glass", "people", "lights-off", "desk", "living", "forecourt"),),
    "light": ("bright", "normal", "dim", "very-dim", "spots"),
    "shutter": ("global", "rolling"),
    "exposure": ("short", "medium", "long"),
    "lens": ("none", "mild", "strong"),
    "view": ("narrow", "middle", "wide"),
    "size": ("640x480", "320x240", "640x480", "848x480", "1280x720"),
    "rate": ("30", "15", "30", "60", "10"),
    "compression": ("png", "jpeg"),
    "registration": ("exact", "off"),
    "delay": ("none", "hidden", "stamped"),
    "calibration": ("right", "right", "wrong"),
    "control": ("steady", "hunting"),
}
"""Each factor's values; one that is listed twice is drawn twice as often."""

EDITION = 5  # of what a seed means; worlds of another edition are drawn anew
STRATIFIED = 40  # seeds at the beginning of each thousand
MOST_FRAMES = 600
SETS = {"dev": 1000, "test": 5000}  # first seed
LIGHT_LEVELS = {"bright": 1.5, "normal": 1.0, "dim": 0.3, "very-dim": 0.15, "spots": 0.8}


@dataclass(frozen=True, slots=True)
class World:
    """A world's factors, by name, and the numbers that go with them.

    Attributes:
        seed: of everything that is not said here.
        depth, motion, place, light, shutter, exposure, lens, view, size, rate, compression, registration, delay,
            calibration, control: values in `FACTORS`.
        seconds: length of the recording.
        readout: seconds between the first row's exposure and the last one's; 0 for a global shutter.
        shutter_time: seconds for which each row is exposed, in light of level 1.
        field_of_view: degrees, horizontal, without distortion.
        distortion: k1, k2, p1, p2, k3 of the lens.
        focal_error: share by which the calibration that is given states the focal length too large.
        misregistration: pixels (x, y) by which depth lies beside the colour.
        depth_delay: seconds by which depth is measured after the colour; negative: before.
        depth_scale_error: share by which depth is measured too large.
        depth_noise: 0 to 1, where in the published range of its kind the sensor's noise lies.
        jpeg_quality: as OpenCV takes it.
        light_level: brightness of all lamps.
        grain: the colour sensor's noise, 1 as in a usual camera.
    """

    seed: int
    depth: str
    motion: str
    place: str
    light: str
    shutter: str
    exposure: str
    lens: str
    view: str
    size: str
    rate: str
    compression: str
    registration: str
    delay: str
    calibration: str
    control: str
    seconds: float
    readout: float
    shutter_time: float
    field_of_view: float
    distortion: tuple[float, float, float, float, float]
    focal_error: float
    misregistration: tuple[float, float]
    depth_delay: float
    depth_scale_error: float
    depth_noise: float
    jpeg_quality: int
    light_level: float
    grain: float

    @property
    def width(self) -> int:
        """Pixels of the colour image."""
        return int(self.size.split("x")[0])

    @property
    def height(self) -> int:
        """Pixels of the colour image."""
        return int(self.size.split("x")[1])

    @property
    def fps(self) -> float:
        """Frames a second."""
        return float(self.rate)

    @property
    def frames(self) -> int:
        """Number of frames of the recording."""
        return min(MOST_FRAMES, max(3, round(self.seconds * self.fps)))

    @property
    def name(self) -> str:
        """Folder's name."""
        return f"world-{self.seed}"

    def factors(self) -> dict[str, str]:
        """The value of every factor."""
        return {name: str(getattr(self, name)) for name in FACTORS}

    def as_json(self) -> dict[str, Any]:
        """Everything, for world.json."""
        return asdict(self)

    @classmethod
    def from_json(cls, tree: dict[str, Any]) -> "World":
        """What `as_json` wrote."""
        fields: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value for key, value in tree.items()
        }
        return cls(**fields)


def draw_world(seed: int, **given: Any) -> World:
    """Draw the world of a seed; any factor or number may be given instead.

    Raises:
        UserError: a name or a value is not known.
    """
    known = {*World.__dataclass_fields__} - {"seed"}
    if seed < 0 or (unknown := set(given) - known):
        raise UserError(f"worlds: {f'seed is {seed}' if seed < 0 else f'no factor is called {min(unknown)}'}")
    values = {name: given.get(name, _value(seed, name)) for name in FACTORS}
    for name, value in values.items():
        if value not in FACTORS[name]:
            raise UserError(f"worlds: {name} is {value!r}; it must be one of {', '.join(dict.fromkeys(FACTORS[name]))}")
    world = World(seed=seed, **values, **_numbers(np.random.default_rng([seed, 103]), values))
    return replace(world, **{name: value for name, value in given.items() if name not in FACTORS})


def seeds_of(which: str, count: int = STRATIFIED) -> list[int]:
    """The seeds of a set, dev or test."""
    return list(range(SETS[which], SETS[which] + count))


def _value(seed: int, name: str) -> str:
    values, number = FACTORS[name], list(FACTORS).index(name)
    place = seed % 1000
    if place >= STRATIFIED:
        return str(values[int(np.random.default_rng([seed, 101, number]).integers(len(values)))])
    round_of, position = divmod(place, len(values))
    order = np.random.default_rng([seed // 1000, 102, number, round_of]).permutation(len(values))
    return str(values[int(order[position])])


def _numbers(rng: np.random.Generator, values: dict[str, str]) -> dict[str, Any]:
    """The numbers that a world's values leave open; every one is drawn, so that none changes another."""
    period = 1.0 / float(values["rate"])
    ranges = {"short": (0.003, 0.007), "medium": (0.007, 0.015), "long": (0.015, 0.033)}
    views = {"narrow": (60.0, 67.0), "middle": (67.0, 78.0), "wide": (78.0, 90.0)}
    readout, shutter_time = float(rng.uniform(0.010, 0.030)), float(rng.uniform(*ranges[values["exposure"]]))
    view, sign = float(rng.uniform(*views[values["view"]])), float(rng.choice([-1.0, 1.0]))
    beside = rng.uniform(1.0, 3.0) * np.array([np.cos(angle := rng.uniform(0, 2 * np.pi)), np.sin(angle)])
    exactly = rng.normal(0, 0.15, 2)
    dx, dy = beside if values["registration"] == "off" else exactly
    late = {"none": 0.0, "hidden": float(rng.uniform(0.005, 0.025)), "stamped": float(rng.uniform(0.003, 0.015))}
    width, height = (int(each) for each in values["size"].split("x"))
    corner = float(np.hypot(1.0, height / width) * np.tan(np.radians(view / 2)))
    return {
        "seconds": round(float(rng.uniform(12.0, 22.0)), 2),
        "readout": round(min(readout, 0.9 * period), 5) if values["shutter"] == "rolling" else 0.0,
        "shutter_time": round(min(shutter_time, 0.9 * period), 5),
        "field_of_view": round(view, 2),
        "distortion": _distortion(rng, values["lens"], corner),
        "focal_error": round(float(rng.uniform(0.003, 0.01)) * sign, 5) if values["calibration"] == "wrong" else 0.0,
        "misregistration": (round(float(dx), 3), round(float(dy), 3)),
        "depth_delay": round(late[values["delay"]] * float(rng.choice([-1.0, 1.0])), 5),
        "depth_scale_error": round(float(rng.uniform(-0.02, 0.02)), 5),
        "depth_noise": round(float(rng.uniform(0.0, 1.0)), 3),
        "jpeg_quality": int(rng.integers(60, 96)),
        "light_level": round(LIGHT_LEVELS[values["light"]] * float(rng.uniform(0.9, 1.1)), 3),
        "grain": round(float(rng.uniform(0.7, 1.6)), 3),
    }


def _distortion(rng: np.random.Generator, lens: str, corner: float) -> tuple[float, float, float, float, float]:
    """Brown-Conrady terms that move the image's corner, `corner` off the axis, by some percent."""
    strength = {
        "none": 0.0,
        "mild": float(rng.uniform(-0.03, 0.03)),
        "strong": float(rng.choice([rng.uniform(-0.14, -0.06), rng.uniform(-0.14, -0.06), rng.uniform(0.03, 0.07)])),
    }[lens]
    share, p1, p2, third = rng.uniform(-0.35, 0.0), *rng.normal(0, 0.0008, 2), rng.random() < 0.4
    if lens == "none":
        return (0.0, 0.0, 0.0, 0.0, 0.0)
    k1 = strength / corner**2
    k3 = float(rng.uniform(-0.05, 0.05)) * strength / corner**6 if third else 0.0
    terms = (k1, share * k1 / corner**2, p1, p2, k3)
    k1, k2, p1, p2, k3 = (round(float(term), 6) for term in terms)
    return (k1, k2, p1, p2, k3)
