"""Pictures of a whole map."""

from pathlib import Path

from lpslam.mapfile.language_map import LanguageMap
from lpslam.views.map_picture import draw_map
from lpslam.views.memory_plot import ScoreHistory, draw_memory


def draw_language_map(world: LanguageMap, out: Path) -> None:
    """The map from above with its texts (Fig. 16)."""
    draw_map(out, world.cloud(), world.frame_poses().positions, world.landmarks(), title=world.source)


def draw_score_histories(world: LanguageMap, out: Path) -> None:
    """How the memory scores of all classes rose and faded (Fig. 13)."""
    memory = world.text.memory
    histories = [ScoreHistory(each.name, each.history, True) for each in memory.long_term.values()]
    histories += [ScoreHistory(each.name, each.history, False) for each in memory.short_term.values()]
    histories += [ScoreHistory(each.name, each.history, False) for each in memory.forgotten]
    draw_memory(out, histories, memory.config.promotion, title=world.source)
