"""Language-perceptive RGB-D SLAM: a map whose landmarks are the words in the scene."""

from lpslam._version import __version__

__all__ = ["__version__"]
