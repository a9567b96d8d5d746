"""YAML or JSON as a tree of lower-case keys, whoever wrote it: OpenCV's dialect and dotted keys included."""

import json
import math
import re
from pathlib import Path
from typing import Any

import yaml

from lpslam.config.hostile_yaml import yaml_of
from lpslam.errors import UserError

Tree = dict[str, Any]


class _LenientLoader(yaml.SafeLoader):
    """A safe loader that reads OpenCV's matrices as plain mappings and drops tags that it does not know."""


def _construct_untagged(loader: _LenientLoader, _: str, node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    return node.value


_LenientLoader.add_multi_constructor("", _construct_untagged)


CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")
"""Where a word begins within a name."""
_MOST_LISTED = 64
"""Cameras and the like; a longer list is one of frames."""
_DEEPEST = 50
"""Mappings within mappings, those that dots in a key lead into included; no calibration has as many."""
_LARGEST = 1e300
"""A whole number beyond it is infinite: what computes with it has no more room."""


def yaml_tree_of(text: str, path: Path, what: str) -> Tree:
    """The tree of a YAML or JSON text whose top is a mapping; `Camera.fx` becomes fx under camera.

    Args:
        text: what the file holds.
        path: the file.
        what: what the file is, as it stands in errors ("calibration").

    Raises:
        UserError: the text is no YAML mapping.
    """
    if (tree := _json_of(text)) is not None:
        try:
            return lower(tree)
        except ValueError as error:
            raise UserError(f"{what} {path} cannot be read: {error}") from error
    # OpenCV writes "%YAML:1.0", which is not YAML, and reads "key:1" without a space.
    text = re.sub(r"\A\s*%YAML.*\n(?:---.*\n)?", "", text)
    text = re.sub(r"(?m)^([ \t]*[A-Za-z_][\w.]*):(?=[-+.\d\[\"])", r"\1: ", text)
    try:
        tree = yaml_of(text, _LenientLoader)
        if isinstance(tree, dict):
            return lower(tree)
    except (ValueError, RecursionError) as error:
        raise UserError(f"{what} {path} is not YAML: {' '.join(str(error).split())[:200]}") from error
    raise UserError(f"{what} {path} holds no keys; write one `key: value` a line")


def _json_of(text: str) -> Tree | None:
    """The mapping of a JSON text, indented by tabs too, as YAML may not be; None of any other text."""
    try:
        tree = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return tree if isinstance(tree, dict) else None


def lower(tree: dict[Any, Any], depth: int = 0) -> Tree:
    """The tree with lower-case keys; dots in a key lead into mappings, and short lists of mappings are mappings.

    Raises:
        ValueError: it is nested too deeply.
    """
    lowered: Tree = {}
    for key, value in tree.items():
        *sections, name = CAMEL.sub("_", str(key)).lower().split(".")
        level = depth + len(sections) + 1
        if level > _DEEPEST:
            raise ValueError("it is nested too deeply")
        inner = lowered
        for section in sections:
            child = inner.get(section)
            if not isinstance(child, dict):
                child = inner[section] = {}
            inner = child
        inner[name] = _lowered(value, level)
    return lowered


def _lowered(value: Any, depth: int) -> Any:
    """A mapping in lower case, and what stands for one: a short list of mappings, or of names and mappings."""
    if isinstance(value, dict):
        return lower(value, depth)
    if isinstance(value, int) and abs(value) > _LARGEST:
        return math.inf if value > 0 else -math.inf
    if not isinstance(value, list):
        return value
    if depth > _DEEPEST:
        raise ValueError("it is nested too deeply")
    if 0 < len(value) <= _MOST_LISTED:
        if all(isinstance(each, dict) for each in value):
            return lower({str(index): each for index, each in enumerate(value)}, depth)
        if all(isinstance(each, list) and len(each) == 2 and isinstance(each[1], dict) for each in value):
            return lower({str(each[0]): each[1] for each in value}, depth)
    return [_lowered(each, depth + 1) for each in value]
