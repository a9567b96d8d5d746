"""How depth is encoded, as the texts and the names of a recording state it."""

import re
from collections.abc import Sequence
from pathlib import Path

from lpslam.errors import UserError
from lpslam.regular_files import text_of
from lpslam.sources.depths.encoding import DepthEncoding

_LONGEST = 1 << 16
_MOST_TEXTS = 100
_NUMBER = r"(\d{1,9}(?:\.\d{1,9})?)"
_BITS = re.compile(r"\b(?:low(?:er|est)?|least[- ]significant|bottom) (\d{1,2}) bits?\b")
_MASK = re.compile(r"\bmask\w{0,3}(?: \w+){0,2}[ :=]{1,3}0x([0-9a-f]{1,4})\b")
_INVERSE = re.compile(
    r"\binv(?:erse)?[ _-]?(?:depth|distance|range)\w*|\bdepth[ _-]?inverse\b|\binverse[ _]of[ _](?:the )?depth"
)
_OF_INVERSE = (
    re.compile(rf"\b(?:inverse|inv)_?depth_?(?:scale|factor|scaling)\b[\"' :=]{{1,6}}{_NUMBER}"),
    re.compile(rf"/ ?{_NUMBER} ?(?:=|is|gives) (?:the )?inverse"),
    re.compile(rf"\b(?:depth|z|metres?|meters?|m) ?= ?{_NUMBER} ?/ ?(?:\w+ )?(?:value|raw|pixel|v|d)\b"),
)
_CHANNELS = {"r": 0, "red": 0, "g": 1, "green": 1, "b": 2, "blue": 2}
_CHANNEL = r"(?:red|green|blue|r|g|b)"
_FACTORS = r"(?:\d{1,8}(?: ?[*^] ?\d{1,8}){0,3})"
_TERM = rf"(?:{_FACTORS} ?\* ?{_CHANNEL}|{_CHANNEL}(?: ?\* ?{_FACTORS})?)"
_SUM = re.compile(rf"(?<![a-z0-9]){_TERM}(?: ?\+ ?{_TERM}){{1,2}}(?![a-z0-9])")
_DIVISOR = re.compile(r"[ )]{0,4}/ ?\(? ?(\d{1,9}(?: ?[*^] ?\d{1,9}){0,3})( ?- ?1(?!\d))?")
_TIMES = re.compile(rf"{_NUMBER} ?\* ?normali[sz]ed|normali[sz]ed(?:_depth)? ?\* ?{_NUMBER}|\) ?\* ?{_NUMBER}")
_BASELINE = re.compile(
    r"\bbaseline[ _]?(?:in[ _])?(mm|cm|m)?\b[\"' ]{0,3}[:=][\"' ]{0,3}(\d{1,6}(?:\.\d{1,9})?) ?(mm|cm|m)?\b"
)
_BASELINE_UNIT = re.compile(r"\bbaseline(?: \w+){0,3} in (mm|millimet|cm|centimet|m)")
_OFFSET = re.compile(r"\bdoffs?[\"' ]{0,3}[:=][\"' ]{0,3}(-?\d{1,6}(?:\.\d{1,9})?)")
_DISPARITY_SCALE = re.compile(
    rf"\bdisparity(?: in pixels)? ?(?:=|is) ?(?:the )?(?:raw |pixel )?(?:value|number)? ?/ ?{_NUMBER}"
)
_METRES = {"mm": 1e-3, "millimet": 1e-3, "cm": 1e-2, "centimet": 1e-2, "m": 1.0}
_LONGEST_BASELINE, _SHORTEST_IN_MM = 2.0, 10.0
"""Metres between the eyes of a stereo camera at most; a number from the second on is of millimetres."""


def stated_encoding(files: Sequence[Path], name: str) -> DepthEncoding | None:
    """The encoding of depth that texts of a recording state; None where they state none.

    Args:
        files: texts beside the pictures.
        name: of the depth pictures, with the folder in which they lie.

    Raises:
        UserError: it is called inverse, and no number says of what.
    """
    text = _plain(files)
    packed = _packing(text)
    if packed is not None:
        return packed
    if _INVERSE.search(name.lower()) or _INVERSE.search(text):
        numbers = {float(found) for pattern in _OF_INVERSE for found in pattern.findall(text)}
        if len(numbers) == 1:
            return DepthEncoding(numerator=numbers.pop())
        raise UserError(
            f"{name} and the like are called inverse depth, and nothing states of which unit; state it in a "
            "text (“inverse_depth_scale: 16384”: the number by which a value is divided to be 1/m), or write depth"
        )
    bits = {int(found) for found in _BITS.findall(text) if 8 <= int(found) < 16}
    masks = {int(found, 16) for found in _MASK.findall(text)}
    bits |= {mask.bit_length() for mask in masks if mask and not mask & (mask + 1) and 8 <= mask.bit_length() < 16}
    return DepthEncoding(kept_bits=bits.pop()) if len(bits) == 1 else None


def stated_disparity(files: Sequence[Path], focal: float, name: str, *, is_float: bool) -> DepthEncoding:
    """The encoding of disparity in pixels, by the baseline that texts state.

    Raises:
        UserError: they state none, or not in which unit the numbers are.
    """
    text = _plain(files)
    remedy = (
        "write depth instead: focal length in pixels times baseline in metres, divided by the disparity in pixels; or "
        "state it in a text beside them (“baseline_m: 0.12”"
    )
    baselines = set()
    unit_in_words = _BASELINE_UNIT.search(text)
    for before, number, behind in _BASELINE.findall(text):
        unit = before or behind or (unit_in_words[1] if unit_in_words else "")
        value = float(number)
        if unit:
            baselines.add(value * _METRES[unit])
        elif 0 < value < _LONGEST_BASELINE:
            baselines.add(value)
        elif value >= _SHORTEST_IN_MM:
            baselines.add(value * _METRES["mm"])
    if len(baselines) != 1 or not 0 < max(baselines) < _LONGEST_BASELINE:
        raise UserError(f"{name} and the like are called disparity, and no single baseline is stated; {remedy})")
    scales = {float(number) for number in _DISPARITY_SCALE.findall(text)}
    if not is_float and len(scales) != 1:
        raise UserError(
            f"{name} and the like are disparity in whole numbers, and nothing states how many make a pixel; {remedy}, "
            "“disparity = value / 256”)"
        )
    scale = scales.pop() if scales else 1.0
    offsets = {float(number) for number in _OFFSET.findall(text)} or {0.0}
    if len(offsets) != 1:
        raise UserError(f"{name}: doffs is stated with more than one number; {remedy})")
    return DepthEncoding(numerator=focal * baselines.pop() * scale, offset=offsets.pop() * scale)


def _plain(files: Sequence[Path]) -> str:
    """The short texts, in lower case and with single spaces."""
    found = []
    for path in files[:_MOST_TEXTS]:
        try:
            if path.stat().st_size <= _LONGEST:
                found.append(text_of(path))
        except (UserError, OSError):
            continue
    return " . ".join(" ".join(text.lower().replace("×", "*").split()) for text in found)


def _packing(text: str) -> DepthEncoding | None:
    """What a sum of channels states, and the metres that it is divided and multiplied to."""
    found = {match.group(): match for match in _SUM.finditer(text)}
    read = [(match, weights) for match in found.values() if (weights := _weights(match.group())) is not None]
    if len({weights for _, weights in read}) != 1:
        return None
    match, weights = read[0]
    after = text[match.end() : match.end() + 200]
    divisor, times = _DIVISOR.match(after), _TIMES.search(after)
    if divisor is None or times is None:
        return DepthEncoding(weights=weights)
    whole = _product(divisor[1]) - (1 if divisor[2] else 0)
    most = float(next(group for group in times.groups() if group))
    return DepthEncoding(weights=weights, scale=whole / most) if whole > 0 and most > 0 else None


def _weights(text: str) -> tuple[float, ...] | None:
    weights = [0.0, 0.0, 0.0]
    for term in text.split("+"):
        factors = [part.strip() for part in term.split("*")]
        channel = [part for part in factors if part in _CHANNELS]
        rest = [part for part in factors if part not in _CHANNELS]
        if len(channel) != 1 or weights[_CHANNELS[channel[0]]]:
            return None
        weights[_CHANNELS[channel[0]]] = _product("*".join(rest)) if rest else 1.0
    # Bytes of one number: each counts as much as all below it and one more.
    return tuple(weights) if sorted(each for each in weights if each) in ([1.0, 256.0], [1.0, 256.0, 65536.0]) else None


def _product(text: str) -> float:
    product = 1.0
    for part in text.split("*"):
        base, *powers = (float(number) for number in part.replace(" ", "").split("^"))
        product *= base ** min(powers[0], 8.0) if powers else base
    return product
