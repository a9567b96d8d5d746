"""Pictures of a whole map."""

from pathlib import Path

from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.remembering.histories import score_histories
from lpslam.views.map_picture import draw_map
from lpslam.views.memory_plot import draw_memory


def draw_language_map(world: LanguageMap, out: Path) -> None:
    """The map from above with its texts (Fig. 16), on the ground where it was seen, in the colours of the room."""
    positions = world.frame_poses().positions
    cloud, colours = world.room_from_above()
    if not len(cloud):
        draw_map(out, world.cloud(), positions, world.landmarks(), title=world.source)
        return
    draw_map(
        out, cloud, positions, world.landmarks(), title=world.source, cloud_colours=colours, ground=world.grid()
    )  # fmt: skip


def draw_score_histories(world: LanguageMap, out: Path) -> None:
    """How the memory scores of all classes rose and faded (Fig. 13)."""
    draw_memory(out, score_histories(world.text.memory), world.text.memory.config.promotion, title=world.source)
