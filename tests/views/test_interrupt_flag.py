"""Ctrl-C and a polite kill end a run in order; what a shell lets be ignored stays ignored."""

import os
import signal
from collections.abc import Iterator

import pytest

from lpslam.views.run_progress import InterruptFlag


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_first_sets_the_flag_and_the_next_acts_as_ever(number: signal.Signals) -> None:
    # Tests may run behind a shell themselves.
    handler = signal.default_int_handler if number == signal.SIGINT else signal.getsignal(number)
    signal.signal(number, handler)
    with InterruptFlag() as interrupted:
        assert not interrupted.is_set()
        os.kill(os.getpid(), number)
        assert interrupted.is_set()
        assert signal.getsignal(number) is handler


def test_what_runs_behind_a_shell_does_not_hear_its_key_but_a_polite_kill() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with InterruptFlag() as interrupted:
        os.kill(os.getpid(), signal.SIGINT)
        assert not interrupted.is_set()
        os.kill(os.getpid(), signal.SIGTERM)
        assert interrupted.is_set()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
