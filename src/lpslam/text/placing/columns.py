"""Sightings of texts in the world, column by column."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import transform_points
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.types import Rows, TextObservation

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WorldSightings:
    """n sightings where they stand; `sightings[rows]` are some of them, in that order.

    Attributes:
        observations: as they were made.
        positions: (n, 3) metres.
        normals, baselines: (n, 3) unit.
    """

    observations: tuple[TextObservation, ...]
    positions: Array
    normals: Array
    baselines: Array

    @classmethod
    def of(cls, observations: Sequence[TextObservation], world_from_keyframe: KeyframePoses) -> "WorldSightings":
        """Place observations by their keyframes' present poses.

        Raises:
            ValueError: the place of a keyframe, or of an observation in it, is not known.
        """
        keyframes = np.array([each.keyframe for each in observations], dtype=np.int64)
        local = np.array(
            [(each.place.position, each.place.normal, each.place.baseline) for each in observations], dtype=np.float64
        ).reshape(-1, 3, 3)
        world = np.empty_like(local)
        for keyframe in set(keyframes.tolist()):
            rows = keyframes == keyframe
            pose = world_from_keyframe(keyframe)
            if pose is None:
                raise ValueError(f"keyframe {keyframe} has no place in the map")
            world[rows, 0] = transform_points(pose, local[rows, 0])
            world[rows, 1:] = local[rows, 1:] @ pose[:3, :3].T
        return cls(tuple(observations), world[:, 0], world[:, 1], world[:, 2])

    def __len__(self) -> int:
        return len(self.observations)

    def __getitem__(self, rows: Rows) -> "WorldSightings":
        every = np.arange(len(self))
        chosen = every[rows]
        if np.array_equal(chosen, every):
            return self
        observations = tuple(self.observations[row] for row in chosen)
        return WorldSightings(observations, self.positions[chosen], self.normals[chosen], self.baselines[chosen])

    @cached_property
    def frames(self) -> NDArray[np.int64]:
        """(n,) in which frame each was seen."""
        return np.array([each.frame for each in self.observations], np.int64)

    @cached_property
    def sizes(self) -> Array:
        """(n, 2) metres of width and height."""
        sizes = [(each.place.width, each.place.height) for each in self.observations]
        return np.array(sizes, np.float64).reshape(-1, 2)

    @cached_property
    def variants(self) -> dict[str, int]:
        """How often each text was read, the commonest first."""
        return dict(Counter(each.text for each in self.observations).most_common())
