"""Which form a calibration is written in, and the tree of keys that it makes."""

from collections.abc import Callable
from pathlib import Path

from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.calibrations.bare_numbers import tree_of_colmap, tree_of_numbers
from lpslam.sources.calibrations.words import tree_of_words
from lpslam.sources.calibrations.xml_tree import tree_of_xml
from lpslam.sources.yaml_tree import Tree, yaml_tree_of

_MOST_LETTERS = 1 << 18
"""Of a text that is read by its lines or words."""
_WHAT = "calibration"
_STRICT = (".yaml", ".yml", ".json")
"""What such a file says, it says in that form, or not at all."""


def read_tree(path: Path, image_size: tuple[int, int] | None, is_camera: Callable[[Tree], bool]) -> tuple[Tree, bool]:
    """The tree of lower-case keys of a calibration in any form, and whether it was read from words.

    Args:
        path: the file.
        image_size: width and height of the images, to choose among cameras; None where it is not known.
        is_camera: whether a tree states focal lengths.

    Raises:
        UserError: the file cannot be read, or is of no form that is understood.
    """
    text = text_of(path, _WHAT)
    if text.lstrip()[:1] == "<":
        try:
            return tree_of_xml(text.lstrip()), False
        except ValueError as error:
            raise UserError(f"{_WHAT} {path} is no XML that is read: {error}") from error
    is_short = len(text) <= _MOST_LETTERS
    numbers = (tree_of_numbers(text, image_size) or tree_of_colmap(text, image_size)) if is_short else None
    if numbers is not None:
        return numbers, False
    failure: UserError | None = None
    tree: Tree = {}
    try:
        tree = yaml_tree_of(text, path, _WHAT)
    except UserError as error:
        failure = error
    if is_camera(tree):
        return tree, False
    if failure is not None and path.suffix.lower() in _STRICT:
        raise failure
    words = tree_of_words(text, path, image_size) if is_short else {}
    if is_camera(words):
        return words, True
    if failure is not None:
        raise failure
    return tree, False
