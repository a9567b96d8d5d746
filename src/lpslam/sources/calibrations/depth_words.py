"""How long a raw unit of depth is, as lines or sentences say it."""

import re

from lpslam.sources.calibrations.depth_units import DEPTH_SCALE, in_a_metre, states_units
from lpslam.sources.yaml_tree import Tree

_KEY = re.compile(r"[\s|*-]{0,20}([A-Za-z][\w .()-]{0,60}?)[\s|]{0,20}[=:|\t][\s|=:]{0,20}([^|]{1,80}?)[\s|]*")
_A_NUMBER = r"(\d{1,12}(?:\.\d{1,12})?(?:e[-+]?\d{1,2})?)"
_A_UNIT = r"(?:raw |depth )?(?:units?|steps?|counts?|values?|levels?|increments?|lsb|ticks?|digits?)"
_METRE = r"(?:1 |one |a |the )?(?:metres?|meters?|m)\b"
_PER_METRE = (
    rf"{_A_NUMBER} (?:{_A_UNIT} )?(?:per|=|to|in|is|are|make|equals?|for) {_METRE}",
    rf"(?:divided?|division|/) (?:by )?{_A_NUMBER}[^.\n]{{0,30}}\b(?:metres?|meters?)\b",
    rf"\b(?:metres?|meters?|m) = [a-z_ ]{{0,30}} ?/ ?{_A_NUMBER}",
)
_LENGTH = r"(millimet\w{1,4}|mm|centimet\w{1,4}|cm|micromet\w{1,4}|um|µm|met(?:re|er)s?|m)\b"
_ONE_UNIT = (
    rf"\b(?:1|one|a|each|every) {_A_UNIT} (?:is|=|equals?|means|of|stands for) (?:{_A_NUMBER}|one|a)? ?{_LENGTH}"
)
_IN_MILLIMETRES = r"\b(?:depths?|distances?)\b[^.\n]{0,120}\b(?:mm|millimet(?:re|er)s?)\b"


def depth_of_lines(sections: list[tuple[str, list[str]]], text: str) -> Tree:
    """The keys that state units of depth, as `sources.calibration` reads them; else what sentences say.

    Args:
        sections: names of sections in lower case, and their lines.
        text: the whole text.
    """
    tree: Tree = {}
    for section, lines in sections:
        for line in lines:
            found = _KEY.fullmatch(line) if len(line) < 200 else None
            if found is None:
                continue
            key, value = re.sub(r"[\W_]+", "_", found.group(1).strip().lower()).strip("_"), found.group(2).strip()
            if states_units(key) and ("depth" in key or "depth" in section):
                tree[key if "depth" in key else f"depth_{key}"] = value
    if tree:
        return tree
    scale = units_in_words(text)
    return {} if scale is None else {DEPTH_SCALE: scale}


def units_in_words(text: str) -> float | None:
    """Raw units of depth in a metre, where sentences state exactly one number; None otherwise."""
    plain = " ".join(text.lower().split())
    scales = {float(number) for form in _PER_METRE for number in re.findall(form, plain)}
    for number, unit in re.findall(_ONE_UNIT, plain):
        length, size = in_a_metre(unit), float(number) if number else 1.0
        scales |= {length / size} if length and size else set()
    if not scales and re.search(_IN_MILLIMETRES, plain):
        scales = {1000.0}
    scale = scales.pop() if len(scales) == 1 else 0.0
    return scale if scale > 0 else None
