"""RVL, the depth compression of `compressedDepth`: runs of zeros and of differences, in nibbles.

A. D. Wilson, "Fast lossless depth image compression", ISS 2017.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)


@njit(nogil=True, cache=True)
def decode_rvl(words: NDArray[np.uint32], pixels: NDArray[np.uint16]) -> bool:
    """Decode into `pixels` (n,); False where the data end too early or hold too much.

    Args:
        words: little-endian words of eight nibbles, the first in the highest four bits.
        pixels: filled, raw depth; zeros are runs of no depth.
    """
    position, filled, previous = 0, 0, 0
    limit = 8 * len(words)
    while filled < len(pixels):
        for part in range(2):
            run, shift, more = 0, 0, True
            while more:
                if position >= limit or shift > 28:
                    return False
                nibble = (words[position >> 3] >> np.uint32(28 - 4 * (position & 7))) & np.uint32(15)
                position += 1
                run |= int(nibble & np.uint32(7)) << shift
                shift += 3
                more = (nibble & np.uint32(8)) != 0
            if run > len(pixels) - filled:
                return False
            if part == 0:
                pixels[filled : filled + run] = 0
                filled += run
                continue
            for _ in range(run):
                value, shift, more = 0, 0, True
                while more:
                    if position >= limit or shift > 28:
                        return False
                    nibble = (words[position >> 3] >> np.uint32(28 - 4 * (position & 7))) & np.uint32(15)
                    position += 1
                    value |= int(nibble & np.uint32(7)) << shift
                    shift += 3
                    more = (nibble & np.uint32(8)) != 0
                previous += (value >> 1) ^ -(value & 1)
                pixels[filled] = previous & 0xFFFF
                filled += 1
    return True
