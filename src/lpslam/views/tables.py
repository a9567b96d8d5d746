"""Tables for the terminal; names from the world are shown as they are, never taken for markup."""

from collections.abc import Mapping, Sequence

from rich.table import Table
from rich.text import Text

from lpslam.text.types import Landmark
from lpslam.views.drawable import printable

_VERDICTS = {True: ("landmark", "blue"), False: ("text", "magenta"), None: ("–", "dim")}


def landmark_table(landmarks: Sequence[Landmark], title: str = "Landmarks") -> Table:
    """One row a landmark: those judged to be one first, then by how often they were seen.

    Under a name stands, dimmed, what else is on its board. The other columns: place and spread in metres, observations,
    confidence of the reading, judgement (– while there is none).
    """
    table = Table(title=Text(title), title_justify="left")
    table.add_column("id", justify="right", no_wrap=True)
    table.add_column("name", min_width=10, overflow="fold")
    table.add_column(Text("x y z [m]"), justify="right", no_wrap=True)
    for heading in ("± m", "seen", "sure"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    table.add_column("judged", no_wrap=True)
    for mark in sorted(landmarks, key=lambda mark: (mark.is_landmark is not True, -mark.observations, mark.id)):
        verdict, style = _VERDICTS[mark.is_landmark]
        table.add_row(
            str(mark.id),
            _board(mark, style),
            " ".join(f"{value:.2f}" for value in mark.position),
            f"{mark.spread:.2f}",
            str(mark.observations),
            f"{mark.confidence:.2f}",
            Text(verdict, style=style),
        )
    return table


def _board(mark: Landmark, style: str) -> Text:
    board = Text(printable(mark.name), style=style)
    texts = [line.text for line in mark.lines]
    if mark.name in texts:
        texts.remove(mark.name)
    if texts:
        board.append("\n" + printable(" · ".join(texts), longest=_LONGEST_BOARD), style="dim")
    return board


_LONGEST_BOARD = 120
"""Characters of a board's other lines in a table."""


def facts_table(facts: Mapping[str, str], title: str = "") -> Table:
    """Two columns: what, and how much of it."""
    table = Table(title=Text(title) if title else None, title_justify="left", show_header=False)
    table.add_column(style="dim")
    table.add_column()
    for what, value in facts.items():
        table.add_row(Text(what), Text(printable(value, longest=200)))
    return table
