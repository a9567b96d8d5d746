"""`lpslam view`: the browser is opened once the page can be had, at the port that was found."""

import os
import signal
import socket
import threading
import urllib.request
from pathlib import Path

import pytest

from command_line import Command
from lpslam.views import browser
from small_maps import small_map


@pytest.mark.slow
def test_the_browser_is_opened_when_the_page_can_be_had(
    lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_map().save(tmp_path / "mall.lpmap")
    seen: list[tuple[int, bytes]] = []

    def look(url: str) -> None:
        with urllib.request.urlopen(url, timeout=120) as answer:
            seen.append((answer.status, answer.read()))
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(
        "lpslam.cli_serving.open_browser", lambda url: threading.Thread(target=look, args=(url,)).start()
    )
    done = lpslam("view", tmp_path / "mall.lpmap", "--port", 0)
    assert done.code == 0, done.err
    ((status, body),) = seen
    assert status == 200
    assert b"map-data" in body


def test_no_browser_is_opened_where_the_port_is_taken(
    lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_map().save(tmp_path / "mall.lpmap")
    opened: list[str] = []
    monkeypatch.setattr("lpslam.cli_serving.open_browser", opened.append)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        said = lpslam("view", tmp_path / "mall.lpmap", "--port", taken.getsockname()[1]).complaint
    assert "--port" in said
    assert opened == []


def test_without_a_screen_no_browser_takes_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    monkeypatch.setattr(browser.sys, "platform", "linux")
    for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(variable, raising=False)
    browser.open_browser("http://127.0.0.1:1/")
    assert opened == []
