"""Which topics are the colour, the depth and their calibrations: by type and by what their pictures hold."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lpslam.errors import UserError
from lpslam.sources.bags.containers.container import Container, Topic
from lpslam.sources.bags.messages import CAMERA_INFO, COMPRESSED, IMAGE, BadMessageError, decoded, known_type
from lpslam.sources.bags.pictures import DEPTH_ENCODINGS, encoding_of

_GREY = ("mono8", "8UC1", "y8")
_REGISTERED = ("aligned", "registered", "to_color", "to_rgb")
_ENDINGS = ("info/camera_info", "image/camera_info", "camera_info")
_TRIES = 5
"""Messages of a topic that are looked at until one can be decoded."""


@dataclass(frozen=True, slots=True)
class TopicChoice:
    """What a user asked for; None where it is to be found.

    Attributes:
        colour, depth: topics of pictures.
        info: the topic of the colour camera's calibration.
    """

    colour: str | None = None
    depth: str | None = None
    info: str | None = None


@dataclass(frozen=True, slots=True, eq=False)
class PictureTopic:
    """A topic of pictures, with the first that can be decoded."""

    topic: Topic
    first: Any

    @property
    def name(self) -> str:
        """As recorded."""
        return self.topic.name

    @property
    def is_depth(self) -> bool:
        """By its encoding; a compressed picture's by its header or its name."""
        encoding = encoding_of(self.first)
        if encoding == "compressed":
            return "16UC1" in str(self.first.format) or "32FC1" in str(self.first.format)
        return encoding == "compressedDepth" or encoding in DEPTH_ENCODINGS

    @property
    def is_grey(self) -> bool:
        """Whether it has no colours, as infrared pictures."""
        return encoding_of(self.first) in _GREY or str(getattr(self.first, "format", "")).startswith(_GREY)

    @property
    def is_rectified(self) -> bool:
        """By its name, which ROS's image_proc gives: image_rect, image_rect_color."""
        return any(part.startswith("image_rect") for part in self.name.split("/"))


@dataclass(frozen=True, slots=True, eq=False)
class ChosenTopics:
    """The topics that frames are made of; the calibrations are None where there are none."""

    colour: PictureTopic
    depth: PictureTopic
    colour_info: Topic | None
    depth_info: Topic | None


def chosen_topics(container: Container, choice: TopicChoice) -> ChosenTopics:
    """Find colour, depth and calibrations among a recording's topics.

    Raises:
        UserError: a topic that was asked for is absent, there is no colour or no depth, or there are several cameras.
    """
    pictures = _pictures(container)
    infos = [topic for topic in container.topics if known_type(topic.type) == CAMERA_INFO]
    if not pictures:
        raise UserError(f"{container.path}: {_no_pictures(container)}")
    depths = [each for each in pictures if each.is_depth]
    colours = [each for each in pictures if not each.is_depth]
    colour = _asked(container, pictures, choice.colour, "--color")
    depth = _asked(container, pictures, choice.depth, "--depth")
    if colour is not None and colour.is_depth:
        raise UserError(f"{container.path}: {colour.name} is depth; give a topic of colour as --color")
    if depth is not None and not depth.is_depth:
        what = encoding_of(depth.first)
        raise UserError(f"{container.path}: {depth.name} holds {what}; depth is 16UC1, 32FC1 or compressedDepth")
    if colour is None:
        if not colours:
            raise UserError(f"{container.path} has depth ({_listed(depths)}) but no colour, which signs are read from")
        colour = _best_colour(container, colours, depths)
    if depth is None:
        if not depths:
            raise UserError(f"{container.path} has colour ({_listed(colours)}) but no depth of 16 bits or in metres")
        depth = _best_depth(colour, depths)
    if choice.info is not None:
        info = next((topic for topic in infos if topic.name == choice.info), None)
        if info is None:
            raise UserError(f"{container.path} has no calibration {choice.info}; {_offered(infos)}")
    else:
        info = _info_of(colour.name, infos) or _info_by_frame(container, colour, infos, is_only=len(infos) == 1)
    depth_info = _info_of(depth.name, infos) or _info_by_frame(container, depth, infos, is_only=False)
    return ChosenTopics(colour, depth, info, depth_info)


def first_of(container: Container, topic: Topic) -> Any:
    """The topic's first message that can be decoded; None if none of the first can."""
    for number, message in enumerate(container.messages([topic.name])):
        try:
            return decoded(message)
        except BadMessageError:
            if number + 1 == _TRIES:
                return None
    return None


def _pictures(container: Container) -> list[PictureTopic]:
    topics = [topic for topic in container.topics if known_type(topic.type) in (IMAGE, COMPRESSED)]
    firsts = ((topic, first_of(container, topic)) for topic in topics)
    return [PictureTopic(topic, first) for topic, first in firsts if first is not None]


def _asked(container: Container, pictures: list[PictureTopic], name: str | None, option: str) -> PictureTopic | None:
    if name is None:
        return None
    found = next((each for each in pictures if each.name == name or each.name == f"/{name}"), None)
    if found is None:
        raise UserError(f"{container.path} has no pictures on {name} ({option}); it has {_listed(pictures)}")
    return found


def _best_colour(container: Container, colours: list[PictureTopic], depths: list[PictureTopic]) -> PictureTopic:
    coloured = [each for each in colours if not each.is_grey] or colours
    if depths:
        # Of several cameras, those that have depth.
        near = [max(_common(each.name, depth.name) for depth in depths) for each in coloured]
        coloured = [each for each, score in zip(coloured, near, strict=True) if score == max(near)]
    cameras = {_camera_name(each.name) for each in coloured}
    if len(cameras) > 1:
        raise UserError(f"{container.path} has several cameras: {_listed(coloured)}; choose with --color TOPIC")
    # What needs no decoding and no rectifying first.
    return min(coloured, key=lambda each: (hasattr(each.first, "format"), not each.is_rectified, each.name))


def _best_depth(colour: PictureTopic, depths: list[PictureTopic]) -> PictureTopic:
    return min(
        depths,
        key=lambda each: (
            -_common(colour.name, each.name) if not _is_registered_name(each.name) else -99,
            hasattr(each.first, "format"),
            each.name,
        ),
    )


def _is_registered_name(name: str) -> bool:
    return any(word in name for word in _REGISTERED)


def _info_of(picture: str, infos: Sequence[Topic]) -> Topic | None:
    """The calibration that lies beside the pictures, as ROS puts it."""
    best: tuple[int, Topic] | None = None
    for topic in infos:
        ending = next((ending for ending in _ENDINGS if topic.name.endswith(f"/{ending}")), None)
        if ending is None:
            continue
        base = topic.name.removesuffix(ending)
        if picture.startswith(base) and (best is None or len(base) > best[0]):
            best = len(base), topic
    return None if best is None else best[1]


def _info_by_frame(
    container: Container, picture: PictureTopic, infos: Sequence[Topic], *, is_only: bool
) -> Topic | None:
    """The calibration that is stamped with the pictures' frame, or the only one where that counts."""
    frame = _frame_of(picture.first)
    same = [topic for topic in infos if frame and _frame_of(first_of(container, topic)) == frame]
    chosen = same if same or not is_only else infos
    return chosen[0] if len(chosen) == 1 else None


def _frame_of(message: Any) -> str:
    return str(getattr(getattr(message, "header", None), "frame_id", ""))


def _camera_name(name: str) -> str:
    parts = name.split("/")
    kept = [part for part in parts if not part.startswith("image") and part not in ("compressed", "data", "theora")]
    return "/".join(kept)


def _common(one: str, other: str) -> int:
    count = 0
    for left, right in zip(one.split("/"), other.split("/"), strict=False):
        if left != right:
            break
        count += 1
    return count


def _listed(pictures: Sequence[PictureTopic]) -> str:
    return ", ".join(each.name for each in pictures[:6]) or "none"


def _offered(infos: Sequence[Topic]) -> str:
    return f"it has {', '.join(topic.name for topic in infos[:6])}" if infos else "it has none; give --camera FILE"


def _no_pictures(container: Container) -> str:
    kinds = sorted({topic.type for topic in container.topics})
    if not kinds:
        return "it holds no messages that can be read"
    return f"it holds no pictures that can be read (only {', '.join(kinds[:4])}); record colour, depth and camera_info"
