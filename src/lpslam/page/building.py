"""One HTML file of a map: the ground from above, signs as words, a field that searches or asks.

No request leaves the page but to its own server: the policy in its head forbids it. Whatever signs say travels as JSON
in which no tag can begin, and is shown as text.
"""

import base64
import hashlib
import json
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

from lpslam.config import PageConfig
from lpslam.language.languages import LANGUAGES
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.record import empty_record, ground_record, map_record, room_points
from lpslam.page.signs import sign_pictures
from lpslam.whole_files import written_whole

SCRIPTS = (
    *("common", "boxes", "plan", "lenses", "hiding", "painting", "points", "plates", "space", "moving", "replay"),
    *("correcting", "signs", "ways", "wishes", "asking", "speech", "memory", "growing", "start"),
)
"""The parts of the page's program: each uses what those before it define."""


def write_page(world: LanguageMap, out: Path, config: PageConfig | None = None) -> Path:
    """Write a page that needs no server: it shows the map, and finds signs by name.

    Args:
        world: the map.
        out: the file.
        config: how much of it is shown.

    Raises:
        UserError: the file cannot be written.
    """
    with written_whole(out, "page") as part:
        part.write_text(page_of(world, live=False, config=config), encoding="utf-8")
    return out


def page_of(world: LanguageMap, *, live: bool, name: str = "", config: PageConfig | None = None) -> str:
    """The page as text.

    Args:
        world: the map.
        live: whether a server beside it answers questions, and tells what of the map comes later.
        name: of the map, as the server knows it.
        config: how much of it is shown.
    """
    config = config or PageConfig()
    record = {**map_record(world, config.room, soon=live), "name": name, "live": live, "grows": False}
    if live:
        return _page(record, live)
    points = room_points(world, config.file_points, config)
    alone = {"ground": ground_record(world), "pictures": sign_pictures(world, config.file_picture_bytes, config)}
    return _page({**record, **alone}, live, points.text())


def growing_page(title: str) -> str:
    """The page of a map that is being made, which a server beside it tells how far it is."""
    return _page({**empty_record(title), "name": "", "live": True, "grows": True}, live=True)


def _page(record: dict[str, Any], live: bool, points: str = "") -> str:
    parts = {
        "@policy@": policy(live),
        "@style@": _asset("page.css"),
        "@script@": _script(),
        "@points@": points,
        "@data@": _as_json({**record, "words": _words()}),
    }
    page = _asset("page.html")
    # Each mark once, from the last on: what is put in is never looked through for marks.
    for mark in sorted(parts, key=page.index, reverse=True):
        before, _, after = page.partition(mark)
        page = before + parts[mark] + after
    return page


@cache
def _script() -> str:
    """All parts of the script in one scope, in their order."""
    parts = "\n".join(_asset(f"{name}.js") for name in SCRIPTS)
    return f'"use strict";\n(() => {{\n{parts}}})();\n'


def policy(live: bool) -> str:
    """What the page may load and run: its own style and script, pictures inside it, and its own server."""
    asked = "; connect-src 'self'" if live else ""
    style, script = _digest(_asset("page.css")), _digest(_script())
    runs = f"img-src data:; style-src '{style}'; script-src '{script}'"
    return f"default-src 'none'; {runs}{asked}; base-uri 'none'; form-action 'none'"


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")


@cache
def _asset(name: str) -> str:
    return files("lpslam.page").joinpath("assets", name).read_text(encoding="utf-8")


def _as_json(tree: Any) -> str:
    """JSON in which no tag begins or ends, and no line ends unseen."""
    text = json.dumps(tree, ensure_ascii=False, separators=(",", ":"))
    for char in "<>&\u2028\u2029":
        text = text.replace(char, f"\\u{ord(char):04x}")
    return text


def _words() -> dict[str, Any]:
    folder = files("lpslam.page").joinpath("words")
    return {each: json.loads(folder.joinpath(f"{each}.json").read_text("utf-8")) for each in LANGUAGES}
