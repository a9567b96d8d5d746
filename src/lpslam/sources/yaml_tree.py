"""YAML or JSON as a tree of lower-case keys, whoever wrote it: OpenCV's dialect and dotted keys included."""

import json
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
        return lower(tree)
    # OpenCV writes "%YAML:1.0", which is not YAML, and reads "key:1" without a space.
    text = re.sub(r"\A\s*%YAML.*\n(?:---.*\n)?", "", text)
    text = re.sub(r"(?m)^(\s*[A-Za-z_][\w.]*):(?=[-+.\d\[\"])", r"\1: ", text)
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


def lower(tree: dict[Any, Any]) -> Tree:
    """The tree with lower-case keys; dots in a key lead into mappings, and short lists of mappings are mappings."""
    lowered: Tree = {}
    for key, value in tree.items():
        *sections, name = CAMEL.sub("_", str(key)).lower().split(".")
        inner = lowered
        for section in sections:
            child = inner.get(section)
            if not isinstance(child, dict):
                child = inner[section] = {}
            inner = child
        inner[name] = lower(value) if isinstance(value, dict) else _listed(value)
    return lowered


def _listed(value: Any) -> Any:
    """A list of mappings, or of names and mappings, as a mapping; anything else as it is."""
    if not isinstance(value, list) or not 0 < len(value) <= _MOST_LISTED:
        return value
    if all(isinstance(each, dict) for each in value):
        return lower({str(index): each for index, each in enumerate(value)})
    if all(isinstance(each, list) and len(each) == 2 and isinstance(each[1], dict) for each in value):
        return lower({str(each[0]): each[1] for each in value})
    return value
