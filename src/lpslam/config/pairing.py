"""How colour and depth are brought together by time."""

from lpslam.config.section import Field, Section


class PairingConfig(Section):
    """Of recordings whose pictures have times of their own, and of pictures that come over a robot's topics."""

    # Seconds between a colour picture and its depth: more than half of what lies between frames at 30 a second ...
    tolerance_s: float = Field(default=0.02, gt=0)
    # ... and with fewer a second half of that, but no more than this: a hand moves by half a picture meanwhile.
    slow_tolerance_s: float = Field(default=0.05, gt=0)
    # Pictures of a kind that wait for the other kind: two seconds at 30 a second.
    buffer: int = Field(default=64, ge=1)
    # Seconds without depth after which frames come without: constant velocity and flow do not bridge more.
    pause_s: float = Field(default=0.2, gt=0)
