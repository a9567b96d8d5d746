"""What is no recording is refused with its true reason and the remedy."""

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np
import pytest
from tests.sources.test_depth_encodings import LENS, colour, packed, write

from lpslam.errors import UserError
from lpslam.sources.open import open_source


def clouds(folder: Path) -> Path:
    (folder / "color").mkdir()
    (folder / "clouds").mkdir()
    for index in range(3):
        cv2.imwrite(str(folder / "color" / f"{index:04d}.png"), colour(index))
        (folder / "clouds" / f"{index:04d}.ply").write_text("ply")
    (folder / "camera.json").write_text(json.dumps(LENS))
    return folder


def two_cameras(folder: Path) -> Path:
    for name in ("front", "back"):
        (folder / name).mkdir()
        inner = write(folder / name, lambda index: np.full((120, 160), 1000 + index, np.uint16))
        shutil.move(inner / "rgb", inner / "color")
    return folder


def in_false_colours(folder: Path) -> Path:
    return write(folder, packed)


def protobuf(folder: Path) -> Path:
    (folder / "0001.pb").write_bytes(b"\x0a\x01")
    return folder


def zarr(folder: Path) -> Path:
    (folder / ".zgroup").write_text("{}")
    return folder


def objects(folder: Path) -> Path:
    np.savez(folder / "a.npz", frames=np.array([{"t": 1}], dtype=object), allow_pickle=True)
    return folder / "a.npz"


def own_database(folder: Path) -> Path:
    with closing(sqlite3.connect(folder / "a.sqlite")) as connection:
        connection.execute("CREATE TABLE frames(colour BLOB)")
        connection.commit()
    return folder / "a.sqlite"


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (clouds, r"point clouds \(0000\.ply\), which have no pixels"),
        (two_cameras, r"it holds 2 recordings \(back, front\); give one of them"),
        (in_false_colours, "eight bits a channel"),
        (protobuf, "protobuf"),
        (zarr, "zarr"),
        (objects, "objects of Python"),
        (own_database, r"no ROS 2 recorder wrote \(tables: frames\)"),
    ],
)
def test_the_reason_is_said(tmp_path: Path, make: Callable[[Path], Path], said: str) -> None:
    path = make(tmp_path)
    with pytest.raises(UserError, match=said) as caught:
        open_source(path)
    assert "\n" not in str(caught.value)


def test_a_folder_that_holds_nothing_says_what_is_looked_for(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"looked for rgb\.txt"):
        open_source(tmp_path)
