"""`lpslam run --view`: a run in progress, in a real browser and by plain connections."""

import os
import re
import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from command_line import Command
from in_chromium import chromium, need_chromium, shown, until
from lpslam.isolated import python_command
from lpslam.mapfile.language_map import LanguageMap

pytestmark = pytest.mark.slow

CODE = "import sys; sys.argv = ['lpslam', *sys.argv[1:]]; from lpslam.__main__ import main; main()"


class Run:
    """A run with a page, in a process of its own; what is not played at once is stopped at the end."""

    def __init__(self, walk: Path, folder: Path, *options: str) -> None:
        self.map = folder / "walk.lpmap"
        words = ["run", str(walk), "-o", str(self.map), "--view", "--port", "0", *options]
        self.process = subprocess.Popen(
            python_command(CODE, *words), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, cwd=folder
        )
        assert self.process.stderr is not None
        said = self.process.stderr.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)", said)
        assert found is not None, said + self.process.stderr.read()
        self.url, self.port = found[0], int(found[1])

    def watch(self) -> socket.socket:
        """A watcher that reads nothing but the first words."""
        watcher = socket.create_connection(("127.0.0.1", self.port), timeout=20)
        watcher.sendall(f"GET /watch HTTP/1.1\r\nhost: 127.0.0.1:{self.port}\r\n\r\n".encode())
        assert watcher.recv(15).startswith(b"HTTP/1.1 200")
        return watcher

    def end(self, seconds: float = 120) -> LanguageMap:
        assert self.process.wait(seconds) == 0
        return LanguageMap.load(self.map)


@pytest.fixture
def run(walk: Path, tmp_path: Path) -> Iterator[Run]:
    one = Run(walk, tmp_path)
    with one.process:
        yield one
        one.process.kill()


def test_labels_appear_as_they_are_found_and_questions_are_answered(run: Run) -> None:
    need_chromium()
    with chromium() as browser, shown(browser, run.url, own=run.url, troubles_are_meant=True) as page:
        until(page, "lpslamPage.travelled() > 2", 60)
        until(page, "document.querySelectorAll('#signs button').length > 0", 60)
        first = page.locator("#signs button").count()
        until(page, f"document.querySelectorAll('#signs button').length > {first}", 60)
        assert run.process.poll() is None, "the run ended before anything was seen to grow"
        until(page, "lpslamPage.drawn()", 60)
        # How tracking is, and what has happened, in the visitor's language.
        until(page, "document.getElementById('status').textContent.startsWith('Verfolgt')", 60)
        assert "Schlüsselbilder" in page.locator("#counts").inner_text()
        page.locator("#happened summary").click()
        assert page.locator("#happened li").last.locator("span").first.inner_text() == "Karte begonnen"
        # In space as well: points of the room so far, the camera, and a view through its lens.
        page.locator("#in-space").click()
        until(page, "lpslamPage.points() > 1000", 60)
        page.locator("#lens").click()
        until(page, "document.getElementById('lens').getAttribute('aria-pressed') === 'true'")
        page.locator("#as-plan").click()
        page.locator("#signs button").first.click()
        page.locator("#card button", has_text="Umbenennen").click()
        page.fill("#card input", "Zum <b>goldenen</b> Hirsch")
        page.keyboard.press("Enter")
        until(page, "[...document.querySelectorAll('#signs button')].some(each => each.textContent.includes('Hirsch'))")
        for number, (question, words) in enumerate((("Where can I buy a book?", "at ("), ("哪里可以买书？", "位于"))):
            page.fill("#question", question)
            page.press("#question", "Enter")
            until(page, f"document.querySelectorAll('#log .answer')[{number}]?.textContent.length > 1", 60)
            answer = page.locator("#log .answer").nth(number).inner_text()
            assert words in answer or not page.evaluate("lpslamPage.chosen()"), answer
        assert run.process.poll() is None, "the run ended before it was asked"
        until(page, "document.getElementById('status').className === 'ended'", 120)
        world = run.end()
        until(page, f"document.querySelectorAll('#signs button').length === {len(world.landmarks())}")
        assert any(mark.name == "Zum <b>goldenen</b> Hirsch" for mark in world.landmarks())
        assert page.locator("b").count() == 0
        # Nobody answers any more, and names are still found.
        mark = world.landmarks()[0]
        page.fill("#question", mark.name)
        page.press("#question", "Enter")
        until(page, f"lpslamPage.chosen() === {mark.id}")


def test_a_page_that_was_away_goes_on_and_one_that_does_not_read_holds_up_nobody(run: Run) -> None:
    need_chromium()
    silent = run.watch()
    with chromium() as browser, shown(browser, run.url, own=run.url, troubles_are_meant=True) as page:
        until(page, "lpslamPage.travelled() > 2", 60)
        page.context.set_offline(True)
        page.wait_for_timeout(300)
        page.context.set_offline(False)
        page.reload()
        until(page, "lpslamPage.travelled() > 10", 60)
        # One goes without a word, in the middle of everything.
        page.close()
    run.end()
    silent.close()


def test_the_run_goes_on_when_its_page_is_killed(run: Run) -> None:
    children = Path(f"/proc/{run.process.pid}/task/{run.process.pid}/children")
    if not children.exists():
        pytest.skip("this system does not say which processes are whose")
    watcher = run.watch()
    for child in map(int, children.read_text().split()):
        if "watching" in Path(f"/proc/{child}/cmdline").read_bytes().decode("utf-8", "replace"):
            os.kill(child, signal.SIGKILL)
    assert run.end().landmarks()
    assert run.process.stderr is not None
    assert "the page is lost; the run goes on" in run.process.stderr.read()
    watcher.close()


def test_a_port_that_is_taken_is_one_line(lpslam: Command, walk: Path, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        said = lpslam("run", walk, "-o", tmp_path / "x.lpmap", "--view", "--port", taken.getsockname()[1]).complaint
    assert "--port" in said
    assert not (tmp_path / "x.lpmap").exists()


def test_a_camera_that_is_looked_for_makes_no_map_to_watch(lpslam: Command, walk: Path, walked: Path) -> None:
    said = lpslam("run", walk, "--localize", walked, "--trajectory", walk / "x.txt", "--view").complaint
    assert "--view" in said
