"""A recording seen again by the same sensor: new noise on the old frames, without drawing them anew."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from lpslam.frames import FrameSource, PassedOn, RgbdFrame
from lpslam.simulation import sensor


class NoisyAgain(PassedOn):
    """A `FrameSource` that puts new noise on each frame of another one.

    The old noise stays beneath, so two passes are a little more alike than two visits would be, and each is a little
    noisier than the sensor.

    Args:
        source: the recording.
        seed: of the noise; the same seed gives the same frames.
        share: of the mock mall's sensor noise.
    """

    def __init__(self, source: FrameSource, seed: int, share: float = 0.7) -> None:
        super().__init__(source)
        self._seed = seed
        self._share = share
        # The fields are the sensor's, whatever the pass.
        self._noise = sensor.draw_noise(np.random.default_rng(17), source.camera.width, source.camera.height)

    def __iter__(self) -> Iterator[RgbdFrame]:
        """Yield the source's frames with noise that depends on the seed and the frame's index alone."""
        for frame in self.source:
            yield self.disturbed(frame, self._seed)

    def disturbed(self, frame: RgbdFrame, seed: int) -> RgbdFrame:
        """One frame with the noise of a pass."""
        rng = np.random.default_rng([seed, 19, frame.index])
        rgb, depth = sensor.measure_again(rng, frame.rgb, frame.depth, self._noise, self._share)
        return replace(frame, rgb=rgb, depth=depth)
