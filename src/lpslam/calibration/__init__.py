"""Estimating a camera's calibration from a recording of any textured room."""
