"""With a real small model served by llama.cpp, where there is one: it proves the protocol, not the model's wits.

Needs `llama-server` on the path, and in LPSLAM_TEST_GGUF the file of an instruction-following model.
"""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from urllib.error import URLError
from urllib.request import urlopen

import pytest

from lpslam.config import LanguageConfig
from lpslam.language.hosted.usage import usage_of
from lpslam.language.model import Candidate, Reading
from lpslam.language.registry import language_model

SERVER, MODEL = shutil.which("llama-server"), os.environ.get("LPSLAM_TEST_GGUF")

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not SERVER, reason="llama.cpp's llama-server is not installed"),
    pytest.mark.skipif(not MODEL, reason="LPSLAM_TEST_GGUF names no model file"),
]


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [str(SERVER), "--model", str(MODEL), "--port", str(port), "--ctx-size", "4096", "--jinja"]
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        try:
            _wait_for(f"http://127.0.0.1:{port}/health")
            yield f"http://127.0.0.1:{port}/v1"
        finally:
            server.terminate()


def _wait_for(health: str) -> None:
    for _ in range(240):
        try:
            with urlopen(health, timeout=1.0) as answer:
                if answer.status == 200:
                    return
        except (URLError, OSError):
            time.sleep(0.5)
    pytest.fail("llama-server did not come up within two minutes")


def test_its_answers_are_taken(url: str) -> None:
    model = language_model(f"{url}#any", LanguageConfig(cache=False))
    marks = [Candidate(3, "KFC"), Candidate(8, "Pizza Hut"), Candidate(11, "Public Toilet")]
    choice = model.choose("Where can I eat pizza?", marks)
    assert choice.landmark in {None, 3, 8, 11}
    assert choice.model == f"{url}#any", choice.evidence
    judged = model.judge(["adidas", "No smoking"], "Is this a shop?")
    assert {each.model for each in judged} == {f"{url}#any"}
    named = model.name([Reading("STARBUCKS", 3, 0.9), Reading("STARBVCKS", 1, 0.6)])
    assert named.name.casefold().startswith("star")
    usage = usage_of(model)
    assert usage is not None
    assert usage.calls <= 10
    assert usage.tokens > 0
