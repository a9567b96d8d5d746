"""Writing a point cloud for other programs to open."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lpslam.errors import UserError


def write_ply(path: Path, points: NDArray[np.float64], colours: NDArray[np.uint8] | None = None) -> None:
    """Write a binary PLY; points that are not finite are left out.

    Args:
        path: the file.
        points: (n, 3) metres.
        colours: (n, 3) red, green, blue; light grey without.

    Raises:
        UserError: the file cannot be written.
    """
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    finite = np.isfinite(points).all(axis=1)
    if colours is None:
        colours = np.full(points.shape, 200, dtype=np.uint8)
    fields = [*((name, "<f4") for name in "xyz"), *((name, "u1") for name in ("red", "green", "blue"))]
    vertices = np.empty(int(finite.sum()), dtype=fields)
    for axis, name in enumerate("xyz"):
        vertices[name] = points[finite, axis]
    for channel, name in enumerate(("red", "green", "blue")):
        vertices[name] = np.asarray(colours).reshape(-1, 3)[finite, channel]
    properties = [f"property float {name}" for name in "xyz"] + [
        f"property uchar {name}" for name in ("red", "green", "blue")
    ]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *properties, "end_header"]
    try:
        path.write_bytes("\n".join(header).encode("ascii") + b"\n" + vertices.tobytes())
    except OSError as error:
        raise UserError(f"point cloud {path} cannot be written ({error.strerror}); choose another place") from error
