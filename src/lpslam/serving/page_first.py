"""A map whose page is there before the server that answers is."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from starlette.applications import Starlette
from starlette.types import ASGIApp

from lpslam.config import Config
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.routes import Pages, page_routes
from lpslam.serving.http.opening import Opening
from lpslam.serving.http.shield import Door, Shield, allowed_hosts
from lpslam.serving.map_files import map_name, read_version


@dataclass(frozen=True, slots=True, eq=False)
class Opened:
    """What is open of a map before anybody answers.

    Attributes:
        path: its file.
        read: the version of the file, and the map.
        pages: give its page.
    """

    path: Path
    read: tuple[str, LanguageMap]
    pages: Pages


def page_first(
    path: Path, config: Config, host: str, names: Sequence[str], load: Callable[[Opened], ASGIApp]
) -> Opening:
    """An application that gives a map's page as soon as it can.

    Args:
        path: of the map's file.
        config: limits, and how much of the map is shown.
        host: where the server listens.
        names: other names of the server.
        load: gives the whole application, from what is open; called in a thread once the page is made.

    Raises:
        UserError: the map cannot be read.
    """
    name, (version, world) = map_name(path), read_version(path)

    def find(wanted: str | None) -> tuple[str, str, LanguageMap]:
        if wanted not in (None, name):
            raise LookupError("no map of that name is served; /maps lists them")
        return name, version, world

    opened = Opened(path, (version, world), Pages(find, config.page))
    door = Door(allowed_hosts(host, names), None, config.serving)
    shown = Shield(Starlette(routes=list(page_routes(opened.pages))), door)
    return Opening(shown, lambda: opened.pages.get(None), lambda: load(opened))
