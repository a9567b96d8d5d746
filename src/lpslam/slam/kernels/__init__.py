"""The numeric inner loops, compiled by numba: matching, pose-only and bundle adjustment."""
