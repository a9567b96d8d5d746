"""Second looks: an unsure text is drawn from all its views and read once more.

What is read is one more reading of its class, with a probability of its own; nothing is promoted or founded by it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lpslam.camera import PinholeCamera
from lpslam.text.again.averaging import Canvas, canvas_of
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.placing.places import Place, places_of_class
from lpslam.text.reading.borders import cut_by_border
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.certainty import probability_right
from lpslam.text.reading.spotting import TextSpotter, accepted_texts
from lpslam.text.remembering.evidence import Glance, note
from lpslam.text.remembering.memory import TextClass, Variant
from lpslam.text.text_map import TextMap
from lpslam.text.types import SpottedText

Array = NDArray[np.float64]

_FIRST_VIEW = 2
"""Visits are counted from 0, so what is drawn from keyframe k is a view of its own as visit -k - 2."""

_SAME_MIDDLE, _SAME_SIZE = 0.5, 1.6
"""A box of the drawing is a text's if their middles are within this share of the letters' height and a third of the
length, and their sides within this factor."""

_OFTEN = 3
"""Readings from which a spelling is held to have shown all that stands there."""


@dataclass(frozen=True, slots=True)
class Looked:
    """What second looks did: texts drawn, readings of them that joined a class, and pixels searched."""

    texts: int = 0
    readings: int = 0
    pixels: int = 0


def look_again(
    text_map: TextMap,
    world_from_keyframe: KeyframePoses,
    camera: PinholeCamera,
    spotter: TextSpotter,
    name: Callable[[TextClass], object],
    pixels: float = np.inf,
    should_stop: Callable[[], bool] = lambda: False,
) -> Looked:
    """Look once more at every unsure text of which there are crops, those seen largest first, and name them anew.

    The crops of what was looked at are dropped; what there was no time for keeps them, for `lpslam distill`.

    Args:
        text_map: is changed.
        world_from_keyframe: takes a keyframe's id to its 4×4 pose.
        camera: whose raw pixels the crops are.
        spotter: finds and reads text.
        name: names a class anew, by whichever model names the classes of this map.
        pixels: that may be searched at most.
        should_stop: asked before every text.
    """
    config, looked = text_map.config, Looked()
    store = text_map.crops
    store.drop([key for key in store.by_class if not text_map.is_unsure(key)])
    largest = {key: max(crop.seen.effective for crop in crops) for key, crops in store.by_class.items()}
    for key in sorted(largest, key=lambda each: (-largest[each], each)):
        if should_stop():
            break
        text_class = text_map.memory.long_term[key]
        places = places_of_class(text_class, world_from_keyframe, config.instances, config.memory)
        drawn = [_canvas(place, text_class, text_map, world_from_keyframe, camera) for place in places]
        canvases = [each for each in drawn if each is not None]
        cost = sum(each.rgb[..., 0].size for each in canvases)
        if looked.pixels + cost > pixels:
            break
        readings = sum(_read(canvas, text_class, text_map, spotter) for canvas in canvases)
        looked = Looked(looked.texts + len(canvases), looked.readings + readings, looked.pixels + cost)
        store.drop([key])
        if readings:
            name(text_class)
    return looked


def _canvas(
    place: Place, text_class: TextClass, text_map: TextMap, world_from_keyframe: KeyframePoses, camera: PinholeCamera
) -> Canvas | None:
    """A class at one of its places, drawn from the crops that were taken there."""
    taken = {each.timestamp for each in text_class.observations if each.frame in place.positions_by_frame}
    crops = [crop for crop in text_map.crops.by_class[text_class.id] if crop.timestamp in taken]
    return canvas_of(place, crops, world_from_keyframe, camera, text_map.config.again)


def _read(canvas: Canvas, text_class: TextClass, text_map: TextMap, spotter: TextSpotter) -> int:
    """Read the text in its own box and in the boxes found anew; how many readings were like its class."""
    config = text_map.config
    found, _ = spotter.detect(canvas.rgb)
    found = found[_are_its(found, canvas.box)]
    # What goes on beyond the drawing is a piece, however well its letters are read.
    boxes = np.concatenate([canvas.box[None], found[~cut_by_border(canvas.rgb, found)]])
    accepted = accepted_texts(boxes, spotter.recognise(canvas.rgb, boxes), config.spotting)
    accepted = [None if each is None else without_neighbours(each, text_class) for each in accepted]
    texts = [
        each
        for row, each in enumerate(accepted)
        if each is not None
        and text_class.is_like(each.text, config.memory.similarity_in_place)
        # The known box is a median, also of boxes around pieces: what it cuts off says nothing of a text's ends.
        and not (row == 0 and text_class.has_more_than(each.text))
    ]
    if texts:
        # Both boxes are cut from one drawing: the surer reading is what it says.
        _add(max(texts, key=lambda each: _glance(each, canvas).right), canvas, text_class)
    return min(len(texts), 1)


def without_neighbours(text: SpottedText, text_class: TextClass) -> SpottedText:
    """Cut off what stands before or behind a spelling that was read often, where no reading had anything there.

    What is drawn reaches beyond the text, so a box that is found in it may take in a neighbour. It shows the same
    pixels as the readings: had more been painted, one of them would have had some of it.
    """
    read = text.text.casefold()
    for spelling in text_class.leading_spellings:
        key = spelling.casefold()
        at = read.find(key)
        if at < 0 or 2 * len(key) < len(read) or text_class.variants[spelling].count < _OFTEN:
            continue
        others = [each.casefold().partition(key) for each in text_class.variants]
        first = 0 if any(middle and before for before, middle, _ in others) else at
        last = len(read) if any(middle and after for _, middle, after in others) else at + len(key)
        if len(read) == len(text.text) and (first, last) != (0, len(read)):
            return replace(text, text=text.text[first:last].strip(), slots=())
    return text


def _add(text: SpottedText, canvas: Canvas, text_class: TextClass) -> None:
    glance = _glance(text, canvas)
    variant = text_class.variants.setdefault(text.text, Variant())
    variant.count += 1
    variant.confidence += text.confidence * glance.right
    note(text_class.looks, text.text, text.confidence, -canvas.reference.keyframe - _FIRST_VIEW, glance)


def _glance(text: SpottedText, canvas: Canvas) -> Glance:
    seen = canvas.reference.seen
    right = probability_right(
        text.text, text.confidence, text.slots, text.sharpness, seen.height, seen.frontal, text.has_hole
    )
    return Glance(seen.height, seen.frontal, right, text.slots)


def _are_its(boxes: Array, own: Array) -> NDArray[np.bool_]:
    """Which boxes (n, 4, 2) are around the text whose box (4, 2) is known."""
    if not len(boxes):
        return np.zeros(0, np.bool_)
    size, sizes = np.ptp(own, axis=0), np.ptp(boxes, axis=1)
    letter = float(letter_heights(own[None])[0])
    away = np.abs(boxes.mean(axis=1) - own.mean(axis=0))
    near = (away <= np.maximum(size / 3.0, _SAME_MIDDLE * letter)) & (away <= size / 3.0 + 1.0)
    ratio = np.maximum(sizes, 1.0) / size
    alike = (ratio <= _SAME_SIZE) & (ratio >= 1.0 / _SAME_SIZE)
    return np.asarray(near.all(axis=1) & alike.all(axis=1), np.bool_)
