from pathlib import Path

import numpy as np
import pytest

from lpslam.errors import UserError
from lpslam.mapfile.point_cloud import write_ply


def test_a_ply_holds_the_finite_points_with_their_colours(tmp_path: Path) -> None:
    points = np.array([[1, 2, 3], [np.nan, 0, 0], [-4, 5.5, 6]])
    colours = np.array([[255, 0, 1], [9, 9, 9], [0, 128, 2]], np.uint8)
    write_ply(tmp_path / "cloud.ply", points, colours)
    header, _, body = (tmp_path / "cloud.ply").read_bytes().partition(b"end_header\n")
    assert b"element vertex 2\n" in header
    assert header.startswith(b"ply\nformat binary_little_endian 1.0\n")
    vertices = np.frombuffer(body, dtype=[("at", "<f4", 3), ("colour", "u1", 3)])
    np.testing.assert_array_equal(vertices["at"], points[[0, 2]].astype(np.float32))
    np.testing.assert_array_equal(vertices["colour"], colours[[0, 2]])


def test_an_empty_cloud_and_an_unwritable_place(tmp_path: Path) -> None:
    write_ply(tmp_path / "cloud.ply", np.zeros((0, 3)))
    assert (tmp_path / "cloud.ply").read_bytes().endswith(b"end_header\n")
    with pytest.raises(UserError, match="cannot be written"):
        write_ply(tmp_path / "none" / "cloud.ply", np.zeros((0, 3)))
