"""Points, commas and colons within numbers are lost far more often than they are seen where none is."""

import pytest

from lpslam.language.model import Reading
from lpslam.language.naming.voting import vote
from lpslam.language.offline import OfflineModel


def readings(*counted: tuple[str, int]) -> list[Reading]:
    """Spellings that were read so often, the shorter ones surer: a comma in chalk spoils the reader's confidence."""
    return [Reading(text, count, 0.95 if text.isdigit() else 0.85) for text, count in counted]


@pytest.mark.parametrize(
    ("read", "painted"),
    [
        ([("220", 10), ("2,20", 3)], "2,20"),
        ([("490", 22), ("4,90", 4)], "4,90"),
        ([("830", 7), ("8:30", 2)], "8:30"),
        ([("SOUP 650", 5), ("SOUP 6.50", 3)], "SOUP 6.50"),
        # What is seen once in many readings is a speck, and letters have no points between them.
        ([("220", 30), ("2,20", 1)], "220"),
        ([("BARREL", 10), ("BAR.REL", 3)], "BARREL"),
        ([("ROOM 12", 10), ("ROOM. 12", 3)], "ROOM 12"),
    ],
)
def test_a_point_that_few_readings_show(read: list[tuple[str, int]], painted: str) -> None:
    assert vote(readings(*read)).text == painted
    assert OfflineModel().name(readings(*read)).name == painted
