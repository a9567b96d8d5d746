"""`lpslam run --view`: a run in progress, in a real browser and by plain connections."""

import os
import re
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from command_line import Command
from in_chromium import PATIENCE_S, chromium, need_chromium, shown, until
from lpslam.isolated import python_command
from lpslam.mapfile.language_map import LanguageMap

pytestmark = pytest.mark.slow

FRAMES = 120  # of the walk

CODE = """
import sys
from lpslam.session.session import Session

sys.argv = ["lpslam", *sys.argv[1:]]
take = Session.take

def take_when_let(self, frame):
    sys.stdin.readline()
    return take(self, frame)

Session.take = take_when_let
from lpslam.__main__ import main
main()
"""
"""`lpslam`, whose runs take a frame for each line that they are given, and all the others once these have ended."""


class Run:
    """A run with a page, in a process of its own; what is not played at once is stopped at the end."""

    def __init__(self, walk: Path, folder: Path, frames: int = FRAMES, *more: str) -> None:
        self.map = folder / "walk.lpmap"
        words = ["run", str(walk), "-o", str(self.map), "--view", "--port", "0", "--max-frames", str(frames), *more]
        self.process = subprocess.Popen(
            python_command(CODE, *words),
            stdin=subprocess.PIPE,
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            cwd=folder,
        )
        self.frames = 0
        assert self.process.stderr is not None
        said = self.process.stderr.readline()
        found = re.search(r"http://127\.0\.0\.1:(\d+)", said)
        assert found is not None, said + self.process.stderr.read()
        self.url, self.port = found[0], int(found[1])

    def watch(self) -> socket.socket:
        """A watcher that reads nothing but the first words."""
        watcher = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE_S)
        watcher.sendall(f"GET /watch HTTP/1.1\r\nhost: 127.0.0.1:{self.port}\r\n\r\n".encode())
        assert watcher.recv(15).startswith(b"HTTP/1.1 200")
        return watcher

    def let(self, frames: int, page: Any) -> None:
        """Let a held run take so many frames more, and wait until a page has been told of the last of them."""
        assert self.process.stdin is not None
        self.frames += frames
        self.process.stdin.write("\n" * frames)
        self.process.stdin.flush()
        until(page, f"document.getElementById('counts').textContent.startsWith('{self.frames} ')")

    def let_until(self, expression: str, page: Any) -> None:
        """Let a held run go on until an expression holds in a page, however fast either is."""
        while not page.evaluate(expression):
            assert self.frames < FRAMES, f"{expression} has not come true when the run has taken all its frames"
            self.let(3, page)

    def go_on(self) -> None:
        """Hold the run no longer."""
        assert self.process.stdin is not None
        self.process.stdin.close()

    def end(self, seconds: float = PATIENCE_S) -> LanguageMap:
        assert self.process.wait(seconds) == 0
        return LanguageMap.load(self.map)


@contextmanager
def held(run: Run) -> Iterator[Run]:
    with run.process:
        yield run
        run.process.kill()


@pytest.fixture
def held_run(walk: Path, tmp_path: Path) -> Iterator[Run]:
    """One that takes the frames that the test lets it take, and is shown in a browser."""
    need_chromium()
    with held(Run(walk, tmp_path)) as run:
        yield run


@pytest.fixture
def short_run(walk: Path, tmp_path: Path) -> Iterator[Run]:
    """The same of the walk's beginning, without a reader."""
    with held(Run(walk, tmp_path, 8, "--no-text")) as run:
        yield run


def test_labels_appear_as_they_are_found_and_questions_are_answered(held_run: Run) -> None:
    run = held_run
    with chromium() as browser, shown(browser, run.url, own=run.url, troubles_are_meant=True) as page:
        until(page, "document.getElementById('status').textContent.startsWith('Warten')")
        run.let_until("lpslamPage.travelled() > 2", page)
        run.let_until("document.querySelectorAll('#signs button').length > 0", page)
        first = page.locator("#signs button").count()
        run.let_until(f"document.querySelectorAll('#signs button').length > {first}", page)
        run.let_until("lpslamPage.drawn()", page)
        # How tracking is, and what has happened, in the visitor's language.
        until(page, "document.getElementById('status').textContent.startsWith('Verfolgt')")
        assert "Schlüsselbilder" in page.locator("#counts").inner_text()
        page.locator("#happened summary").click()
        assert page.locator("#happened li").last.locator("span").first.inner_text() == "Karte begonnen"
        # In space as well: points of the room so far, the camera, and a view through its lens.
        page.locator("#in-space").click()
        run.let_until("lpslamPage.points() > 1000", page)
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
            until(page, f"document.querySelectorAll('#log .answer')[{number}]?.textContent.length > 1")
            answer = page.locator("#log .answer").nth(number).inner_text()
            assert words in answer or not page.evaluate("lpslamPage.chosen()"), answer
        run.go_on()
        until(page, "document.getElementById('status').className === 'ended'")
        world = run.end()
        until(page, f"document.querySelectorAll('#signs button').length === {len(world.landmarks())}")
        assert any(mark.name == "Zum <b>goldenen</b> Hirsch" for mark in world.landmarks())
        assert page.locator("b").count() == 0
        # Nobody answers any more, and names are still found.
        mark = world.landmarks()[0]
        page.fill("#question", mark.name)
        page.press("#question", "Enter")
        until(page, f"lpslamPage.chosen() === {mark.id}")


def test_a_page_that_was_away_goes_on_and_one_that_does_not_read_holds_up_nobody(held_run: Run) -> None:
    run = held_run
    silent = run.watch()
    with chromium() as browser, shown(browser, run.url, own=run.url, troubles_are_meant=True) as page:
        run.let_until("lpslamPage.travelled() > 2", page)
        page.context.set_offline(True)
        page.wait_for_timeout(300)
        page.context.set_offline(False)
        page.reload()
        run.let_until("lpslamPage.travelled() > 10", page)
        # One goes without a word, in the middle of everything.
        page.close()
    run.go_on()
    run.end()
    silent.close()


def test_the_run_goes_on_when_its_page_is_killed(short_run: Run) -> None:
    run = short_run
    children = Path(f"/proc/{run.process.pid}/task/{run.process.pid}/children")
    if not children.exists():
        pytest.skip("this system does not say which processes are whose")
    watcher = run.watch()
    for child in map(int, children.read_text().split()):
        if "watching" in Path(f"/proc/{child}/cmdline").read_bytes().decode("utf-8", "replace"):
            os.kill(child, signal.SIGKILL)
    run.go_on()
    assert run.end().trajectory.tracked_count == 8
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
