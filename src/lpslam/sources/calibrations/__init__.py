"""Calibrations that are no YAML or JSON of the usual keys: lines, plain words, bare numbers, XML, devices' own forms.

Each module turns one form into a tree of the keys that `sources.calibration` reads (fx, fy, cx, cy, k1, width, …).
"""
