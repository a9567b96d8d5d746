"""What becomes of detected boxes before they are read: cut off, too small, known already, a pattern, or to be read."""

from collections import Counter
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import TextConfig
from lpslam.text.placing.by_depth.hiding import PlacementFault, hidden_pixels
from lpslam.text.placing.by_depth.placement import place_text
from lpslam.text.placing.directions import Directions
from lpslam.text.placing.spots import Spots
from lpslam.text.placing.views import bearing_of
from lpslam.text.reading.blocks import may_run_down
from lpslam.text.reading.borders import cut_by_border, room_beyond
from lpslam.text.reading.boxes import Boxes, letter_heights, share_a_middle
from lpslam.text.reading.legibility import SeenSize, frontal_cosine
from lpslam.text.remembering.known_names import WORD_ENDS
from lpslam.text.remembering.memory import LongShortTermMemory
from lpslam.text.remembering.similarity import is_short
from lpslam.text.types import NOWHERE, Bearing, BoxFate, Placement, Shot, SpottedText

Array = NDArray[np.float64]

CUT = (BoxFate.BORDER, BoxFate.HIDDEN)
"""Fates of boxes whose text may go on where the view ends."""


class BoxSorter:
    """Decides which boxes are worth reading, by where they stand and what was read there."""

    def __init__(
        self,
        camera: PinholeCamera,
        config: TextConfig,
        memory: LongShortTermMemory,
        spots: Spots,
        points_seen_by: Callable[[int], Array],
    ) -> None:
        self.directions = Directions()
        self._in_vain: Counter[int] = Counter()
        self._camera = camera
        self._config = config
        self._memory = memory
        self._spots, self._vain = spots, Spots()
        self._said_nothing = config.reading.model_copy(update={"better_size": config.reading.vain_better})
        self._points_seen_by = points_seen_by

    def sort(self, shot: Shot, boxes: Boxes) -> tuple[NDArray[np.object_], dict[int, Placement | PlacementFault]]:
        """What becomes of each of (n, 4, 2) boxes before it is read, and, of those that shall be, where they stand."""
        config, frame, keyframe_from_camera = self._config.spotting, shot.frame, shot.keyframe_from_camera
        world_from_keyframe = shot.world_from_keyframe
        fates = np.full(len(boxes), BoxFate.KEPT, dtype=object)
        heights = letter_heights(boxes)
        is_small = heights < config.min_letter_height
        fates[is_small] = BoxFate.SMALL
        fates[cut_by_border(frame.rgb, boxes)] = BoxFate.BORDER
        place = partial(
            place_text,
            depth=frame.depth,
            camera=self._camera,
            keyframe_from_camera=keyframe_from_camera,
            config=self._config.placement,
            map_points=partial(self._points_in_view, shot),
            rgb=frame.rgb,
        )
        placements: dict[int, Placement | PlacementFault] = {}
        for row in np.flatnonzero((fates == BoxFate.KEPT) | (fates == BoxFate.BORDER) & ~is_small).tolist():
            placement = place(boxes[row], is_cut=fates[row] == BoxFate.BORDER)
            if placement in (PlacementFault.HIDDEN, PlacementFault.STEPPED):
                fates[row] = BoxFate.HIDDEN
                placement = place(boxes[row], is_cut=True)
            is_placed = isinstance(placement, Placement) and world_from_keyframe is not None
            if not isinstance(placement, Placement) or not self.is_sure(placement) or world_from_keyframe is None:
                is_kept = fates[row] == BoxFate.KEPT
                if is_kept and world_from_keyframe is not None:
                    bearing = bearing_of(boxes[row], self._camera, keyframe_from_camera)
                    if self._was_read_from(shot.keyframe, bearing, heights[row], frame.timestamp):
                        fates[row] = BoxFate.KNOWN
                        continue
                # What is cut waits for its rest where it stands, be that roughly known.
                if is_kept or is_placed:
                    placements[row] = placement
                continue
            seen = SeenSize(heights[row], frontal_cosine(placement, keyframe_from_camera))
            room = partial(self._room, shot, boxes[row], placement, False)
            if fates[row] == BoxFate.KEPT and self._is_known(
                placement, seen, room, frame.timestamp, world_from_keyframe
            ):
                fates[row] = BoxFate.KNOWN
            elif self._says_nothing(placement, seen, world_from_keyframe):
                fates[row] = BoxFate.UNREAD
            elif fates[row] == BoxFate.KEPT or not self._has_sure_name(placement, world_from_keyframe):
                placements[row] = placement
        return fates, placements

    def note_vain(self, shot: Shot, box: Array, placement: Placement | PlacementFault) -> None:
        """Note that what was read in a box (4, 2) was no text."""
        if isinstance(placement, Placement) and shot.world_from_keyframe is not None:
            height = float(letter_heights(box[None])[0])
            seen = SeenSize(height, frontal_cosine(placement, shot.keyframe_from_camera))
            self._vain.add(0, "", placement, shot.world_from_keyframe, seen)

    def _says_nothing(self, placement: Placement, seen: SeenSize, world_from_keyframe: Array) -> bool:
        """Whether nothing was ever read here, in as many views as settle a name, and nearly as good ones."""
        if self._spots.classes_at(placement, world_from_keyframe):
            return False
        return (
            self._vain.settled_at(placement, world_from_keyframe, seen, lambda _: True, self._said_nothing) is not None
        )

    def _has_sure_name(self, placement: Placement, world_from_keyframe: Array) -> bool:
        return any(map(self._is_sure_of_name, self._spots.classes_at(placement, world_from_keyframe)))

    def expected_in(self, shot: Shot, boxes: Boxes) -> tuple[list[int], Boxes]:
        """Classes of which another reading would tell something, and their boxes, wholly in view and none of these.

        A detector misses most images of some texts, though what it finds in few is read in all.
        """
        if shot.world_from_keyframe is None:
            return [], boxes[:0]
        config, classes, expected = self._config.reading, [], boxes
        world_from_camera = shot.world_from_camera
        camera_from_world = inverse_transform(world_from_camera)
        for identifier, corners, normal in self._spots.boxes(self._is_unsettled):
            way = world_from_camera[:3, 3] - corners.mean(axis=0)
            corners = transform_points(camera_from_world, corners)
            is_aslant = normal @ way < config.unfound_cosine * np.linalg.norm(way)
            if is_aslant or corners[:, 2].min() < config.unfound_distance:
                continue
            box = self._camera.distort(self._camera.project(corners))
            is_inside = box.min() >= 0.0 and (box.max(axis=0) < (self._camera.width, self._camera.height)).all()
            if is_inside and not share_a_middle(box, expected):
                classes.append(identifier)
                expected = np.concatenate([expected, box[None]])
        return classes, expected[len(boxes) :]

    def _is_unsettled(self, identifier: int) -> bool:
        if self._in_vain[identifier] >= self._config.reading.unfound_patience:
            return False
        # What is read in any box is like a short text.
        most = self._config.reading.settled_sightings
        known = self._memory.classes_of([identifier])
        is_open = any(each.count < most and not is_short(each.spellings[0]) for each in known)
        return is_open and not self._is_sure_of_name(identifier)

    def says_what_is_expected(self, identifier: int, said: SpottedText | None) -> bool:
        """Whether a text is like the readings of a class, and no piece of one; how often it is not is counted."""
        text, least = said.text if said is not None else "", self._config.memory.similarity_in_place
        known = self._memory.classes_of([identifier]) if text else ()
        is_said = any(each.is_like(text, least) and not each.has_more_than(text) for each in known)
        self._in_vain[identifier] += -1 if is_said else 1
        return is_said

    def is_sure(self, placement: Placement) -> bool:
        """Whether a place is certain enough to be evidence of what stands where."""
        return placement.uncertainty <= self._config.instances.doubtful_uncertainty

    def is_new(self, placement: Placement | PlacementFault, world_from_keyframe: Array | None) -> bool:
        """Whether a text has a place at which nothing was read half as often as what is settled."""
        if not isinstance(placement, Placement) or world_from_keyframe is None:
            return False
        here = self._memory.classes_of(self._spots.classes_at(placement, world_from_keyframe))
        return all(2 * each.count < self._config.reading.settled_sightings for each in here)

    def room_of(
        self, shot: Shot, text: SpottedText, placement: Placement | None, is_cut: bool = False
    ) -> tuple[float, float]:
        """How far the view goes on before and behind a text, in heights of its box.

        One that is not cut ends as words do: ground was seen beyond its last strokes.
        """
        before, behind = self._room(shot, text.box, placement, may_run_down(text))
        least = 0.0 if is_cut else WORD_ENDS
        return max(before, least), max(behind, least)

    def _room(self, shot: Shot, box: Array, placement: Placement | None, either_way: bool) -> tuple[float, float]:
        seen = shot.frame.depth, self._camera, shot.keyframe_from_camera
        hidden = hidden_pixels(box, placement, *seen, self._config.placement)
        return room_beyond(shot.frame.rgb, box, hidden, either_way)

    def _is_known(
        self,
        placement: Placement,
        seen: SeenSize,
        room: Callable[[], tuple[float, float]],
        timestamp: float,
        world_from_keyframe: Array,
    ) -> bool:
        """Whether what stands here is known so well that reading it again would tell nothing; it is confirmed then."""
        settled = self._spots.settled_at(
            placement, world_from_keyframe, seen, self._is_sure_of_name, self._config.reading, room
        )
        if settled is None:
            return False
        self._memory.confirm(settled, timestamp)
        return True

    def _was_read_from(self, keyframe: int, bearing: Bearing, letters: float, timestamp: float) -> bool:
        """Whether a text without a sure place was read so from this keyframe that another reading tells nothing."""
        known = self.directions.settled_at(keyframe, bearing, letters, self._is_sure_of_name, self._config.reading)
        if known is None:
            return False
        self._memory.confirm(known, timestamp)
        return True

    def _is_sure_of_name(self, identifier: int) -> bool:
        text_class = self._memory.long_term.get(identifier)
        naming = text_class.naming if text_class is not None else None
        return naming is not None and naming.confidence >= self._config.reading.settled_certainty

    def _points_in_view(self, shot: Shot) -> Array:
        if shot.keyframe == NOWHERE:
            return np.zeros((0, 3))
        return transform_points(inverse_transform(shot.keyframe_from_camera), self._points_seen_by(shot.keyframe))
