"""The garbage collector waits while tables are built, and goes on after."""

import gc

import pytest

from lpslam.language.kept import building


def test_it_waits_and_goes_on() -> None:
    assert gc.isenabled()
    with building():
        assert not gc.isenabled()
        with building():
            pass
        assert not gc.isenabled()
    assert gc.isenabled()


def test_it_goes_on_after_an_error() -> None:
    with pytest.raises(KeyError), building():
        raise KeyError
    assert gc.isenabled()
