import numpy as np

from lpslam.config import ReadingConfig
from lpslam.text.placing.directions import Directions
from lpslam.text.types import Bearing

CONFIG = ReadingConfig()


def seen(x: float = 0.0, y: float = 0.0, width: float = 0.4, height: float = 0.05) -> Bearing:
    """A box in a direction, tangents of the angles."""
    rays = np.array([[x, y, 1.0], [x + width, y, 1.0], [x + width, y + height, 1.0], [x, y + height, 1.0]])
    first, second, third, fourth = (
        (float(ray[0]), float(ray[1]), float(ray[2])) for ray in rays / np.linalg.norm(rays, axis=1, keepdims=True)
    )
    return Bearing((0.0, 0.0, 0.0), (first, second, third, fourth))


def known(
    directions: Directions, bearing: Bearing, keyframe: int = 3, letters: float = 30.0, sure: bool = True
) -> int | None:
    return directions.settled_at(keyframe, bearing, letters, lambda identifier: sure, CONFIG)


def read_twice(identifier: int = 7) -> Directions:
    directions = Directions()
    directions.add(3, identifier, seen(), 30.0)
    assert known(directions, seen()) is None, "one reading may be a slip"
    directions.add(3, identifier, seen(x=0.02), 31.0)
    return directions


def test_what_was_read_twice_from_a_keyframe_tells_nothing_more() -> None:
    assert known(read_twice(), seen(x=0.05, y=0.01)) == 7
    assert known(read_twice(), seen(), sure=False) is None


def test_another_keyframe_is_another_view() -> None:
    directions = read_twice()
    assert known(directions, seen(), keyframe=4) is None
    directions.add(4, 7, seen(), 30.0)
    assert known(directions, seen(), keyframe=4) is None
    assert known(directions, seen(), keyframe=3) is None


def test_what_is_seen_larger_or_longer_is_read() -> None:
    assert known(read_twice(), seen(), letters=48.0) is None
    assert known(read_twice(), seen(width=0.5)) is None


def test_lines_below_and_beside_are_other_texts() -> None:
    assert known(read_twice(), seen(y=0.07)) is None
    assert known(read_twice(), seen(x=0.45)) is None
    directions = read_twice()
    directions.add(3, 8, seen(), 30.0)
    assert known(directions, seen()) is None, "two classes contradict each other"


def test_a_line_that_runs_downwards_is_told_from_the_next_column() -> None:
    directions = Directions()
    for _ in range(2):
        directions.add(3, 7, seen(width=0.05, height=0.4), 30.0)
    assert known(directions, seen(width=0.05, height=0.4, y=0.01)) == 7
    assert known(directions, seen(width=0.05, height=0.4, x=0.07)) is None
