"""The numeric inner loops, compiled by numba: matching, pose-only and bundle adjustment."""

from lpslam.kernel_cache import provide_cache

provide_cache(__file__)
