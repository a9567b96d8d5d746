"""How long it takes from `lpslam view MAP` to the room on the page, in a browser that is open already.

Needs Debian's chromium and playwright. Usage: python benchmarks/page_first.py MAP [TIMES]
"""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from in_chromium import CHROMIUM, until


def main(map_file: Path, times: int) -> None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for _ in range(times):
            page, drawn, spent = once(map_file, browser)
            print(f"served after {page:.2f} s, drawn after {drawn:.2f} s; the server's processor time {spent:.2f} s")
        browser.close()


def once(map_file: Path, browser: Any) -> tuple[float, float, float]:
    """Seconds until the address is known, and until the room is drawn; processor seconds of the server until then."""
    began = time.monotonic()
    words = [sys.executable, "-m", "lpslam", "view", str(map_file), "--port", "0", "--no-browser"]
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        found = re.search(r"http://\S+:\d+", process.stderr.readline())
        assert found is not None
        served = time.monotonic() - began
        page = browser.new_page()
        page.goto(found[0])
        until(page, "lpslamPage.drawn()", 120)
        drawn = time.monotonic() - began
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        spent = (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
        page.close()
        process.send_signal(signal.SIGINT)
    return served, drawn, spent


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 3)
