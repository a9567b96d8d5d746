"""The maps that are served: by name, and anew when their files are replaced."""

import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lpslam.config import NavigationConfig
from lpslam.errors import LpSlamError, UserError
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.export import landmark_record
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.directory import Directory
from lpslam.navigation.known import last_view
from lpslam.serving.map_files import file_version, map_name, read_version


class NoSuchMapError(UserError):
    """A map was asked for that is not served."""


@dataclass(frozen=True, slots=True, eq=False)
class ServedMap:
    """A map as it was when its file was read; threads share it, nobody changes it.

    Attributes:
        name: under which it is served.
        version: of the file, changes when it is replaced.
        world: the map.
        directory: its landmarks, ready for questions.
        view: where the camera was last, (3,) map frame, and its heading in radians.
        records: its landmarks as JSON has them, in their order.
        words: all that stands on each of them, folded as it is looked for.
        path_length: metres that the camera went.
    """

    name: str
    version: str
    world: LanguageMap
    directory: Directory
    view: tuple[NDArray[np.float64], float]
    records: tuple[dict[str, Any], ...]
    words: tuple[str, ...]
    path_length: float


def served(name: str, version: str, world: LanguageMap, config: NavigationConfig | None = None) -> ServedMap:
    """A map made ready to be served; questions are answered by the thresholds of `config`, or the defaults."""
    marks = world.landmarks()
    poses = world.frame_poses()
    view, length = last_view(poses.world_from_camera), poses.path_length
    words = tuple(folded("\n".join((mark.name, *mark.other_lines))) for mark in marks)
    known = Directory(marks, config)
    return ServedMap(name, version, world, known, view, tuple(map(landmark_record, marks)), words, length)


def folded(text: str) -> str:
    """A text as texts are compared that one looks for: clean, line by line, whatever its case."""
    return "\n".join(clean_text(line).casefold() for line in text.split("\n"))


class Atlas:
    """The maps that are served, by name; safe in threads.

    Names are keys and nothing else: no name that is asked for ever becomes a path.

    Args:
        paths: of map files; each is read at once.
        config: thresholds of questions; the defaults without.

    Raises:
        UserError: there is none, one cannot be read, or two have one name.
    """

    def __init__(self, paths: Iterable[Path], config: NavigationConfig | None = None) -> None:
        self._config = config
        self._changing = threading.Lock()
        self._paths: dict[str, Path] = {}
        self._maps: dict[str, ServedMap] = {}
        self._troubles: dict[str, str] = {}
        self._tried: dict[str, str] = {}
        for path in paths:
            self.add(path)

    def add(self, path: Path, name: str | None = None, read: tuple[str, LanguageMap] | None = None) -> ServedMap:
        """Serve one more map.

        Args:
            path: its file.
            name: under which; the file's own without.
            read: the version of the file and the map, where somebody has read it.

        Raises:
            UserError: it cannot be read, or its name is taken.
        """
        name = name or map_name(path)
        if name in self._paths:
            raise UserError(f"{path} and {self._paths[name]} would both be served as {name}: rename one of them")
        found = self._read(name, path) if read is None else served(name, *read, self._config)
        with self._changing:
            self._paths[name], self._maps = path, {**self._maps, name: found}
        return found

    @property
    def maps(self) -> Mapping[str, ServedMap]:
        """All of them, as they are now."""
        return self._maps

    def trouble(self, name: str) -> str:
        """Why the newest file of a map is not served, in a line; empty when it is."""
        return self._troubles.get(name, "")

    def get(self, name: str | None = None) -> ServedMap:
        """A map by its name; the only one without.

        Raises:
            NoSuchMapError: there is none, or the name is missing where there are several.
        """
        maps = self._maps
        if name is None and len(maps) == 1:
            return next(iter(maps.values()))
        if name is None:
            raise NoSuchMapError(f"which map? {len(maps)} are served; say its name, as /maps lists them")
        if name not in maps:
            raise NoSuchMapError("no map of that name is served; /maps lists them")
        return maps[name]

    def path(self, name: str) -> Path:
        """The file of a map that is served."""
        return self._paths[name]

    def current(self, name: str) -> ServedMap:
        """A map as its file is now, which is read if it was replaced.

        Raises:
            UserError: it cannot be read.
        """
        known = self._maps[name]
        try:
            version = file_version(self._paths[name])
        except OSError as error:
            raise UserError(f"the file of map {name} is gone ({error.strerror})") from error
        return known if version == known.version else self._put(self._read(name, self._paths[name]))

    def replace(self, name: str, world: LanguageMap) -> ServedMap:
        """Serve a map that has just been written to its file."""
        return self._put(served(name, file_version(self._paths[name]), world, self._config))

    def _put(self, found: ServedMap) -> ServedMap:
        with self._changing:
            self._maps = {**self._maps, found.name: found}
        self._troubles.pop(found.name, None)
        return found

    def refresh(self) -> list[ServedMap]:
        """Read the maps whose files were replaced; one that is gone or damaged is served on as it was.

        Returns:
            Those that are new.
        """
        changed = []
        for name, path in list(self._paths.items()):
            try:
                version = file_version(path)
                if version in (self._maps[name].version, self._tried.get(name)):
                    continue
                self._tried[name] = version
                found = self._read(name, path)
            except (LpSlamError, OSError) as error:
                self._troubles[name] = f"its file cannot be read: the map is served as it was ({_line(error)})"
                continue
            changed.append(self._put(found))
        return changed

    def _read(self, name: str, path: Path) -> ServedMap:
        return served(name, *read_version(path), self._config)


def _line(error: Exception) -> str:
    """An error without the server's own paths."""
    return error.strerror or "it is gone" if isinstance(error, OSError) else "it is damaged, or of another version"
