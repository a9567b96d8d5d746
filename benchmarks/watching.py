"""What it costs to watch a run: processor seconds of runs of one recording with 0, 1 and 10 watchers, in turn.

    python benchmarks/watching.py RECORDING [--rounds 3] [--live] [--frames 300] [--space]

Every watcher takes the room's picture whenever there is a newer one, or with --space its new points.

Processor time of the run and of the page's process together; with --live also frames dropped.
"""

import argparse
import json
import re
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import urllib.request
from pathlib import Path

CODE = "import sys; sys.argv = ['lpslam', *sys.argv[1:]]; from lpslam.__main__ import main; main()"


def watch(url: str, received: list[int], in_space: bool) -> None:
    """Read events until the page ends; take the room's picture, or in space its new points, whenever there are any."""
    count, version = 0, 0

    def take(name: str) -> bytes:
        nonlocal count
        with urllib.request.urlopen(f"{url}/{name}", timeout=60) as response:
            content: bytes = response.read()
        count += len(content)
        return content

    def take_points() -> None:
        nonlocal version
        (version,) = struct.unpack("<I", take(f"points?since={version}")[:4])

    try:
        with urllib.request.urlopen(f"{url}/watch", timeout=60) as events:
            for number, line in enumerate(events):
                count += len(line)
                if in_space and (number == 0 or line == b"event: points\n"):
                    take_points()
                elif not in_space and (number == 0 or line == b"event: picture\n"):
                    take("picture")
                elif line == b"event: end\n":
                    # As the page does: the last of both.
                    take_points()
                    take("picture?last=true")
    except OSError:
        pass
    received.append(count)


def once(recording: Path, watchers: int | None, options: list[str], in_space: bool) -> dict[str, float]:
    """One run, its page watched by so many; None: a run without a page."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    received: list[int] = []
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "map.lpmap"
        words = [sys.executable, "-c", CODE, "run", str(recording), "-o", str(output), *options]
        if watchers is not None:
            words += ["--view", "--port", "0"]
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            if watchers:
                found = re.search(r"http://[\d.:]+", process.stderr.readline())
                assert found is not None
                for _ in range(watchers):
                    threading.Thread(target=watch, args=(found[0], received, in_space)).start()
            process.communicate()
        facts = subprocess.run(
            [sys.executable, "-c", CODE, "info", str(output), "--json"], capture_output=True, text=True, check=True
        ).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = json.loads(facts)["statistics"]["run"]
    return {
        "processor_s": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "tracking_s": run["seconds_tracking_and_mapping"],
        "seconds": run["seconds"],
        "dropped": run["frames_dropped"],
        "megabytes": sum(received) / 1e6,
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--space", action="store_true")
    given = parser.parse_args()
    options = ["--max-frames", str(given.frames), *(["--live"] if given.live else [])]
    found: dict[int | None, list[dict[str, float]]] = {None: [], 0: [], 1: [], 10: []}
    for _ in range(given.rounds):
        for watchers, runs in found.items():
            runs.append(once(given.recording, watchers, options, given.space))
    for watchers, runs in found.items():
        medians = {key: round(statistics.median(run[key] for run in runs), 2) for key in runs[0]}
        print(json.dumps({"watchers": "no page" if watchers is None else watchers, **medians}), flush=True)


if __name__ == "__main__":
    main()
