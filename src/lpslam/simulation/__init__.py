"""The mock mall: RGB-D sequences with ground truth."""
