"""Glass and mirrors: where they cover the view, the place is drawn once more, mirrored at their plane."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.render import project_faces, scan_faces
from lpslam.simulation.scene import Scene
from lpslam.simulation.worlds.places.place import Pane
from lpslam.simulation.worlds.raster import View, view_of

MIRROR, GLASS = 1, 2
THROUGH = 0.9  # share of light that goes through a sheet of glass
SILVER = np.array([0.88, 0.91, 0.89])  # shares of light that a mirror gives back
REFLECTED = 0.07  # share that glass gives back when looked at squarely; more where it is grazed (Schlick)

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Glazing:
    """A pane, and the place mirrored at it.

    Attributes:
        pane: where it is.
        mirrored: the faces before it, on the other side of it.
        rows: (faces,) of the scene, one for each mirrored face.
    """

    pane: Pane
    mirrored: Scene
    rows: NDArray[np.int64]


def glazings_of(scene: Scene, panes: tuple[Pane, ...]) -> tuple[Glazing, ...]:
    """Mirror a scene at every pane; at both sides of glass."""
    return tuple(_mirrored(scene, side) for pane in panes for side in _sides(pane))


def _sides(pane: Pane) -> Iterator[Pane]:
    yield pane
    if not pane.is_mirror:
        yield replace(pane, corner=pane.corner + pane.edge_u, edge_u=-pane.edge_u)


def _normal(pane: Pane) -> Array:
    normal = np.cross(pane.edge_v, pane.edge_u)
    return np.asarray(normal / np.linalg.norm(normal))


def _mirrored(scene: Scene, pane: Pane) -> Glazing:
    normal = _normal(pane)
    sides = (0.0, scene.edge_u, scene.edge_v, scene.edge_u + scene.edge_v)
    corners = np.stack([scene.origin + side for side in sides])
    rows = np.flatnonzero((((corners - pane.corner) @ normal) > 0.02).any(axis=0))
    origin = scene.origin[rows] - 2 * ((scene.origin[rows] - pane.corner) @ normal)[:, None] * normal
    edge_u, edge_v, normals = (
        each[rows] - 2 * (each[rows] @ normal)[:, None] * normal for each in (scene.edge_u, scene.edge_v, scene.normal)
    )
    mirrored = replace(
        scene, origin=origin, edge_u=edge_u, edge_v=edge_v, normal=normals, two_sided=scene.two_sided[rows],
        gloss=scene.gloss[rows], emission=scene.emission[rows], repeat=scene.repeat[rows], texture=scene.texture[rows],
        light_maps=scene.light_maps[rows],
    )  # fmt: skip
    return Glazing(pane, mirrored, rows)


def glaze(
    view: View, camera: PinholeCamera, world_from_camera: Array, glazings: tuple[Glazing, ...]
) -> NDArray[np.uint8]:
    """Put what glass and mirrors show into a view, in place.

    Returns:
        (height, width) 0, `MIRROR` where the depth is that of the mirrored place, `GLASS` where something is seen
        through a sheet.
    """
    marks = np.zeros(view.depth.shape, np.uint8)
    for glazing in glazings:
        covered = _cover(glazing.pane, view, camera, world_from_camera)
        if covered is None:
            continue
        mask, rows, columns = covered
        normal = _normal(glazing.pane)
        if not glazing.pane.is_mirror and not len(view.colour):
            marks[rows, columns][mask] = GLASS
            continue
        crop = replace(
            camera, width=mask.shape[1], height=mask.shape[0], cx=camera.cx - columns.start, cy=camera.cy - rows.start
        )
        seen = view_of(glazing.mirrored, crop, world_from_camera, with_colour=bool(len(view.colour)))
        if len(view.colour):
            part = view.colour[rows, columns]
            if glazing.pane.is_mirror:
                part[mask] = seen.colour[mask] * SILVER.astype(np.float32)
            else:
                share = _reflected(crop, world_from_camera[:3, :3].T @ normal)[mask][:, None]
                part[mask] = THROUGH * (1 - share) * part[mask] + share * seen.colour[mask]
        if glazing.pane.is_mirror:
            view.depth[rows, columns][mask] = seen.depth[mask]
            faces = np.where(seen.face >= 0, glazing.rows[np.maximum(seen.face, 0)], -1).astype(np.int32)
            view.face[rows, columns][mask] = faces[mask]
        marks[rows, columns][mask] = MIRROR if glazing.pane.is_mirror else GLASS
    return marks


def _cover(
    pane: Pane, view: View, camera: PinholeCamera, world_from_camera: Array
) -> tuple[NDArray[np.bool_], slice, slice] | None:
    """Which pixels a pane covers, within their bounding box; None where it is not seen from its front."""
    _, affine, polygons, counts = project_faces(
        pane.corner[None], pane.edge_u[None], pane.edge_v[None], _normal(pane)[None], np.array([False]),
        world_from_camera, camera.fx, camera.fy, camera.cx, camera.cy, camera.width, camera.height,
    )  # fmt: skip
    if not len(counts):
        return None
    corners = polygons[0, : counts[0]]
    low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, [camera.width, camera.height])
    if (high - low).min() < 2:
        return None
    rows, columns = slice(int(low[1]), int(high[1])), slice(int(low[0]), int(high[0]))
    inverse, winner = (np.empty((high[1] - low[1], high[0] - low[0]), kind) for kind in (np.float32, np.int32))
    affine[0, :, 2] += affine[0, :, 0] * low[0] + affine[0, :, 1] * low[1]
    scan_faces(affine, polygons - low, counts, 1, inverse, winner)
    depth = view.depth[rows, columns]
    mask = (winner == 0) & ((depth == 0) | (inverse * depth > 1.002))
    return (mask, rows, columns) if mask.any() else None


def _reflected(camera: PinholeCamera, normal: Array) -> NDArray[np.float32]:
    """(height, width) share of light that a sheet with a normal in the camera's frame gives back (Schlick's law)."""
    x = ((np.arange(camera.width) - camera.cx) / camera.fx)[None, :]
    y = ((np.arange(camera.height) - camera.cy) / camera.fy)[:, None]
    cosine = np.abs(normal[0] * x + normal[1] * y + normal[2]) / np.sqrt(x * x + y * y + 1)
    return np.asarray(np.minimum(REFLECTED + (1 - REFLECTED) * (1 - cosine) ** 5, 0.7), np.float32)
