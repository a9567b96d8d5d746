"""Pages in a real browser: who asks whom for what, and what goes wrong on the way; skipped where there is none."""

import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")

PATIENCE_S = 300.0
"""Of all waiting: what takes a second on a free machine may take minutes on a busy one, and is right then too."""

_HOW_IT_IS_DRAWN = "GPU stall due to ReadPixels"
"""What Chromium says of its own work where it shows a WebGL canvas without a graphics processor."""


def need_chromium() -> Any:
    """Playwright's interface; skips the test where it or Chromium is not installed."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    if CHROMIUM is None:
        pytest.skip("Chromium is not installed")
    return sync_api


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser."""
    with need_chromium().sync_playwright() as started:
        opened = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        yield opened
        opened.close()


@contextmanager
def shown(browser: Any, url: str, own: str = "", troubles_are_meant: bool = False, **context: Any) -> Iterator[Any]:
    """A page; whoever else than itself, or `own`, it asks for anything fails the test, and so does any trouble."""
    options = {"viewport": {"width": 1100, "height": 700}, "locale": "de-DE"} | context
    inside = browser.new_context(**options)
    inside.set_default_timeout(PATIENCE_S * 1000.0)
    page = inside.new_page()
    asked: list[str] = []
    troubles: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    page.on("pageerror", lambda error: troubles.append(str(error)))
    page.on("console", lambda line: None if _HOW_IT_IS_DRAWN in line.text else troubles.append(line.text))
    page.goto(url)
    yield page
    allowed = ("file:", "data:", "blob:", *([own] if own else []))
    assert [each for each in asked if not each.startswith(allowed)] == []
    assert troubles_are_meant or troubles == [], troubles
    inside.close()


def processor_s() -> float:
    """Seconds of processor time of all browsers that this process has started, with all that they have started."""
    spent, parents, browsers = {}, {}, set()
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            fields = (folder / "stat").read_text().rsplit(")", 1)[1].split()
            number = int(folder.name)
            parents[number], spent[number] = int(fields[1]), int(fields[11]) + int(fields[12])
            if b"chrom" in (folder / "cmdline").read_bytes():
                browsers.add(number)

    def is_ours(number: int) -> bool:
        return number == os.getpid() or (number in parents and is_ours(parents[number]))

    return sum(spent[each] for each in browsers if is_ours(each)) / os.sysconf("SC_CLK_TCK")


def until(page: Any, expression: str, seconds: float = PATIENCE_S) -> None:
    """Wait until an expression holds in a page, whose policy forbids Playwright's own way of waiting."""
    end = time.monotonic() + seconds
    while not page.evaluate(expression):
        assert time.monotonic() < end, f"{expression} does not come true"
        page.wait_for_timeout(50)
