"""Pictures of a whole map."""

from pathlib import Path

import numpy as np

from lpslam.ground.scans import room_from_above
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.remembering.histories import score_histories
from lpslam.views.map_picture import draw_map
from lpslam.views.memory_plot import draw_memory


def draw_language_map(world: LanguageMap, out: Path) -> list[Path]:
    """The map from above with its texts (Fig. 16), on the ground where it was seen, in the colours of the room.

    Of storeys that lie above one another, `out` shows that on which the map ends, and files beside it, as
    `map-storey_0.png`, the others.

    Returns:
        The files.
    """
    positions, landmarks = world.frame_poses().positions, world.landmarks()
    points, colours = world.coloured_cloud()
    if not len(points):
        draw_map(out, world.cloud(), positions, landmarks, title=world.source)
        return [out]
    grids = world.grids()
    if len(grids) <= 1:
        cloud, shades = room_from_above(points, colours, positions)
        ground = grids[0] if grids else None
        draw_map(out, cloud, positions, landmarks, title=world.source, cloud_colours=shades, ground=ground)
        return [out]
    ended = grids[0].storeys_at(positions[np.isfinite(positions).all(axis=1), 2][-1:])
    last = next((grid for grid in grids if grid.storey in ended), grids[-1])
    drawn = [(out if grid is last else out.with_stem(f"{out.stem}-storey_{grid.storey}"), grid) for grid in grids]
    for path, grid in drawn:
        own = [grid.storeys_at(places[:, 2]) == grid.storey for places in (points, positions)]
        cloud, shades = room_from_above(points[own[0]], colours[own[0]], positions[own[1]])
        walked = np.where(own[1][:, None], positions, np.nan)
        marks = [mark for mark in landmarks if grid.storeys_to(float(mark.position[2])) == 0]
        title = f"{world.source}, storey {grid.storey}"
        draw_map(path, cloud, walked, marks, title=title, cloud_colours=shades, ground=grid)
    return [path for path, _ in drawn]


def draw_score_histories(world: LanguageMap, out: Path) -> None:
    """How the memory scores of all classes rose and faded (Fig. 13)."""
    draw_memory(out, score_histories(world.text.memory), world.text.memory.config.promotion, title=world.source)
