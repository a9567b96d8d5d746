"""The page beside a server: one for each map that is served."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.building import page_of, policy
from lpslam.page.record import said_record, way_record

Found = Callable[[str | None], tuple[str, str, LanguageMap]]
"""From the name of a map, or None for the only one, to its name, the version of its file, and the map."""

_KEPT = 4  # pages that are kept ready


class Pages:
    """Pages of maps, each made once for every version of its map; safe in threads.

    Args:
        find: the map of a name; raises `LookupError` where there is none.
    """

    def __init__(self, find: Found) -> None:
        self.find = find
        self._making = threading.Lock()
        self._kept: OrderedDict[tuple[str, str], str] = OrderedDict()

    def text(self, name: str | None) -> str:
        """The page of a map, by its name, or of the first.

        Raises:
            LookupError: there is none.
        """
        found, version, world = self.find(name)
        # Who asks while it is made waits for it, and does not make another.
        with self._making:
            if (found, version) not in self._kept:
                self._kept[found, version] = page_of(world, live=True, name=found)
                if len(self._kept) > _KEPT:
                    self._kept.popitem(last=False)
            self._kept.move_to_end((found, version))
            return self._kept[found, version]


def page_routes(pages: Pages) -> Sequence[BaseRoute]:
    """Routes of the page: `/` for the first map, `/page/NAME` for any, `/page/NAME/signs` for what changes."""

    async def page(request: Request) -> Response:
        try:
            text = await run_in_threadpool(pages.text, request.path_params.get("name"))
        except LookupError as error:
            return PlainTextResponse(f"{error}\n", status_code=404)
        return HTMLResponse(text, headers={"content-security-policy": policy(live=True) + "; frame-ancestors 'none'"})

    async def signs(request: Request) -> Response:
        try:
            _, _, world = await run_in_threadpool(pages.find, request.path_params["name"])
        except LookupError as error:
            return PlainTextResponse(f"{error}\n", status_code=404)
        return JSONResponse(await run_in_threadpool(_newest, world))

    return [Route("/", page), Route("/page/{name}", page), Route("/page/{name}/signs", signs)]


def _newest(world: LanguageMap) -> dict[str, Any]:
    """What of a page may change while it is shown."""
    return {"trajectory": way_record(world.frame_poses().positions), **said_record(world)}
