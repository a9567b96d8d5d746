"""Language-perceptive RGB-D SLAM: a map whose landmarks are the words in the scene.

import lpslam

world = lpslam.run(lpslam.open_source("recording/"))
lpslam.distill(world, "Is this a shop?")
print(lpslam.ask(world, "Where can I eat pizza?").landmark)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from lpslam._version import __version__

if TYPE_CHECKING:
    from lpslam.config import Config
    from lpslam.errors import LpSlamError, UserError
    from lpslam.language.registry import language_model
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.pipeline import ask, distill, run
    from lpslam.sources.open import open_source

__all__ = [
    "Config",
    "LanguageMap",
    "LpSlamError",
    "UserError",
    "__version__",
    "ask",
    "distill",
    "language_model",
    "open_source",
    "run",
]

# Loaded at first use, so that importing the package (and `lpslam --help`) loads neither OpenCV nor a model.
_HOMES = {
    "Config": "lpslam.config",
    "LanguageMap": "lpslam.mapfile.language_map",
    "LpSlamError": "lpslam.errors",
    "UserError": "lpslam.errors",
    "ask": "lpslam.pipeline",
    "distill": "lpslam.pipeline",
    "language_model": "lpslam.language.registry",
    "open_source": "lpslam.sources.open",
    "run": "lpslam.pipeline",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'lpslam' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
