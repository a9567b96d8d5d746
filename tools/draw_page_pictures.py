"""Draw the pictures of the page that the documents show, in Debian's Chromium.

    python tools/draw_page_pictures.py mall MAP.lpmap docs/images        # or coffee, plan
    python tools/draw_page_pictures.py growing RECORDING docs/images

Maps are served by `lpslam view` and asked as a visitor asks; a recording is mapped by `lpslam run --view`, and its page
drawn once two questions are answered. Needs chromium and playwright.
"""

import argparse
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from in_chromium import PATIENCE_S, chromium, until

SIZE, QUALITY = (1280, 800), 80
SIGNS = 3  # that a run has found when its page is drawn


@contextmanager
def served(*words: str) -> Iterator[str]:
    """The address of a page that a command serves, until it is left."""
    with subprocess.Popen([sys.executable, "-m", "lpslam", *words], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        found = re.search(r"http://\S+:\d+", process.stderr.readline())
        assert found is not None
        try:
            yield found[0]
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate()


@contextmanager
def page_of(url: str) -> Iterator[Any]:
    """A page as a visitor with a light screen has it."""
    with chromium() as browser:
        size = {"width": SIZE[0], "height": SIZE[1]}
        page = browser.new_context(viewport=size, locale="en-US", reduced_motion="reduce").new_page()
        page.set_default_timeout(PATIENCE_S * 1000.0)
        page.goto(url)
        until(page, "!!window.lpslamPage && lpslamPage.drawn()")
        yield page


@contextmanager
def viewed(map_file: Path) -> Iterator[Any]:
    """The page of a map."""
    with served("view", str(map_file), "--port", "0", "--no-browser") as url, page_of(url) as page:
        # The ground and the pictures of signs come with all that is loaded after the page.
        page.evaluate("fetch('maps').then(answer => answer.json())")
        page.wait_for_timeout(2000)
        yield page


def keep(page: Any, out: Path) -> None:
    """The page as it is, once it is drawn whole."""
    if page.locator("#in-space[aria-pressed=true]").count():
        until(page, "lpslamPage.points() > 0 && lpslamPage.drawnPoints() === lpslamPage.points()")
    # A moment for pictures of cards, and for signs to be arranged by what is in sight.
    page.wait_for_timeout(1500)
    with tempfile.TemporaryDirectory() as folder:
        page.screenshot(path=f"{folder}/page.png")
        Image.open(f"{folder}/page.png").convert("RGB").save(out, quality=QUALITY, method=6)
    print(out, flush=True)


def ask(page: Any, question: str) -> None:
    """Ask, and wait for the answer, and for the way where there is one."""
    page.fill("#question", question)
    page.press("#question", "Enter")
    last = "[...document.querySelectorAll('#log .answer')].pop()"
    until(page, f"{last}?.textContent.length > 5")
    page.wait_for_timeout(3000)


def draw_plan(map_file: Path, folder: Path) -> None:
    with viewed(map_file) as page:
        page.locator("#signs button").first.click()
        until(page, "Boolean(document.querySelector('#card img')?.complete)")
        page.locator("#whole").click()
        keep(page, folder / "page.webp")


def draw_mall(map_file: Path, folder: Path) -> None:
    with viewed(map_file) as page:
        page.locator("#in-space").click()
        keep(page, folder / "page-space.webp")
        ask(page, "Where can I get fast food nearby?")
        # From farther off and from above the way is seen too.
        page.locator("#map").focus()
        for key in "-----":
            page.keyboard.press(key)
        for _ in range(4):
            page.keyboard.press("ArrowUp")
        keep(page, folder / "page-asked.webp")
        page.locator("#card button", has_text="Rename").click()
        keep(page, folder / "page-correct.webp")


def draw_coffee(map_file: Path, folder: Path) -> None:
    with viewed(map_file) as page:
        ask(page, "First the menu with Colombia, then the house blend coffee, then think")
        keep(page, folder / "page-plan.webp")
    with viewed(map_file) as page:
        page.locator("#in-space").click()
        page.locator("#signs button", has_text="COLOMBIA").click()
        keep(page, folder / "page-sign.webp")
        page.locator("#card .head button").click()
        page.locator("#lens").click()
        page.locator("#moment").fill("9")
        keep(page, folder / "page-lens.webp")


def draw_growing(recording: Path, folder: Path) -> None:
    with tempfile.TemporaryDirectory() as made:
        words = ("run", str(recording), "-o", f"{made}/map.lpmap", "--view", "--port", "0", "--max-frames", "300")
        with served(*words) as url, page_of(url) as page:
            until(page, f"document.querySelectorAll('#signs button').length >= {SIGNS}")
            name = page.locator("#signs button").first.inner_text().strip()
            ask(page, f"Where is {name}?")
            ask(page, f"{name}在哪里？")
            keep(page, folder / "growing.webp")


DRAWN = {"mall": draw_mall, "coffee": draw_coffee, "plan": draw_plan, "growing": draw_growing}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=DRAWN)
    parser.add_argument("shown", type=Path)
    parser.add_argument("folder", type=Path)
    given = parser.parse_args()
    DRAWN[given.what](given.shown, given.folder)


if __name__ == "__main__":
    main()
