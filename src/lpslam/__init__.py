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
    from lpslam.camera import PinholeCamera
    from lpslam.config import Config
    from lpslam.errors import LpSlamError, UserError
    from lpslam.frames import RgbdFrame
    from lpslam.language.registry import language_model
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.navigation.asking import Answer, ask
    from lpslam.pipeline import distill, localise, run
    from lpslam.session.localiser import Localiser
    from lpslam.session.session import Session
    from lpslam.session.step import Step
    from lpslam.sources.open import open_source
    from lpslam.text.types import Landmark

__all__ = [
    "Answer",
    "Config",
    "Landmark",
    "LanguageMap",
    "Localiser",
    "LpSlamError",
    "PinholeCamera",
    "RgbdFrame",
    "Session",
    "Step",
    "UserError",
    "__version__",
    "ask",
    "distill",
    "language_model",
    "localise",
    "open_source",
    "run",
]

# Loaded at first use, so that importing the package (and `lpslam --help`) loads neither OpenCV nor a model.
_HOMES = {
    "Answer": "lpslam.navigation.asking",
    "Config": "lpslam.config",
    "Landmark": "lpslam.text.types",
    "LanguageMap": "lpslam.mapfile.language_map",
    "Localiser": "lpslam.session.localiser",
    "LpSlamError": "lpslam.errors",
    "PinholeCamera": "lpslam.camera",
    "RgbdFrame": "lpslam.frames",
    "Session": "lpslam.session.session",
    "Step": "lpslam.session.step",
    "UserError": "lpslam.errors",
    "ask": "lpslam.navigation.asking",
    "distill": "lpslam.pipeline",
    "language_model": "lpslam.language.registry",
    "localise": "lpslam.pipeline",
    "open_source": "lpslam.sources.open",
    "run": "lpslam.pipeline",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'lpslam' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
