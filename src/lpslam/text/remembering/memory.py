"""Long-short-term memory of texts (paper, III-D, Fig. 2).

Readings that are alike form classes. A sighting strengthens its class; time weakens all. What is seen often enough
moves to a separate long-term pool and stays; what is not is forgotten. So a misreading, which comes once or twice,
never enters the map.
"""

from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field
from enum import StrEnum

from lpslam.config import MemoryConfig
from lpslam.language.model import Naming, Reading
from lpslam.text.reading.certainty import probability_right
from lpslam.text.remembering.evidence import Glance, Look, note, readings_of, wholes_of
from lpslam.text.remembering.similarity import best_class, comparison_key
from lpslam.text.types import TextObservation

# A class is recognised by its commonest spellings only: else each slip would admit the next, and classes would drift.
_LEADING_SPELLINGS = 4

# Eq. 3 similarity from which a spelling is nearly another one.
_NEARLY = 0.75

# Pixels, of a box that nothing is known of.
_USUAL_HEIGHT = 24.0

# Forgetting is given a frame, for the camera's usual 30 frames a second, and acts on time.
_FRAMES_PER_SECOND = 30.0

# Full sighting intervals between looks of their own.
_APART = 2.0

# Classes that were forgotten are remembered for the figure only.
_FORGOTTEN_SHOWN = 64


class Pool(StrEnum):
    """Where a class is kept."""

    SHORT_TERM = "short-term"
    LONG_TERM = "long-term"


@dataclass(slots=True)
class Variant:
    """One spelling of a class: how often it was read, and the sum of its confidences, each times P(right)."""

    count: int = 0
    confidence: float = 0.0


@dataclass(slots=True)
class TextClass:
    """A class of homologous texts: readings that are taken for the same words in the world.

    Attributes:
        id: never used again, also after the class is forgotten.
        variants: by spelling.
        score: strength in memory.
        pool: short-term until the score first reaches the promotion threshold.
        first_seen, last_seen, promoted_at: seconds.
        history: (seconds, score) after each change by a sighting, and as it fades (Fig. 13).
        observations: its sightings, placed by depth or known by their bearings.
        looks: all sightings, spelling by spelling and view by view; none in maps of older programs.
        visits: how often it came into view after a pause.
        naming: the name chosen for it, once it is in long-term memory.
        named_at_count: how many readings that choice rested on.
    """

    id: int
    first_seen: float
    last_seen: float
    variants: dict[str, Variant] = field(default_factory=dict)
    score: float = 0.0
    pool: Pool = Pool.SHORT_TERM
    promoted_at: float | None = None
    history: list[tuple[float, float]] = field(default_factory=list)
    observations: list[TextObservation] = field(default_factory=list)
    looks: list[Look] = field(default_factory=list)
    visits: int = 0
    naming: Naming | None = None
    named_at_count: int = 0

    @property
    def count(self) -> int:
        """How often any of its spellings was read."""
        return sum(variant.count for variant in self.variants.values())

    @property
    def spellings(self) -> list[str]:
        """Its spellings, those first that were read most often and surely."""
        return sorted(self.variants, key=lambda text: (-self.variants[text].confidence, text))

    @property
    def leading_spellings(self) -> list[str]:
        """The spellings by which it is recognised."""
        return self.spellings[:_LEADING_SPELLINGS]

    def is_like(self, text: str, least: float) -> bool:
        """Whether a text is so similar to one of them."""
        return best_class(text, {self.id: self.leading_spellings}, least) is not None

    def has_more_than(self, text: str) -> bool:
        """Whether a longer spelling that was read has all of a text in it."""
        key = comparison_key(text)
        return any(key in longer and key != longer for longer in map(comparison_key, self.variants))

    @property
    def read_again(self) -> list[str]:
        """What was read more than once, but for case and spaces: a spelling of each."""
        counts: dict[str, int] = {}
        for text, variant in self.variants.items():
            counts[comparison_key(text)] = counts.get(comparison_key(text), 0) + variant.count
        spellings = {comparison_key(text): text for text in reversed(self.spellings)}
        return [spellings[key] for key, count in counts.items() if count > 1]

    def readings(self, config: MemoryConfig) -> list[Reading]:
        """Its spellings as the language layer sees them, weightiest first."""
        if self.looks:
            return readings_of(self.looks, config, wholes_of(self.observations))
        counted = [(text, self.variants[text]) for text in self.spellings]
        return [Reading(text, variant.count, variant.confidence / variant.count) for text, variant in counted]

    @property
    def name(self) -> str:
        """The name chosen for it, or its surest spelling while none is."""
        return self.naming.name if self.naming else self.spellings[0]


@dataclass(frozen=True, slots=True)
class ForgottenClass:
    """What Fig. 13 shows of a class that was forgotten."""

    id: int
    name: str
    history: tuple[tuple[float, float], ...]


class LongShortTermMemory:
    """The two pools of classes, their strengthening, forgetting and promotion. Deterministic."""

    def __init__(self, config: MemoryConfig) -> None:
        self.config = config
        self.short_term: dict[int, TextClass] = {}
        self.long_term: dict[int, TextClass] = {}
        self.forgotten: deque[ForgottenClass] = deque(maxlen=_FORGOTTEN_SHOWN)
        self.forgotten_count = 0
        self.next_id = 0
        self.clock: float | None = None

    @property
    def classes(self) -> list[TextClass]:
        """All classes of both pools, long-term first, by id."""
        return [pool[key] for pool in (self.long_term, self.short_term) for key in sorted(pool)]

    def is_remembered(self, text: str) -> bool:
        """Whether a class in long-term memory is known by nearly the same spelling."""
        known = {each.id: each.leading_spellings for each in self.long_term.values()}
        return best_class(text, known, _NEARLY) is not None

    def classes_of(self, identifiers: Collection[int]) -> list[TextClass]:
        """The classes with some ids, by id; those that were forgotten are left out."""
        found = ((self.long_term.get(each) or self.short_term.get(each)) for each in sorted(identifiers))
        return [each for each in found if each is not None]

    def forget(self, timestamp: float) -> None:
        """Let time pass until `timestamp`: every score fades, and short-term classes without any are eliminated.

        Acts on the seconds passed, not on the number of calls: what is remembered does not depend on the frame rate.
        """
        elapsed = 0.0 if self.clock is None else max(0.0, timestamp - self.clock)
        self.clock = timestamp if self.clock is None else max(timestamp, self.clock)
        faded = self.config.forgetting * _FRAMES_PER_SECOND * elapsed
        if faded == 0.0:
            return
        for text_class in self.classes:
            if text_class.score == 0.0:
                continue
            text_class.score = max(0.0, text_class.score - faded)
            if text_class.score == 0.0:
                self._record(text_class, timestamp)
        for text_class in [each for each in self.short_term.values() if each.score == 0.0]:
            del self.short_term[text_class.id]
            self.forgotten_count += 1
            self.forgotten.append(ForgottenClass(text_class.id, text_class.name, tuple(text_class.history)))

    def sight(
        self,
        text: str,
        confidence: float,
        timestamp: float,
        here: Collection[int] = (),
        glance: Glance | None = None,
        comes_again: bool = False,
    ) -> TextClass:
        """Classify a reading by similarity (III-C) and strengthen its class; a text like no other founds one.

        Call `forget` with the same time first.

        Args:
            text, confidence: as read.
            timestamp: seconds.
            here: ids of classes read before at the spot of this text; less similarity is asked of them.
            glance: how it was seen; None counts as a usual way.
            comes_again: whether the same was read at this spot before. Where it is forgotten, that look counts again.
        """
        glance = glance or Glance(_USUAL_HEIGHT, 1.0, probability_right(text, confidence))
        text_class = self._classify(text, here)
        says_the_same = text_class is not None and text in text_class.variants
        if text_class is None:
            text_class = self._found(timestamp)
            if comes_again:
                # Two looks that are apart and say the same, however long ago the first one was.
                text_class.score, says_the_same = confidence, True
                text_class.last_seen = timestamp - self.config.visit_pause
                self._record(text_class, text_class.last_seen)
        variant = text_class.variants.setdefault(text, Variant())
        variant.count += 1
        variant.confidence += confidence * glance.right
        if timestamp - text_class.last_seen > self.config.visit_pause:
            text_class.visits += 1
        note(text_class.looks, text, confidence, text_class.visits, glance)
        self._strengthen(text_class, confidence, timestamp, says_the_same)
        return text_class

    def confirm(self, identifier: int, timestamp: float) -> None:
        """Strengthen a class that was seen where it is known to be, without having been read again."""
        text_class = self.long_term.get(identifier) or self.short_term.get(identifier)
        if text_class is not None:
            self._strengthen(text_class, 1.0, timestamp)

    def _strengthen(
        self, text_class: TextClass, confidence: float, timestamp: float, says_the_same: bool = False
    ) -> None:
        # Sightings in quick succession are one look: their misreadings repeat, so they are not independent evidence.
        # A camera's frames are not always read in their order.
        last = text_class.last_seen if timestamp >= text_class.last_seen else text_class.history[-1][0]
        interval = abs(timestamp - last) if text_class.history else self.config.full_sighting_interval
        looks = interval / self.config.full_sighting_interval
        weight = self.config.independent_weight if says_the_same and looks >= _APART else min(1.0, looks)
        self._record(text_class, timestamp)
        text_class.score = min(self.config.ceiling, text_class.score + confidence * weight)
        text_class.last_seen = max(timestamp, text_class.last_seen)
        self._record(text_class, timestamp)

        if text_class.pool is Pool.SHORT_TERM and text_class.score >= self.config.promotion:
            self._promote(text_class, timestamp)

    def _classify(self, text: str, here: Collection[int]) -> TextClass | None:
        known = {each.id: each.leading_spellings for each in self.classes}
        identifier = best_class(text, known, self.config.similarity)
        if identifier is None:
            known_here = {key: spellings for key, spellings in known.items() if key in here}
            identifier = best_class(text, known_here, self.config.similarity_in_place)
        if identifier is None:
            return None
        return self.long_term.get(identifier) or self.short_term[identifier]

    def _found(self, timestamp: float) -> TextClass:
        text_class = TextClass(self.next_id, timestamp, timestamp)
        self.short_term[text_class.id] = text_class
        self.next_id += 1
        return text_class

    def _promote(self, text_class: TextClass, timestamp: float) -> None:
        del self.short_term[text_class.id]
        self.long_term[text_class.id] = text_class
        text_class.pool = Pool.LONG_TERM
        text_class.promoted_at = timestamp

    def _record(self, text_class: TextClass, timestamp: float) -> None:
        text_class.history.append((timestamp, text_class.score))
        if len(text_class.history) > self.config.history:
            # Every other sample goes, never the first or the last.
            text_class.history[1:-1] = text_class.history[2:-1:2]
