"""A person's corrections of served maps: one after the other, each by somebody who has seen the one before."""

import threading
from collections.abc import Callable
from typing import Any

from lpslam.language.model import LanguageModel
from lpslam.mapfile.correcting import change_corrections, editing
from lpslam.mapfile.export import corrections_record
from lpslam.mapfile.language_map import LanguageMap
from lpslam.serving.atlas import Atlas, ServedMap
from lpslam.text.correcting.changing import Change, correct, take_back
from lpslam.text.text_map import TextMap


class Editor:
    """Corrects the maps of an atlas; safe in threads.

    Args:
        atlas: the maps.
        language: judges new names.
    """

    def __init__(self, atlas: Atlas, language: LanguageModel) -> None:
        self._atlas, self._language = atlas, language
        self._one_at_a_time = threading.Lock()

    def correct(self, name: str | None, change: Change, revision: int) -> ServedMap:
        """Say something of a landmark; gives the map as it is served from now on.

        Raises:
            ConflictError: somebody else has corrected the map since that revision.
            UserError: there is no such map or landmark, or the file cannot be written.
        """
        return self._change(
            name, lambda text, world: correct(text, world.world_from_keyframe, change, self._language, revision)
        )

    def take_back(self, name: str | None, number: int, revision: int) -> ServedMap:
        """Take a correction back; raises as `correct`."""
        return self._change(name, lambda text, world: take_back(text, number, revision))

    def _change(self, name: str | None, change: Callable[[TextMap, LanguageMap], None]) -> ServedMap:
        served = self._atlas.get(name)
        path = self._atlas.path(served.name)
        with self._one_at_a_time, editing(path):
            # Another program may have written the file since it was read.
            current = self._atlas.current(served.name)
            return self._atlas.replace(served.name, change_corrections(path, change, current.world))


def state_of(served: ServedMap) -> dict[str, Any]:
    """What has been said of a map, as `records.CorrectionState` has it."""
    return {"map": served.name, "version": served.version, **corrections_record(served.world.text.corrections)}
