"""A scene of textured planar faces, by columns, as the renderer's kernels take it.

The world frame has z up; a face is a rectangle or parallelogram given by a corner and two edges. Seen from its front,
`edge_u` runs to the right and `edge_v` down, so that textures are upright images; the front is where the normal
(edge_v × edge_u, normalised) points to.
"""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Image = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """Everything that is drawn.

    Attributes:
        origin, edge_u, edge_v, normal: (n, 3) metres in the world frame.
        two_sided: (n,) whether the back is drawn too (then it shows the same texture mirrored).
        gloss: (n,) 0 matt to 1 mirror-like: depth sensors see such faces badly; those of `NO_RETURN` not at all.
        emission: (n,) brightness of the face's own light; 0 for faces that are lit.
        repeat: (n, 2) how many times the texture is laid along u and v.
        texture: (n,) row of `levels`.
        texels: (t,) uint32, red + 256 green + 65536 blue, of all textures and their smaller levels.
        levels: (textures, levels, 3) int64: first texel, width, height; the last levels repeat the smallest.
        light: (m,) float32 brightness factors, one little image per face.
        light_maps: (n, 3) int64: first entry in `light`, width, height.
    """

    origin: Vector
    edge_u: Vector
    edge_v: Vector
    normal: Vector
    two_sided: NDArray[np.bool_]
    gloss: NDArray[np.float32]
    emission: NDArray[np.float32]
    repeat: NDArray[np.float32]
    texture: NDArray[np.int64]
    texels: NDArray[np.uint32]
    levels: NDArray[np.int64]
    light: NDArray[np.float32]
    light_maps: NDArray[np.int64]

    def __len__(self) -> int:
        """Number of faces."""
        return len(self.origin)


MIP_LEVELS = 9
NO_RETURN = 4.0
"""Gloss of what sends nothing back to a depth sensor, dark glass and lamps: no noise makes up for so much."""


@dataclass(slots=True)
class SceneBuilder:
    """Collects faces and textures; `build` turns them into columns."""

    _origins: list[Vector] = field(default_factory=list)
    _edges_u: list[Vector] = field(default_factory=list)
    _edges_v: list[Vector] = field(default_factory=list)
    _two_sided: list[bool] = field(default_factory=list)
    _gloss: list[float] = field(default_factory=list)
    _emission: list[float] = field(default_factory=list)
    _repeat: list[tuple[float, float]] = field(default_factory=list)
    _texture: list[int] = field(default_factory=list)
    _images: list[Image] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of faces so far."""
        return len(self._origins)

    def add_texture(self, image: Image) -> int:
        """Store a picture (height, width, 3) RGB; returns its number for `add_face`."""
        self._images.append(np.ascontiguousarray(image))
        return len(self._images) - 1

    def add_colour(self, colour: tuple[int, int, int]) -> int:
        """Store a plain colour as a texture."""
        return self.add_texture(np.full((4, 4, 3), colour, np.uint8))

    def add_face(
        self,
        origin: Vector,
        edge_u: Vector,
        edge_v: Vector,
        texture: int,
        *,
        repeat: tuple[float, float] = (1.0, 1.0),
        two_sided: bool = False,
        gloss: float = 0.0,
        emission: float = 0.0,
    ) -> int:
        """Add one face; returns its number."""
        self._origins.append(np.asarray(origin, dtype=np.float64))
        self._edges_u.append(np.asarray(edge_u, dtype=np.float64))
        self._edges_v.append(np.asarray(edge_v, dtype=np.float64))
        self._texture.append(texture)
        self._repeat.append(repeat)
        self._two_sided.append(two_sided)
        self._gloss.append(gloss)
        self._emission.append(emission)
        return len(self._origins) - 1

    def add_box(
        self,
        corner: Vector,
        along: Vector,
        depth: Vector,
        height: float,
        texture: int,
        *,
        top: int | None = None,
        gloss: float = 0.0,
        emission: float = 0.0,
        bottom: bool = False,
    ) -> None:
        """Add an upright box: `corner` is at the bottom, `along` × `depth` points up; by default without a bottom."""
        up = np.array([0.0, 0.0, height])
        sides = ((corner, along), (corner + along, depth), (corner + along + depth, -along), (corner + depth, -depth))
        for foot, run in sides:
            self.add_face(foot + up, run, -up, texture, gloss=gloss, emission=emission)
        self.add_face(
            corner + up + depth, along, -depth, texture if top is None else top, gloss=gloss, emission=emission
        )
        if bottom:
            self.add_face(corner, along, depth, texture, gloss=gloss, emission=emission)

    def build(self, light_texels_per_metre: float = 4.0) -> Scene:
        """Lay everything out in columns, with mip levels and unlit (all ones) light maps."""
        origin, edge_u, edge_v = (np.array(rows) for rows in (self._origins, self._edges_u, self._edges_v))
        normal = np.cross(edge_v, edge_u)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        sides = np.column_stack([np.linalg.norm(edge_u, axis=1), np.linalg.norm(edge_v, axis=1)])
        sizes = np.clip(np.ceil(sides * light_texels_per_metre).astype(np.int64) + 1, 2, 256)
        counts = sizes.prod(axis=1)
        starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        texels, levels = _mip_pyramids(self._images)
        return Scene(
            origin=origin,
            edge_u=edge_u,
            edge_v=edge_v,
            normal=normal,
            two_sided=np.array(self._two_sided),
            gloss=np.array(self._gloss, dtype=np.float32),
            emission=np.array(self._emission, dtype=np.float32),
            repeat=np.array(self._repeat, dtype=np.float32),
            texture=np.array(self._texture, dtype=np.int64),
            texels=texels,
            levels=levels,
            light=np.ones(int(counts.sum()), dtype=np.float32),
            light_maps=np.column_stack([starts, sizes]),
        )


def _mip_pyramids(images: list[Image]) -> tuple[NDArray[np.uint32], NDArray[np.int64]]:
    """Halve every picture down to a few texels and put all of them into one buffer."""
    chunks: list[NDArray[np.uint32]] = []
    levels = np.zeros((len(images), MIP_LEVELS, 3), dtype=np.int64)
    start = 0
    for row, image in enumerate(images):
        for level in range(MIP_LEVELS):
            height, width = image.shape[:2]
            levels[row, level] = start, width, height
            chunks.append(_packed(image))
            start += height * width
            if min(height, width) < 4:
                levels[row, level + 1 :] = levels[row, level]
                break
            image = np.asarray(cv2.resize(image, (width // 2, height // 2), interpolation=cv2.INTER_AREA), np.uint8)
    return np.concatenate(chunks), levels


def _packed(image: Image) -> NDArray[np.uint32]:
    red, green, blue = (image[..., channel].astype(np.uint32) for channel in range(3))
    return np.asarray(red + 256 * green + 65536 * blue, np.uint32).ravel()
