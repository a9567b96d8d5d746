"""The landmarks of a map, made ready for many questions."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator

from lpslam.config import NavigationConfig
from lpslam.language.kept import steps_of
from lpslam.language.model import Candidate
from lpslam.navigation.places import Place
from lpslam.navigation.sites import Sites
from lpslam.text.types import Landmark


class Directory:
    """Landmarks as language and the solver take them, prepared once; it is not changed, so threads may share it.

    Args:
        landmarks: of a map.
        config: thresholds of questions about them; the defaults without.

    Attributes:
        config: as it was given.
        landmarks: as they were given.
        by_id: the same, looked up.
        candidates: ids and strings, for language. One object: the embedded model knows it again by that.
        sites: ids and positions, for the solver.
        names: how many landmarks have each name.
    """

    def __init__(self, landmarks: Iterable[Landmark], config: NavigationConfig | None = None) -> None:
        self.config = config or NavigationConfig()
        self.landmarks = tuple(landmarks)
        self.by_id = {mark.id: mark for mark in self.landmarks}
        self.candidates = tuple(
            Candidate(mark.id, mark.name, tuple(mark.variants), mark.other_lines) for mark in self.landmarks
        )
        self.sites = Sites(
            tuple(
                Place(mark.id, mark.name, mark.position, mark.normal, mark.width, mark.spread)
                for mark in self.landmarks
            )
        )
        self.names = Counter(mark.name for mark in self.landmarks)

    def preparations(self) -> Iterator[None]:
        """Build, a little at a time, what the solver asks of the places when it first needs it."""
        return steps_of((self.sites,))

    def without(self, excluded: Collection[int]) -> "Directory":
        """The same without some landmarks; itself where there is none of them."""
        if not any(id_ in self.by_id for id_ in excluded):
            return self
        return Directory((mark for mark in self.landmarks if mark.id not in excluded), self.config)
