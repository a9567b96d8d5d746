"""Recordings that are sent are mapped in processes of their own, which may fail without the server."""

import asyncio
import os
import signal
import subprocess
import time
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from served_here import SERVICES, Serve
from starlette.testclient import TestClient
from test_archives import zipped

from lpslam.isolated import python_command
from lpslam.serving import records
from lpslam.serving.hub import Event, Hub, TooManyListenersError


def wait(
    client: TestClient, id_: str, until: Callable[[dict[str, Any]], bool], seconds: float = 400.0
) -> dict[str, Any]:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        job: dict[str, Any] = client.get(f"/jobs/{id_}").json()
        if until(job):
            records.JobRecord.model_validate(job)
            return job
        time.sleep(0.05)
    raise AssertionError(job)


def is_over(job: dict[str, Any]) -> bool:
    return job["state"] in ("done", "failed", "cancelled")


def is_cleared(tmp_path: Path) -> bool:
    """Whether nothing is left of jobs, some time after they are over."""
    end = time.monotonic() + 60.0
    while os.listdir(tmp_path / "uploads" / "jobs"):
        if time.monotonic() > end:
            return False
        time.sleep(0.05)
    return True


def send(client: TestClient, data: bytes, name: str = "new", file: str = "walk.zip") -> Any:
    return client.post("/jobs", params={"name": name, "file": file}, content=data)


def archive_of(folder: Path, out: Path) -> bytes:
    with zipfile.ZipFile(out, "w") as archive:
        for path in sorted(folder.rglob("*")):
            archive.write(path, Path("walk") / path.relative_to(folder))
    return out.read_bytes()


@pytest.fixture
def mapping(serve: Serve, tmp_path: Path) -> TestClient:
    return serve(uploads=tmp_path / "uploads")


@pytest.mark.slow
def test_a_recording_that_is_sent_becomes_a_map_that_is_served(
    serve: Serve, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    folder = tmp_path / "uploads"
    client = serve(uploads=folder)
    sent = send(client, archive_of(clip(4), tmp_path / "clip.zip"))
    assert sent.status_code == 202, sent.text
    job = wait(client, sent.json()["id"], is_over, 600)
    assert (job["state"], job["message"], job["frames"], job["frames_total"]) == ("done", "", 4, 4)
    assert client.get("/maps/new").json()["frames"] == 4
    assert is_cleared(tmp_path)
    assert send(client, b"x", "new").status_code == 409
    again = serve(uploads=folder)
    assert {each["name"] for each in again.get("/maps").json()["maps"]} >= {"mall"}


def test_without_a_folder_nothing_is_taken(client: TestClient) -> None:
    assert send(client, b"x").status_code == 404


@pytest.mark.parametrize(
    "name", ["", "..", ".hidden", "-x", "a/b", "../../x", "a b", "名", "x" * 61, "a\x00b", "a\n", "<b>"]
)
def test_a_name_that_is_a_path_is_none(mapping: TestClient, name: str) -> None:
    assert send(mapping, b"x", name).status_code == 422


def test_what_cannot_be_taken_is_one_line(mapping: TestClient, mall: Path) -> None:
    assert send(mapping, b"x", "mall").status_code == 409
    for file in ("walk.exe", "walk", ".zip/../x", "walk.zip\x00.sh"):
        assert send(mapping, b"x", file=file).status_code == 422, file
    assert send(mapping, b"").status_code == 422
    form = {"content-type": "multipart/form-data; boundary=x"}
    assert mapping.post("/jobs?name=a", content=b"x", headers=form).status_code == 415
    assert mapping.get("/jobs/nothing").status_code == 404
    assert mapping.delete("/jobs/..").status_code in (404, 405)


def test_an_upload_that_is_too_large_leaves_nothing(serve: Serve, tmp_path: Path) -> None:
    client = serve(uploads=tmp_path / "uploads", jobs={"upload_bytes": 1000})

    def unsaid() -> Any:
        yield from (b"x" * 300 for _ in range(5))

    assert send(client, b"x" * 1001).status_code == 413
    assert client.post("/jobs?name=a", content=unsaid()).status_code == 413
    assert os.listdir(tmp_path / "uploads" / "jobs") == []
    assert client.get("/jobs").json() == {"jobs": []}


def test_a_hostile_archive_is_a_failed_job_and_the_next_one_runs(mapping: TestClient, tmp_path: Path) -> None:
    first = send(mapping, zipped(tmp_path / "a.zip", {"../../../escape": b"x"}).read_bytes(), "first")
    second = send(mapping, b"no archive at all", "second")
    bag = send(mapping, b"no bag at all", "third", "walk.mcap")
    jobs = [wait(mapping, sent.json()["id"], is_over) for sent in (first, second, bag)]
    assert [job["state"] for job in jobs] == ["failed"] * 3
    assert "no plain name" in jobs[0]["message"]
    assert "neither a zip nor a tar" in jobs[1]["message"]
    assert not any(str(tmp_path) in job["message"] for job in jobs), "no path of the server is told"
    assert not list(tmp_path.rglob("escape"))
    assert is_cleared(tmp_path)
    assert mapping.get("/maps").status_code == 200


def test_a_recording_cannot_show_files_of_the_server(
    mapping: TestClient, walk: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    folder = clip(3)
    listed = (folder / "rgb.txt").read_text().splitlines()
    stamp = [line.split()[0] for line in listed]
    outside = sorted((walk / "rgb").iterdir())[:3]
    (folder / "rgb.txt").write_text("\n".join(f"{time} {path}" for time, path in zip(stamp, outside, strict=True)))
    job = wait(mapping, send(mapping, archive_of(folder, tmp_path / "clip.zip")).json()["id"], is_over)
    assert job["state"] == "failed"
    assert str(walk) not in job["message"]


def test_a_job_that_is_killed_fails_and_the_server_goes_on(
    mapping: TestClient, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    sent = send(mapping, archive_of(clip(12), tmp_path / "clip.zip"))
    id_ = sent.json()["id"]
    wait(mapping, id_, lambda job: job["state"] != "waiting")
    jobs = SERVICES[id(mapping)].jobs
    assert jobs is not None
    assert jobs.process_id is not None
    os.kill(jobs.process_id, signal.SIGKILL)
    job = wait(mapping, id_, is_over)
    assert (job["state"], "SIGKILL" in job["message"]) == ("failed", True)
    assert mapping.post("/ask", json={"question": "pizza"}).status_code == 200
    assert is_cleared(tmp_path)


def test_a_job_is_cancelled(mapping: TestClient, clip: Callable[[int], Path], tmp_path: Path) -> None:
    data = archive_of(clip(12), tmp_path / "clip.zip")
    running, waiting = send(mapping, data, "one").json()["id"], send(mapping, data, "two").json()["id"]
    assert mapping.delete(f"/jobs/{waiting}").json()["state"] == "cancelled"
    wait(mapping, running, lambda job: job["state"] != "waiting")
    assert mapping.delete(f"/jobs/{running}").json()["state"] == "cancelled"
    assert wait(mapping, running, is_over)["state"] == "cancelled"
    assert {each["name"] for each in mapping.get("/maps").json()["maps"]} == {"mall"}


def test_more_jobs_than_may_wait_are_told_to_come_back(serve: Serve, tmp_path: Path) -> None:
    client = serve(uploads=tmp_path / "uploads", jobs={"waiting": 1})
    first = send(client, b"no archive", "one")
    answers = [send(client, b"no archive", f"more-{number}").status_code for number in range(3)]
    assert 503 in answers
    wait(client, first.json()["id"], is_over)


def test_a_job_has_bounds_of_memory_time_and_places(tmp_path: Path) -> None:
    code = f"""
from pathlib import Path
from lpslam.config import JobsConfig
from lpslam.serving.jobs.fences import limit_resources, read_only_inside
limit_resources(JobsConfig(memory_bytes=2 << 30))
read_only_inside(Path({str(tmp_path / "own")!r}))
print(open({str(tmp_path / "own" / "mine")!r}).read())
for place in ({str(tmp_path / "secret")!r}, {str(tmp_path / "own" / ".." / "secret")!r}, "/etc/passwd", "/root/.ssh/id",
              {str(tmp_path / "own" / "link")!r}):
    try:
        open(place)
        print("read", place)
    except PermissionError:
        print("refused")
try:
    bytearray(4 << 30)
except MemoryError:
    print("bounded")
"""
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "mine").write_text("mine")
    (tmp_path / "secret").write_text("secret")
    (tmp_path / "own" / "link").symlink_to(tmp_path / "secret")
    done = subprocess.run(python_command(code), capture_output=True, text=True, cwd=tmp_path)
    assert done.stdout.split() == ["mine", *["refused"] * 5, "bounded"], done.stderr


def test_a_slow_listener_loses_the_oldest_events_and_is_told() -> None:
    async def heard() -> tuple[list[Event | None], list[Event | None], bool]:
        hub = Hub(listeners=1, waiting=3)
        listening = hub.listen(heartbeat=0.05)
        first = asyncio.ensure_future(anext(listening))
        await asyncio.sleep(0)
        with pytest.raises(TooManyListenersError):
            await anext(hub.listen())
        for number in range(10):
            hub.tell("job", {"number": number})
        got = [await first] + [await anext(listening) for _ in range(4)]
        await listening.aclose()  # type: ignore[attr-defined]
        again = hub.listen(after=9)
        back = [await anext(again)]
        await again.aclose()  # type: ignore[attr-defined]
        return got, back, hub.listeners == 0

    got, back, is_left = asyncio.run(heard())
    assert [(event.kind, event.data) if event else None for event in got] == [
        ("missed", {"events": 7}), ("job", {"number": 7}), ("job", {"number": 8}), ("job", {"number": 9}), None
    ]  # fmt: skip
    assert back[0] is not None
    assert back[0].data == {"number": 9}
    assert is_left
