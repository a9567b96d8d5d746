"""Reading asks nobody on a network, and leaves nothing in the user's home."""

import os
import subprocess
import sys
from pathlib import Path

_READ = """
import sys

def note(event, args):
    # A request fails here for want of a network; that it is tried is what counts.
    if event in ("urllib.Request", "socket.getaddrinfo", "socket.connect", "socket.sendto"):
        print(event, args[:2])

sys.addaudithook(note)
import numpy as np
from lpslam.config import Config
from lpslam.text.reading.spotting import PaddleSpotter
PaddleSpotter(Config().text.spotting).detect(np.full((96, 128, 3), 200, np.uint8))
import threading
for thread in threading.enumerate():
    if thread is not threading.main_thread() and not thread.daemon:
        thread.join(5.0)
print("read")
"""


def test_reading_asks_nobody_and_leaves_nothing_in_the_home(tmp_path: Path) -> None:
    # Where CI is said, OpenVINO's package that reports its import is silent by itself.
    kept = {name: value for name, value in os.environ.items() if name not in ("CI", "GITHUB_ACTIONS")}
    done = subprocess.run(
        [sys.executable, "-c", _READ], env={**kept, "HOME": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    assert done.stdout == "read\n", done.stderr
    assert not list(tmp_path.rglob("*intel*"))
