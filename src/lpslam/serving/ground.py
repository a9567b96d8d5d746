"""What maps know of the ground: goal poses, ways and the occupancy grid; most maps know nothing of it yet."""

from lpslam.errors import UserError
from lpslam.serving.atlas import ServedMap


class NoGroundError(UserError):
    """The map has no ground to go on."""

    def __init__(self, name: str) -> None:
        super().__init__(f"map {name} has no ground: where one can go is not known; ask for the place itself with /ask")


def refuse_no_ground(served: ServedMap) -> None:
    """Raise where the map does not know where one can go.

    Raises:
        NoGroundError: it does not.
    """
    raise NoGroundError(served.name)
