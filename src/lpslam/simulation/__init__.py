"""The mock mall: RGB-D sequences with ground truth."""

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)
