"""What a depth sensor looks at: for each of its pixels the true depth, the slant, how bright, how textured."""

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.simulation.worlds.raster import View

Picture = NDArray[np.float32]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surfaces:
    """A depth sensor's scene, each (height, width) float32 of the sensor's own image.

    Attributes:
        camera: the sensor's geometry.
        depth: metres, 0 where nothing is hit.
        slant: cosine between the surface's normal and the line of sight.
        brightness: 0 to 255, of the surface in even light.
        texture: grey values by which the brightness changes over a few pixels.
        gloss: 0 matt to 1 like a mirror.
        glazing: 0 for nothing, 1 where a mirror is seen in, 2 where glass stands before it.
    """

    camera: PinholeCamera
    depth: Picture
    slant: Picture
    brightness: Picture
    texture: Picture
    gloss: Picture
    glazing: NDArray[np.uint8]


def surfaces_of(
    camera: PinholeCamera,
    view: View,
    glazing: NDArray[np.uint8],
    normals: Matrix,
    gloss: Picture,
    colour: Picture,
    canvas: PinholeCamera,
    canvas_from_depth: Matrix,
) -> Surfaces:
    """Look up what the sensor's pixels show in a picture from nearly the same place.

    Args:
        camera, view, glazing: of the depth sensor.
        normals: (faces, 3) in its frame.
        gloss: (faces,).
        colour: (h, w, 3) of the colour camera's canvas.
        canvas: its geometry.
        canvas_from_depth: 4×4.
    """
    own = (camera.fx, camera.fy, camera.cx, camera.cy)
    other = (canvas.fx, canvas.fy, canvas.cx, canvas.cy)
    fields = _look_up(view.depth, view.face, normals, gloss, colour, own, other, canvas_from_depth)
    return Surfaces(camera, view.depth, *fields, glazing)


@njit(cache=True, nogil=True, fastmath=True)
def _look_up(
    depth: Picture,
    face: NDArray[np.int32],
    normals: Matrix,
    gloss: Picture,
    colour: Picture,
    own: tuple[float, float, float, float],
    other: tuple[float, float, float, float],
    move: Matrix,
) -> tuple[Picture, Picture, Picture, Picture]:
    height, width = depth.shape
    rows, columns = colour.shape[:2]
    slant = np.zeros((height, width), np.float32)
    brightness = np.zeros((height, width), np.float32)
    texture = np.zeros((height, width), np.float32)
    shine = np.zeros((height, width), np.float32)
    for row in range(height):
        y = (row - own[3]) / own[1]
        for column in range(width):
            z, i = depth[row, column], face[row, column]
            if i < 0:
                continue
            x = (column - own[2]) / own[0]
            facing = normals[i, 0] * x + normals[i, 1] * y + normals[i, 2]
            slant[row, column] = abs(facing) / np.sqrt(x * x + y * y + 1.0)
            shine[row, column] = gloss[i]
            deep = move[2, 0] * x * z + move[2, 1] * y * z + move[2, 2] * z + move[2, 3]
            across = move[0, 0] * x * z + move[0, 1] * y * z + move[0, 2] * z + move[0, 3]
            down = move[1, 0] * x * z + move[1, 1] * y * z + move[1, 2] * z + move[1, 3]
            u = min(max(int(other[0] * across / deep + other[2] + 0.5), 2), columns - 3)
            v = min(max(int(other[1] * down / deep + other[3] + 0.5), 2), rows - 3)
            brightness[row, column] = (colour[v, u, 0] + 2.0 * colour[v, u, 1] + colour[v, u, 2]) / 4.0
            texture[row, column] = abs(colour[v, u + 2, 1] - colour[v, u - 2, 1]) + abs(
                colour[v + 2, u, 1] - colour[v - 2, u, 1]
            )
    return slant, brightness, texture, shine
