"""When depth is taken to lie beside colour, and how that is looked for."""

from lpslam.config.section import Field, PositiveFloat, Section


class RegistrationCheckConfig(Section):
    """Whether contours of things lie in the depth image where the colour image shows them."""

    # Frames, spread over the recording; 0: registration is not checked. Eight take a third of a second.
    frames: int = Field(default=8, ge=0, le=100)
    # Frames from which it is estimated, for `lpslam calibrate`.
    estimating_frames: int = Field(default=40, ge=4, le=100)
    # Metres; nearer readings are noise.
    nearest: float = Field(default=0.3, gt=0)
    # Metres, and share of the distance, by which what is behind a contour is farther.
    step: float = Field(default=0.1, gt=0)
    step_share: float = Field(default=0.06, gt=0)
    # Share of the width: what a thing may hide from the sensor's second eye, 10 pixels of 640.
    shadow: float = Field(default=0.019, gt=0)
    # Pixels before a contour that must read alike, and share of the distance by which they may differ.
    steady_pixels: int = Field(default=3, ge=1)
    steady_share: float = Field(default=0.03, gt=0)
    # Contour pixels a frame that are compared; more say the same.
    contour_pixels: int = Field(default=1000, ge=100)
    # Contour pixels below which a frame says nothing, and frames below which nothing is said: rooms may be bare.
    min_view_pixels: int = Field(default=60, ge=1)
    min_views: int = Field(default=5, ge=2)
    # Width of depth images of which each pixel is looked at; of larger ones every second, every third.
    depth_width: int = Field(default=640, ge=64)
    # Pixels to which the longer side of pictures is reduced: a pixel of it is two of 640.
    side: int = Field(default=320, ge=64, le=1000)
    # Pixels that the shorter side then has at least: a strip shows no contours.
    least_side: int = Field(default=32, ge=8)
    # Ratios of focal lengths that are tried, and how many: RealSense's depth sees 1.6 times as wide as its colour.
    scales: tuple[float, float] = (0.5, 2.0)
    scale_steps: int = Field(default=29, ge=3)
    # Shifts that are tried, share of the width.
    reach: float = Field(default=0.15, gt=0, lt=0.5)
    # Metres between the cameras, of which a width of focal length is assumed: a RealSense has 0.015 to 0.06.
    baseline: float = Field(default=0.12, gt=0)
    # Of scale and of shift, share of one and of the width: so near is registered, at a first look.
    near: float = Field(default=0.03, gt=0)
    # Blur of the changes, pixels of the reduced picture: for the first look, then finer and finer.
    blurs: tuple[PositiveFloat, ...] = (5.0, 2.5, 1.2)
    # Share of the width that contours must move, root mean square: registered depth is off by up to 3 pixels of 640.
    displaced: float = Field(default=0.015, gt=0)
    # Times as much that pictures must change at the contours, once moved.
    gain: float = Field(default=1.5, gt=1)
    # Times as much that they must change as is found by chance, in the same pictures turned upside down.
    beyond_chance: float = Field(default=3.0, gt=1)
    # Share of the frames in which they must change more.
    agreeing: float = Field(default=0.9, gt=0.5, le=1)
    # Share of the way they move by which two halves of the frames may place contours apart.
    halves_apart: float = Field(default=0.25, gt=0)
