"""Questions a second that `lpslam serve` answers, and how long each takes.

    python benchmarks/serving_load.py --landmarks 1000 --rate 200 --seconds 20

A map of so many boards with names as the drawn streets have them is served by the command itself, on loopback. First
questions are asked one after the other; then they come at a fixed rate, whether or not the ones before are answered,
over connections that stay open, and each one's time counts from when it was due. No question comes twice, unless
`--distinct N` has as many come in any order, over and over, as visitors ask. The processor time of the server and its
processes is read from the system, since the machine may be shared. For the same reason the same questions go first to a
server that reads none of them and always says the same 2 KB: what lies between the two is this program's.
"""

import argparse
import contextlib
import json
import os
import selectors
import socket
import subprocess
import sys
import tempfile
import time
from collections import deque
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.simulation.boards.wording import compose

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests"))
SETS = ("paper", "second", "third", "fourth", "fifth", "sixth", "development", "local_trades", "everyday")


def questions(count: int) -> list[str]:
    """Questions in seven languages, none twice: those of the language benchmarks, and the same with a number."""
    plain: list[str] = []
    for name in SETS:
        path = ROOT / "benchmarks" / "language" / f"{name}.json"
        if path.is_file():
            choosing = json.loads(path.read_text()).get("choosing", [])
            groups = choosing if isinstance(choosing, list) else [choosing]
            plain += [
                each["question"] for group in groups for each in group.get("questions", [group]) if "question" in each
            ]
    plain = list(dict.fromkeys(plain))
    np.random.default_rng(4).shuffle(plain)
    turns = -(-count // len(plain))
    # “… 2”, “… 3”: another question to whoever keeps answers, and as hard to read.
    return [text if turn == 0 else f"{text} ({turn + 1})" for turn in range(turns) for text in plain][:count]


def served_map(folder: Path, landmarks: int) -> Path:
    """A map of so many boards."""
    from small_maps import small_map

    rng = np.random.default_rng(3)
    scripts = ("simplified", "english", "mixed")
    signs = [compose(rng, scripts[number % 3])[0].text for number in range(landmarks)]  # type: ignore[arg-type]
    path = folder / "mall.lpmap"
    small_map(signs).save(path)
    return path


_BARE = """
import sys, uvicorn
ANSWER = b"x" * 2048
HEAD = [(b"content-type", b"application/json"), (b"content-length", b"2048")]
async def app(scope, receive, send):
    if scope["type"] == "http":
        while (await receive()).get("more_body"):
            pass
        await send({"type": "http.response.start", "status": 200, "headers": HEAD})
        await send({"type": "http.response.body", "body": ANSWER})
uvicorn.run(app, port=int(sys.argv[1]), http="h11", lifespan="off", log_level="critical")
"""
"""What any server costs that is made as this one."""


class Asker:
    """A connection that stays open; it asks one question at a time, and costs little itself."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._come = b""
        self.due = 0.0

    def send(self, request: bytes, due: float) -> None:
        """Ask what was due then."""
        self.due, self._come = due, b""
        self.socket.sendall(request)

    def status(self) -> int | None:
        """The status, once the answer is whole; raises where the server hangs up."""
        part = self.socket.recv(1 << 16)
        if not part:
            raise ConnectionError("no answer")
        self._come += part
        head, ends, body = self._come.partition(b"\r\n\r\n")
        if not ends or len(body) < int(head.lower().split(b"content-length: ")[1].split(b"\r\n")[0]):
            return None
        return int(head.split(b" ")[1])


def requests(port: int, texts: list[str]) -> list[bytes]:
    """As they are sent."""
    bodies = [json.dumps({"question": text}).encode() for text in texts]
    head = f"POST /ask HTTP/1.1\r\nhost: 127.0.0.1:{port}\r\ncontent-type: application/json\r\ncontent-length: "
    return [f"{head}{len(body)}\r\n\r\n".encode() + body for body in bodies]


def alone(port: int, texts: list[str]) -> list[float]:
    """Milliseconds of each question, one after the other."""
    asker, spent = Asker(port), []
    for request in requests(port, texts):
        before = time.perf_counter()
        asker.send(request, before)
        while (status := asker.status()) is None:
            pass
        assert status == 200
        spent.append(1000 * (time.perf_counter() - before))
    return spent


def at_rate(port: int, texts: list[str], rate: float) -> tuple[list[float], int, float]:
    """Milliseconds of each question that was answered, from when it was due; how many were not; and seconds."""
    waiting = selectors.DefaultSelector()
    idle: list[Asker] = []
    spent: list[float] = []
    refused = 0
    left = deque(requests(port, texts))
    start = time.perf_counter() + 0.1
    while left or waiting.get_map():
        due = start + (len(texts) - len(left)) / rate
        for key, _ in waiting.select(max(0.0, due - time.perf_counter()) if left else None):
            asker: Asker = key.data
            try:
                status = asker.status()
            except ConnectionError:
                # More connections than the server takes: no answer either.
                status = 503
            if status is not None:
                waiting.unregister(asker.socket)
                spent += [1000 * (time.perf_counter() - asker.due)] if status == 200 else []
                refused += status != 200
                idle += [asker] if status == 200 else []
        if left and time.perf_counter() >= due:
            asker = idle.pop() if idle else Asker(port)
            asker.send(left.popleft(), due)
            waiting.register(asker.socket, selectors.EVENT_READ, asker)
    return spent, refused, time.perf_counter() - start


def processor_seconds(process: int) -> NDArray[np.float64]:
    """(2,) of a process and of its children, so far."""
    spent = [0.0, 0.0]
    for one in [str(process), *Path(f"/proc/{process}/task/{process}/children").read_text().split()]:
        fields = Path(f"/proc/{one}/stat").read_text().rsplit(")", 1)[1].split()
        spent[one != str(process)] += (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return np.array(spent)


def said(spent: list[float]) -> str:
    """Times in a line."""
    median, ninety, last = np.percentile(spent, [50, 90, 99])
    return (
        f"mean {np.mean(spent):.1f} ms, median {median:.1f}, 90 % {ninety:.1f}, 99 % {last:.1f}, most {max(spent):.1f}"
    )


def compared_with(texts: list[str], rate: float) -> None:
    """The same questions to a server that does nothing, and how long it takes."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with subprocess.Popen([sys.executable, "-c", _BARE, str(port)]) as bare:
        try:
            wait_for(port)
            alone(port, texts[:300])
            print("a bare answer, one after the other:", said(alone(port, texts[300:600])))
            spent, _, seconds = at_rate(port, texts[600:], rate)
            print(f"a bare answer, {rate:g} a second for {seconds:.1f} s: {said(spent)}")
        finally:
            bare.terminate()


def wait_for(port: int) -> None:
    """Wait until somebody listens."""
    for _ in range(600):
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1):
            return
        time.sleep(0.1)
    raise TimeoutError(f"nobody listens at port {port}")


def main() -> None:
    """Serve, ask, and say how long it took."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--landmarks", type=int, default=1000)
    parser.add_argument("--rate", type=float, default=200.0)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--distinct", type=int, default=None)
    options = parser.parse_args()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    texts = questions(int(options.rate * options.seconds) + 600)
    if options.distinct is not None:
        chosen = np.random.default_rng(5).integers(0, options.distinct, len(texts) - 600).tolist()
        texts = [*texts[:600], *(texts[600 + at] for at in chosen)]
    compared_with(texts, options.rate)
    with tempfile.TemporaryDirectory() as folder:
        path = served_map(Path(folder), options.landmarks)
        command = ["serve", str(path), "--port", str(port), "--workers", str(options.workers)]
        server = subprocess.Popen([sys.executable, "-m", "lpslam", *command], stderr=subprocess.PIPE, text=True)
        try:
            assert server.stderr is not None
            print(server.stderr.readline().strip())
            alone(port, texts[:300])
            before = processor_seconds(server.pid)
            print("one after the other:", said(alone(port, texts[300:600])))
            here, children = 1000 * (processor_seconds(server.pid) - before) / 300
            print(f"  processor: {here:.1f} ms a question in the server, {children:.1f} in its processes")
            before, load = processor_seconds(server.pid), os.getloadavg()[0]
            spent, refused, seconds = at_rate(port, texts[600:], options.rate)
            print(f"{options.rate:g} a second for {seconds:.1f} s: {said(spent)}; {refused} refused")
            used = processor_seconds(server.pid) - before
            here, children = 1000 * used / len(texts[600:])
            cores = float(used.sum()) / seconds
            print(f"  processor: {here:.1f} ms a question in the server, {children:.1f} in its processes")
            print(f"  {cores:.2f} cores of two")
            print(f"  load of the machine before and after: {load:.1f}, {os.getloadavg()[0]:.1f}")
        finally:
            server.terminate()
            server.wait()


if __name__ == "__main__":
    main()
