"""The page beside a server: one for each map that is served."""

from collections.abc import Callable, Sequence
from functools import lru_cache
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


def page_routes(find: Found) -> Sequence[BaseRoute]:
    """Routes of the page: `/` for the first map, `/page/NAME` for any, `/page/NAME/signs` for what changes.

    Args:
        find: the map of a name; raises `LookupError` where there is none.
    """

    @lru_cache(maxsize=_KEPT)
    def built(name: str, version: str) -> str:
        return page_of(find(name)[2], live=True, name=name)

    async def page(request: Request) -> Response:
        try:
            name, version, _ = await run_in_threadpool(find, request.path_params.get("name"))
        except LookupError as error:
            return PlainTextResponse(f"{error}\n", status_code=404)
        text = await run_in_threadpool(built, name, version)
        return HTMLResponse(text, headers={"content-security-policy": policy(live=True) + "; frame-ancestors 'none'"})

    async def signs(request: Request) -> Response:
        try:
            _, _, world = await run_in_threadpool(find, request.path_params["name"])
        except LookupError as error:
            return PlainTextResponse(f"{error}\n", status_code=404)
        return JSONResponse(await run_in_threadpool(_newest, world))

    return [Route("/", page), Route("/page/{name}", page), Route("/page/{name}/signs", signs)]


def _newest(world: LanguageMap) -> dict[str, Any]:
    """What of a page may change while it is shown."""
    return {"trajectory": way_record(world.frame_poses().positions), **said_record(world)}
