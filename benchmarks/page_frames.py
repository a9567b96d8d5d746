"""How many frames a second the map in space is shown with, while it turns, where a processor draws all of it.

Also what a frame costs of all processors, which depends little on what else a machine does.

Needs Debian's chromium and playwright. Usage: python benchmarks/page_frames.py [POINTS ...] [--signs 10000]
"""

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from in_chromium import CHROMIUM, processor_s
from lpslam.page.building import write_page
from page_hall import hall, signs, turned
from small_maps import small_map

SIZES = ((1920, 1080), (1280, 800), (390, 844))


def main(counts: list[int], sign_count: int) -> None:
    from playwright.sync_api import sync_playwright

    folder = Path(tempfile.mkdtemp())
    file = write_page(small_map(), folder / "page.html")
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for count in counts:
            for wide, high in SIZES:
                page = browser.new_context(viewport={"width": wide, "height": high}).new_page()
                page.goto(file.as_uri())
                page.locator("#in-space").click()
                hall(page, count)
                if sign_count:
                    signs(page, sign_count)
                # The first frames are those in which it is found out how much there is time for.
                turned(page, 6.0)
                frames, spent = page.evaluate("lpslamPage.pace().frames"), processor_s()
                told = turned(page, 10.0)
                each = (processor_s() - spent) / max(1, page.evaluate("lpslamPage.pace().frames") - frames)
                print(f"{count:,} points, {wide} x {high}: {told}, {1000 * each:.0f} ms of processors each", flush=True)
                page.context.close()
        browser.close()
    shutil.rmtree(folder)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("points", type=int, nargs="*")
    parser.add_argument("--signs", type=int, default=0)
    given = parser.parse_args()
    main(given.points or [200_000, 1_000_000], given.signs)
