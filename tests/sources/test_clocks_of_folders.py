"""TUM folders and bags whose clocks count in other units, or are apart."""

import logging
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from bag_writers import DEPTH, KINDS, Entry, Types, walk, write
from recordings import write_tum

from lpslam.errors import UserError
from lpslam.sources.open import open_source

FRAMES = 30


def restamp(listing: Path, change: Callable[[int, float], float]) -> None:
    rows = [line.split(None, 1) for line in listing.read_text().splitlines() if not line.startswith("#")]
    listing.write_text("\n".join(f"{change(n, float(time)):.6f} {name}" for n, (time, name) in enumerate(rows)))


@pytest.mark.parametrize("lists", [("rgb.txt", "depth.txt"), ("rgb.txt",), ("depth.txt",)])
@pytest.mark.parametrize(("factor", "unit"), [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")])
def test_a_folder_of_other_units_is_the_same_recording(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, lists: tuple[str, ...], factor: float, unit: str
) -> None:
    folder = tmp_path / "walk"
    write_tum(folder, FRAMES)
    wanted = list(open_source(folder))
    for name in lists:
        restamp(folder / name, lambda _, time: time * factor)
    with caplog.at_level(logging.WARNING):
        frames = list(open_source(folder))
    said = [record.getMessage() for record in caplog.records if unit in record.getMessage()]
    assert len(said) == 1, said
    assert len(frames) == len(wanted) == FRAMES
    np.testing.assert_allclose([f.timestamp for f in frames], [f.timestamp for f in wanted], atol=1e-5)
    np.testing.assert_array_equal(frames[-1].depth, wanted[-1].depth)


def test_a_folder_of_durations(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    write_tum(folder, FRAMES)
    for name in ("rgb.txt", "depth.txt"):
        restamp(folder / name, lambda number, _: 0.033 + 0.0005 * (number % 2))
    frames = list(open_source(folder))
    assert len(frames) == FRAMES
    np.testing.assert_allclose(np.diff([f.timestamp for f in frames]), 0.033, atol=6e-4)


def test_a_folder_whose_clocks_are_apart(tmp_path: Path) -> None:
    folder = tmp_path / "walk"
    write_tum(folder, FRAMES)
    restamp(folder / "depth.txt", lambda _, time: time + 500)
    with pytest.raises(UserError, match=r"begin 500\.\d+ s apart") as caught:
        open_source(folder)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", KINDS)
def test_a_bag_whose_clocks_are_apart(tmp_path: Path, kind: str) -> None:
    """Colour and depth that no pair can be made of are one clear line, not a map of nothing."""

    def apart(types: Types) -> list[Entry]:
        entries: list[Entry] = []
        for name, logged, message in walk(types):
            if name == DEPTH:
                message.header.stamp.sec += 500
            entries.append((name, logged, message))
        return entries

    bag = write(tmp_path / f"walk.{kind}", apart)
    with pytest.raises(UserError, match=r"colour and depth begin \d{3}\.\d+ s apart") as caught:
        list(open_source(bag))
    assert "\n" not in str(caught.value)
