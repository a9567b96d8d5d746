"""The ground and its signs in robots' own formats: Nav2's map server, waypoints and routes, GeoJSON, a floor plan.

`map.pgm` and `map.yaml` are as ROS 2's map_server reads them (nav2_map_server, trinary mode): rows from the top, 254
free, 0 occupied, 205 unknown; `origin` is the lower left corner. A path has the shape of nav_msgs/Path.
"""

import json
from collections.abc import Sequence
from functools import partial
from html import escape
from math import cos, sin
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from numpy.typing import NDArray

from lpslam.ground.grid import FREE, OCCUPIED, Grid, trinary
from lpslam.language.sanitise import clean_text
from lpslam.mapfile.export import write_whole
from lpslam.navigation.walking.goals import goal_before
from lpslam.navigation.walking.routes import Leg
from lpslam.navigation.walking.storeys import Building
from lpslam.navigation.walking.ways import NoWayError, Walkable
from lpslam.text.types import Landmark

FRAME = "map"
_KEEPOUT = 0.6  # metres around a warning that a robot keeps out of


def export_ground(
    folder: Path,
    walkable: Walkable,
    landmarks: Sequence[Landmark],
    warnings: Sequence[Landmark] = (),
    legs: Sequence[Leg] = (),
) -> list[Path]:
    """Write map.pgm, map.yaml, keepout.pgm, keepout.yaml, waypoints.yaml, places.geojson, floor_plan.svg; route.yaml.

    Args:
        folder: where to; it is made.
        walkable: the ground.
        landmarks: whose places and goal poses are written.
        warnings: of these, before which robots keep out.
        legs: of a route; without, no route.yaml is written.

    Returns:
        The files.

    Raises:
        UserError: the folder cannot be written.
    """
    grid = walkable.grid
    poses = [(mark, pose) for mark in landmarks if (pose := _pose_before(mark, walkable)) is not None]
    texts = {
        "map.yaml": _map_yaml(grid, "map.pgm"),
        "keepout.yaml": _map_yaml(grid, "keepout.pgm"),
        "waypoints.yaml": _yaml({"waypoints": [_waypoint(mark, pose) for mark, pose in poses]}),
        "places.geojson": json.dumps(_geojson(landmarks), ensure_ascii=False, indent=1) + "\n",
        "floor_plan.svg": _svg(grid, landmarks, legs),
    }
    if legs:
        texts["route.yaml"] = _yaml(path_message(np.concatenate([leg.way.points for leg in legs])))
    pictures = {"map.pgm": grid.values, "keepout.pgm": _keepout(grid, warnings)}
    contents = {name: _pgm(trinary(values)) for name, values in pictures.items()}
    contents |= {name: text.encode("utf-8") for name, text in texts.items()}
    return write_whole(folder, {name: partial(_write, content) for name, content in contents.items()})


def export_storeys(
    folder: Path,
    building: Building,
    landmarks: Sequence[Landmark],
    warnings: Sequence[Landmark] = (),
    legs: Sequence[Leg] = (),
) -> list[Path]:
    """As `export_ground`; of several storeys, the ground and the signs of each in a folder `storey_0` and so on.

    Args:
        folder, landmarks, warnings: as in `export_ground`.
        building: the ground of all storeys.
        legs: of a route over one storey.

    Raises:
        UserError: the folder cannot be written.
    """
    if len(building.grounds) == 1:
        (ground,) = building.grounds.values()
        return export_ground(folder, ground, landmarks, warnings, legs)
    routed = {building.storey_of(leg.landmark) for leg in legs}
    written = []
    for storey, ground in building.grounds.items():
        own, warned = (
            [mark for mark in marks if building.storey_of(mark) == storey] for marks in (landmarks, warnings)
        )
        there = legs if storey in routed else ()
        written += export_ground(folder / f"storey_{storey}", ground, own, warned, there)
    return written


def _write(content: bytes, path: Path) -> None:
    path.write_bytes(content)


def path_message(points: NDArray[np.float64]) -> dict[str, Any]:
    """A way (n, 2) in the shape of nav_msgs/Path; each pose faces the next."""
    ahead = np.diff(points, axis=0, append=2 * points[-1:] - points[-2:-1] if len(points) > 1 else points[-1:])
    yaws = np.arctan2(ahead[:, 1], ahead[:, 0])
    header = {"frame_id": FRAME}
    poses = [
        {"header": header, "pose": _pose(float(x), float(y), float(yaw))}
        for (x, y), yaw in zip(points, yaws, strict=True)
    ]
    return {"header": header, "poses": poses}


def _pose_before(mark: Landmark, walkable: Walkable) -> tuple[float, float, float] | None:
    try:
        goal = goal_before(mark.position, mark.normal, walkable)
    except NoWayError:
        return None
    return (float(goal.position[0]), float(goal.position[1]), goal.yaw) if goal.is_before else None


def _pose(x: float, y: float, yaw: float) -> dict[str, dict[str, float]]:
    turn = {"x": 0.0, "y": 0.0, "z": round(sin(yaw / 2), 6), "w": round(cos(yaw / 2), 6)}
    return {"position": {"x": round(x, 4), "y": round(y, 4), "z": 0.0}, "orientation": turn}


def _waypoint(mark: Landmark, pose: tuple[float, float, float]) -> dict[str, Any]:
    x, y, yaw = pose
    return {"id": mark.id, "name": clean_text(mark.name), "x": round(x, 4), "y": round(y, 4), "yaw": round(yaw, 5)}


def _map_yaml(grid: Grid, image: str) -> str:
    return _yaml({
        "image": image,
        "mode": "trinary",
        "resolution": float(grid.resolution),
        "origin": [round(float(grid.origin[0]), 6), round(float(grid.origin[1]), 6), 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    })  # fmt: skip


def _yaml(tree: Any) -> str:
    return str(yaml.safe_dump(tree, allow_unicode=True, sort_keys=False))


def _pgm(picture: NDArray[np.uint8]) -> bytes:
    return b"P5\n%d %d\n255\n" % (picture.shape[1], picture.shape[0]) + np.ascontiguousarray(picture).tobytes()


def _keepout(grid: Grid, warnings: Sequence[Landmark]) -> NDArray[np.int8]:
    """Free everywhere but before warnings."""
    mask = np.zeros(grid.shape, np.uint8)
    for mark in warnings:
        if np.isfinite(mark.position).all():
            row, column = grid.cell(mark.position)
            cv2.circle(mask, (column, row), max(round(_KEEPOUT / grid.resolution), 1), 1, -1)
    return np.where(mask > 0, np.int8(OCCUPIED), np.int8(FREE))


def _geojson(landmarks: Sequence[Landmark]) -> dict[str, Any]:
    """Places in metres of the map frame: there is no latitude indoors, which `crs` says."""
    features = [
        {
            "type": "Feature",
            "id": mark.id,
            "geometry": {"type": "Point", "coordinates": [round(float(value), 4) for value in mark.position]},
            "properties": {
                "name": clean_text(mark.name),
                "lines": [clean_text(line.text) for line in mark.lines],
                "facing_degrees": round(float(np.degrees(np.arctan2(mark.normal[1], mark.normal[0]))), 1),
                "is_landmark": mark.is_landmark,
                "confidence": round(mark.confidence, 3),
            },
        }
        for mark in landmarks
    ]
    crs = {"type": "name", "properties": {"name": "lpslam map frame, metres"}}
    return {"type": "FeatureCollection", "crs": crs, "features": features}


_LETTERING = 'font-size="0.28" font-family="sans-serif" paint-order="stroke" stroke="#ffffff" stroke-width="0.09"'


def _svg(grid: Grid, landmarks: Sequence[Landmark], legs: Sequence[Leg]) -> str:
    """A floor plan, metres; things in the way as one path, signs as words."""
    (left, bottom), (rows, columns), cell = grid.origin, grid.shape, grid.resolution
    top, width, height = bottom + rows * cell, columns * cell, rows * cell
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.2f} {height:.2f}">',
        f'<rect width="{width:.2f}" height="{height:.2f}" fill="#e5e7eb"/>',
        f'<path fill="#ffffff" d="{_outlines(grid.values == FREE, cell)}"/>',
        f'<path fill="#1f2937" d="{_outlines(grid.values == OCCUPIED, cell)}"/>',
        f'<path d="M0.3 {height - 0.2:.2f}h1" stroke="#1f2937" stroke-width="0.06"/>',
        f'<text x="0.3" y="{height - 0.3:.2f}" {_LETTERING}>1 m</text>',
    ]
    for leg in legs:
        points = " ".join(f"{x - left:.2f},{top - y:.2f}" for x, y in leg.way.points)
        parts.append(f'<polyline points="{points}" fill="none" stroke="#15803d" stroke-width="0.08"/>')
    for mark in landmarks:
        x, y = float(mark.position[0]) - left, top - float(mark.position[1])
        colour = "#1d4ed8" if mark.is_landmark else "#be185d"
        parts.append(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="0.08" fill="{colour}"/>')
        name = escape(clean_text(mark.name))
        # A name that would leave the plan at its right stands at the left of its sign.
        side = 'text-anchor="end" ' if x > 0.8 * width else ""
        beside = x - 0.14 if side else x + 0.14
        parts.append(f'<text x="{beside:.2f}" y="{y + 0.09:.2f}" {side}fill="{colour}" {_LETTERING}>{name}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def _outlines(mask: NDArray[np.bool_], cell: float) -> str:
    """Runs of cells, row by row, as rectangles of an SVG path, y down from the top."""
    rows, steps = mask.shape[0], []
    for row in range(rows):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], mask[row], [False]]).astype(np.int8)))
        y = (rows - 1 - row) * cell
        for start, end in zip(edges[::2], edges[1::2], strict=True):
            steps.append(
                f"M{start * cell:.2f} {y:.2f}h{(end - start) * cell:.2f}v{cell:.2f}h{(start - end) * cell:.2f}z"
            )
    return "".join(steps)
