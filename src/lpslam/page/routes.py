"""The page beside a server: one for each map that is served."""

import json
import threading
from collections import OrderedDict
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Route

from lpslam.config import PageConfig
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.building import page_of, policy
from lpslam.page.record import ground_record, room_points, said_record, way_record
from lpslam.page.signs import sign_pictures

Found = Callable[[str | None], tuple[str, str, LanguageMap]]
"""From the name of a map, or None for the only one, to its name, the version of its file, and the map."""

_KEPT = 4  # maps of which what was made is kept


class Pages:
    """Pages of maps and their parts, each made once for every version of its map; safe in threads.

    Args:
        find: the map of a name; raises `LookupError` where there is none.
        config: how much of a map is shown.
    """

    def __init__(self, find: Found, config: PageConfig) -> None:
        self.find = find
        self._make: Mapping[str, Callable[[LanguageMap, str], bytes]] = {
            "page": lambda world, found: page_of(world, live=True, name=found, config=config).encode("utf-8"),
            "ground": lambda world, _: json.dumps(ground_record(world)).encode("ascii"),
            "pictures": lambda world, _: json.dumps(sign_pictures(world, None, config)).encode("ascii"),
            "points": lambda world, _: room_points(world, config.points, config).content(),
        }
        self._making = {part: threading.Lock() for part in self._make}
        self._kept: dict[str, OrderedDict[tuple[str, str], bytes]] = {part: OrderedDict() for part in self._make}

    def get(self, name: str | None, part: str = "page") -> bytes:
        """A part of a map's page, by the map's name, or of the first.

        Args:
            name: of the map.
            part: page, ground, pictures or points.

        Raises:
            LookupError: there is none.
        """
        found, version, world = self.find(name)
        kept = self._kept[part]
        # Who asks while it is made waits for it, and does not make another.
        with self._making[part]:
            if (found, version) not in kept:
                kept[found, version] = self._make[part](world, found)
                if len(kept) > _KEPT:
                    kept.popitem(last=False)
            kept.move_to_end((found, version))
            return kept[found, version]


def page_routes(pages: Pages) -> Sequence[BaseRoute]:
    """Routes of the page: `/` for the first map, `/page/NAME` for any, and below it what comes later or changes."""

    def told(make: Callable[[str | None], Response]) -> Callable[[Request], Awaitable[Response]]:
        async def tell(request: Request) -> Response:
            try:
                return await run_in_threadpool(make, request.path_params.get("name"))
            except LookupError as error:
                return PlainTextResponse(f"{error}\n", status_code=404)

        return tell

    def page(name: str | None) -> Response:
        head = {"content-security-policy": policy(live=True) + "; frame-ancestors 'none'"}
        return HTMLResponse(pages.get(name), headers=head)

    def signs(name: str | None) -> Response:
        _, _, world = pages.find(name)
        return JSONResponse(_newest(world))

    def ground(name: str | None) -> Response:
        return Response(pages.get(name, "ground"), media_type="application/json")

    def pictures(name: str | None) -> Response:
        return Response(pages.get(name, "pictures"), media_type="application/json")

    def points(name: str | None) -> Response:
        return Response(pages.get(name, "points"), media_type="application/octet-stream")

    below = {"": page, "/signs": signs, "/ground": ground, "/pictures": pictures, "/points": points}
    return [Route("/", told(page)), *(Route("/page/{name}" + each, told(make)) for each, make in below.items())]


def _newest(world: LanguageMap) -> dict[str, Any]:
    """What of a page may change while it is shown."""
    poses = world.frame_poses()
    return {"trajectory": way_record(poses.world_from_camera, poses.timestamps), **said_record(world)}
