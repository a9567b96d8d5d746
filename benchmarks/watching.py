"""What it costs to watch a run: processor seconds of runs of one recording with 0, 1 and 10 watchers, in turn.

    python benchmarks/watching.py RECORDING [--rounds 3] [--live] [--frames 300] [--space]
    python benchmarks/watching.py RECORDING --alone [--frames 300]

Every watcher takes the room's picture whenever there is a newer one, or with --space its new points.

Processor time of the run and of the page's process together; with --live also frames dropped. With --alone one run is
written down, and told once more, as fast as it was, to a page's process of its own: with 1 and 10 watchers on the plan,
then in space. What that costs from the first watcher on tells ten watchers from one on a machine whose runs differ by
more than that.
"""

import argparse
import json
import os
import re
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from pathlib import Path
from typing import Self

from lpslam.config import Config
from lpslam.isolated import python_command
from lpslam.serving.watching.feed import Feed
from lpslam.serving.watching.wire import Begin, Message, send

PATIENCE_S = 600.0  # for a page's process, which comes after all others on a busy machine
CODE = "import sys; sys.argv = ['lpslam', *sys.argv[1:]]; from lpslam.__main__ import main; main()"


def watch(url: str, received: list[int], in_space: bool) -> None:
    """Read events until the page ends; take the room's picture, or in space its new points, whenever there are any."""
    count, version = 0, 0

    def take(name: str) -> bytes:
        nonlocal count
        with urllib.request.urlopen(f"{url}/{name}", timeout=PATIENCE_S) as response:
            content: bytes = response.read()
        count += len(content)
        return content

    def take_points() -> None:
        nonlocal version
        (version,) = struct.unpack("<I", take(f"points?since={version}")[:4])

    try:
        with urllib.request.urlopen(f"{url}/watch", timeout=PATIENCE_S) as events:
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


def told(recording: Path, frames: int) -> tuple[list[tuple[float, Message]], float]:
    """What a run tells a page with one watcher, each with its second, and what telling costs the run, in seconds."""
    from lpslam.pipeline import run
    from lpslam.sources.open import open_source

    kept: list[tuple[float, Message]] = []
    spent = 0.0

    class Written(Feed):
        """Writes down what it would tell, as if somebody watched."""

        def __enter__(self) -> Self:
            self._watchers = 1
            self._tell(self._begin)
            self._woken.set()
            self._threads = [threading.Thread(), threading.Thread(target=self._feed)]
            self._threads[1].start()
            return self

        def _tell(self, message: Message) -> None:
            kept.append((time.monotonic(), message))

        def _feed(self) -> None:
            nonlocal spent
            super()._feed()
            spent = time.thread_time()

    config = Config()
    with Written(Begin(recording.name, 0, config, total=frames)) as feed:
        world = run(open_source(recording, max_frames=frames), config, sequential=False, on_step=feed.on_step)
        feed.end(world, "map.lpmap")
    return kept, spent


def told_again(kept: list[tuple[float, Message]], watchers: int, in_space: bool) -> dict[str, float]:
    """The same told to a page's process that so many watch: its processor time from the first of them on."""
    received: list[int] = []
    code = "from lpslam.serving.watching.process import main; main()"
    with subprocess.Popen(python_command(code), stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        send(process.stdin, kept[0][1])
        url = process.stdout.readline().decode().split()[1]
        threading.Thread(target=process.stdout.read, daemon=True).start()
        try:
            with urllib.request.urlopen(url, timeout=PATIENCE_S) as response:
                response.read()
        except OSError:
            process.kill()
            raise
        # What is compiled at first is no watcher's.
        time.sleep(10)
        before, began = _processor_s(process.pid), time.monotonic()
        threads = [threading.Thread(target=watch, args=(url, received, in_space)) for _ in range(watchers)]
        for thread in threads:
            thread.start()
        for at, message in kept[1:]:
            time.sleep(max(0.0, began + at - kept[0][0] - time.monotonic()))
            send(process.stdin, message)
        seconds = time.monotonic() - began
        process.stdin.close()
        _, _, used = os.wait4(process.pid, 0)
        process.returncode = 0
        for thread in threads:
            thread.join(10)
    spent = used.ru_utime + used.ru_stime - before
    return {
        "processor_s": round(spent, 2),
        "seconds": round(seconds, 1),
        "percent": round(100 * spent / seconds, 2),
        "megabytes": round(sum(received) / 1e6, 2),
    }


def _processor_s(process: int) -> float:
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--live", action="store_true")
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--space", action="store_true")
    parser.add_argument("--alone", action="store_true")
    given = parser.parse_args()
    if given.alone:
        kept, spent = told(given.recording, given.frames)
        print(json.dumps({"telling_s": round(spent, 2), "of_s": round(kept[-1][0] - kept[0][0], 1)}), flush=True)
        for in_space in (False, True):
            for watchers in (1, 10):
                costs = told_again(kept, watchers, in_space)
                print(json.dumps({"watchers": watchers, "in": "space" if in_space else "plan", **costs}), flush=True)
        return
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
