"""How long a raw unit of depth is, by whichever key says so: `depth_scale`, `DepthMapFactor`, “mm per unit”."""

import re
from collections.abc import Sequence

from lpslam.sources.yaml_tree import Tree

DEPTH_SCALE, DEPTH_DISPLACEMENT = "depth_scale", "depth_displacement"
_OF_DEPTH, _OF_UNITS = "depth", ("scale", "scaling", "factor", "unit", "permet", "divisor")
_IN_METRES = {"mm": 1e3, "milli": 1e3, "cm": 1e2, "centi": 1e2, "um": 1e6, "µm": 1e6, "micro": 1e6, "m": 1.0}
_LENGTH_OF_ONE = re.compile(
    r"(mm|milli|cm|centi|um|micro|met)[a-z]{0,10}per(?:raw)?(?:unit|step|count|value|level|lsb)"
)


def depth_unit(scopes: Sequence[Tree], depth: object) -> object:
    """What is stated of the raw units of depth: a number of them in a metre, or metres in one; None without.

    Args:
        scopes: mappings of a calibration, the camera's own first.
        depth: the mapping that is called so, if there is one.
    """
    stated: Tree = {}
    for scope in reversed(scopes):
        stated |= {key: value for key, value in scope.items() if states_depth_unit(key, value)}
    if not stated and isinstance(depth, dict):
        stated = {key: value for key, value in depth.items() if states_units(key) and not isinstance(value, dict)}
    if not stated:
        return None
    # The plainest name says it: others may be its spread or its age.
    key = min(stated, key=len)
    value, found = stated[key], _LENGTH_OF_ONE.search(_letters(key))
    if isinstance(value, str):
        value = _of_words(value)
    if found is None or isinstance(value, bool) or not isinstance(value, (int, float)) or not value:
        return value
    length = in_a_metre(found[1])
    return value if length is None else length / value


def states_depth_unit(key: str, value: object = None) -> bool:
    """Whether a key is about the raw units of depth."""
    return _OF_DEPTH in key and key != DEPTH_DISPLACEMENT and states_units(key) and not isinstance(value, (dict, list))


def in_a_metre(length: str) -> float | None:
    """How many of a length, by how its name begins, are a metre; None of what is no length."""
    return next((_IN_METRES[name] for name in _IN_METRES if length.startswith(name)), None)


def states_units(key: str) -> bool:
    """Whether a key says what a raw unit is, of depth or of anything else."""
    return any(word in _letters(key) for word in _OF_UNITS) or _LENGTH_OF_ONE.search(_letters(key)) is not None


def _of_words(text: str) -> object:
    """“mm”, “0.1 mm” (so long is a raw unit), “1000 per metre”; the text itself where it says nothing of the kind."""
    words = re.findall(r"[a-z]+|[-+.\d]+(?:e[-+]?\d+)?", text.lower())
    lengths = [in_a_metre(word) for word in words[:2]]
    try:
        number = float(words[0]) if words and not words[0][0].isalpha() else None
    except ValueError:
        return text
    if number is None:
        return text if not lengths or lengths[0] is None else lengths[0]
    if len(words) == 1 or lengths[1] is None or not number:
        return number
    return lengths[1] / number


def _letters(key: str) -> str:
    return re.sub(r"[_\- ]", "", key)
