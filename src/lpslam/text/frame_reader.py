"""One frame read: boxes found, sorted, held against patterns, recognised, and taken apart where they are blocks."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from time import perf_counter, thread_time

import numpy as np
from numpy.typing import NDArray

from lpslam.config import TextConfig
from lpslam.text.placing.by_depth.hiding import PlacementFault
from lpslam.text.placing.by_depth.placement import is_squeezed
from lpslam.text.reading.blocks import around, read_in_parts, stacks_of
from lpslam.text.reading.boxes import Boxes
from lpslam.text.reading.colours import read_in_colours
from lpslam.text.reading.neighbours import are_among_marks
from lpslam.text.reading.ornaments import pattern_likenesses, says_a_pattern, says_a_text
from lpslam.text.reading.patterns import Likeness
from lpslam.text.reading.spotting import ReadsElsewhere, TextSpotter, accepted_texts
from lpslam.text.reading.windows import WHOLE, Window, boxes_within
from lpslam.text.remembering.ends import is_word
from lpslam.text.remembering.similarity import is_short
from lpslam.text.sorting import CUT, BoxSorter
from lpslam.text.types import BoxFate, FrameReading, PlacedTexts, Placement, Shot, SpottedText, TextStatistics

Array = NDArray[np.float64]


@dataclass(slots=True, eq=False)
class _Sorted:
    """The (n, 4, 2) boxes of a frame, what becomes of each, where those stand that are read, and what they say.

    Rows that are `refused` hold patterns; `doubtful` ones look like patterns, and what they say decides.
    """

    boxes: Boxes
    fates: NDArray[np.object_]
    placements: dict[int, Placement | PlacementFault]
    texts: dict[int, SpottedText] = field(default_factory=dict)
    refused: list[int] = field(default_factory=list)
    doubtful: set[int] = field(default_factory=set)

    def refuse(self, row: int) -> None:
        """Note that a box holds a pattern; one that is cut stays so, since what is beyond nobody saw."""
        self.refused.append(row)
        if self.fates[row] not in CUT:
            self.fates[row] = BoxFate.ORNAMENT

    def add(self, other: "_Sorted") -> None:
        """Take in more boxes."""
        first = len(self.boxes)
        self.boxes = np.concatenate([self.boxes, other.boxes])
        self.fates = np.concatenate([self.fates, other.fates])
        self.placements |= {first + row: each for row, each in other.placements.items()}
        self.texts |= {first + row: each for row, each in other.texts.items()}
        self.refused += [first + row for row in other.refused]

    def mark_unread(self, rows: Sequence[int]) -> list[int]:
        """Mark those of some rows that were to be read and say nothing, and give them."""
        unread = [row for row in rows if row not in self.texts and self.fates[row] == BoxFate.KEPT]
        self.fates[unread] = BoxFate.UNREAD
        return unread

    def said(self, fates: Sequence[BoxFate]) -> PlacedTexts:
        """Texts of boxes with one of the fates, and where they stand."""
        rows = [row for row in self.texts if self.fates[row] in fates]
        return PlacedTexts.of((self.texts[row], self._placement(row)) for row in rows)

    def _placement(self, row: int) -> Placement | None:
        found = self.placements[row]
        return None if isinstance(found, PlacementFault) else found


class FrameReader:
    """Reads frames; remembers nothing."""

    def __init__(self, spotter: TextSpotter, sorter: BoxSorter, config: TextConfig, statistics: TextStatistics) -> None:
        self._spotter = spotter
        self._sorter = sorter
        self._config = config
        self._statistics = statistics

    def read(self, shot: Shot, window: Window = WHOLE) -> FrameReading | None:
        """Read a window of a frame; None when that failed.

        Detect (III-B), drop what is cut off, too small or no text, place (III-F), recognise.
        What stands where a text was read often enough, and no less legibly, is confirmed without being read again.
        """
        self._statistics.frames_read += 1
        processor = self._processor_seconds()
        # A reader may raise anything, on one image in a thousand; the map is worth more than that image.
        try:
            started = perf_counter()
            boxes = boxes_within(self._spotter, shot.frame.rgb, window)
            self._statistics.detection_ms += 1000.0 * (perf_counter() - started)
            found = self._sorted(shot, boxes)
            started = perf_counter()
            rows = self._without_ornaments(shot, found)
            self._recognise(shot, found, rows)
            self._take_apart(shot, found, rows)
            for row in found.mark_unread(rows):
                self._sorter.note_vain(shot, found.boxes[row], found.placements[row])
            unread = np.flatnonzero(found.fates == BoxFate.UNREAD).tolist()
            self._read_unfound(shot, found)
            self._statistics.recognition_ms += 1000.0 * (perf_counter() - started)
        except Exception as error:
            if not self._statistics.reader_errors:
                self._statistics.first_reader_error = f"frame {shot.frame.index}: {error!r}"
            self._statistics.reader_errors += 1
            return None
        finally:
            self._statistics.reader_processor_ms += 1000.0 * (self._processor_seconds() - processor)
        texts, parts = found.said((BoxFate.KEPT,)), found.said(CUT)
        self._statistics.count(found.fates.tolist(), sum(placement is None for placement in texts.placements))
        return FrameReading(
            frame=shot.frame.index,
            boxes=found.boxes,
            fates=tuple(found.fates),
            texts=texts,
            parts=PlacedTexts.of(parts.standing()),
            patterns=tuple(
                each
                for row in [*found.refused, *_among_marks(found, unread)]
                if isinstance(each := found.placements[row], Placement)
            ),
        )

    def _sorted(self, shot: Shot, boxes: Boxes) -> _Sorted:
        started = perf_counter()
        fates, placements = self._sorter.sort(shot, boxes)
        self._statistics.mapping_ms += 1000.0 * (perf_counter() - started)
        return _Sorted(boxes, fates, placements)

    def _without_ornaments(self, shot: Shot, found: _Sorted) -> list[int]:
        """Rows of boxes that are worth reading; patterns among them are marked."""
        rows = sorted(found.placements)
        for row, like in zip(rows, pattern_likenesses(shot.frame.rgb, found.boxes[rows]), strict=True):
            if like is Likeness.IS:
                found.refuse(row)
            elif like is Likeness.LIKE and self._sorter.is_new(found.placements[row], shot.world_from_keyframe):
                found.doubtful.add(row)
        return [row for row in rows if row not in found.refused]

    def _recognise(self, shot: Shot, found: _Sorted, rows: Sequence[int]) -> None:
        if not rows:
            return
        boxes = found.boxes[rows]
        accepted = accepted_texts(boxes, self._spotter.recognise(shot.frame.rgb, boxes), self._config.spotting)
        for row, text in zip(rows, accepted, strict=True):
            if row in found.doubtful and not (text is not None and says_a_text(text.text)):
                found.refuse(row)
                continue
            text = read_in_colours(shot.frame.rgb, found.boxes[row], text, self._spotter, self._config.spotting)
            if text is None or is_squeezed(text.text, found.placements[row]):
                continue
            if not says_a_pattern(shot.frame.rgb, text.box, text.text):
                found.texts[row] = text
            else:
                found.refuse(row)

    def _take_apart(self, shot: Shot, found: _Sorted, rows: Sequence[int]) -> None:
        """Read boxes that say nothing as one line in their columns and lines, and columns that were found as lines."""
        kept = [row for row in rows if found.fates[row] == BoxFate.KEPT]
        for row in kept:
            self._replace(shot, found, [row], found.boxes[row], found.texts.get(row))
        lines = [row for row in kept if row in found.texts]
        for stack in stacks_of([found.texts[row] for row in lines]):
            own = [lines[at] for at in stack]
            self._replace(shot, found, own, around([found.texts[row] for row in own]), None)

    def _read_unfound(self, shot: Shot, found: _Sorted) -> None:
        """Read texts of which nothing was found in this image where they stand; it counts if it is like them."""
        classes, boxes = self._sorter.expected_in(shot, found.boxes)
        if not classes:
            return
        own = self._sorted(shot, boxes)
        own.placements = {row: each for row, each in own.placements.items() if own.fates[row] not in CUT}
        rows = self._without_ornaments(shot, own)
        self._recognise(shot, own, rows)
        for row in rows:
            if not self._sorter.says_what_is_expected(classes[row], own.texts.get(row)):
                own.texts.pop(row, None)
        own.mark_unread(rows)
        found.add(own)

    def _replace(self, shot: Shot, found: _Sorted, rows: Sequence[int], box: Array, whole: SpottedText | None) -> None:
        """Put what the parts of a box say in the place of what its rows said, if they say anything."""
        parts = read_in_parts(shot.frame.rgb, box, whole, self._spotter, self._config.spotting)
        if not parts:
            return
        for row in rows:
            found.texts.pop(row, None)
        own = self._sorted(shot, np.array([each.box for each in parts]))
        own.texts = {at: text for at, text in enumerate(parts) if at in own.placements}
        found.add(own)

    def _processor_seconds(self) -> float:
        spotter = self._spotter
        return thread_time() + (spotter.seconds_elsewhere if isinstance(spotter, ReadsElsewhere) else 0.0)


def _among_marks(found: _Sorted, unread: Sequence[int]) -> list[int]:
    """Rows of short texts, no words, that stand among boxes as large in which there is nothing to read."""
    rows = [row for row, text in found.texts.items() if is_short(text.text) and not is_word(text.text)]
    among = are_among_marks(found.boxes[rows], found.boxes[unread])
    return [row for row, is_among in zip(rows, among, strict=True) if is_among]
