"""Calibrations in lines of names and numbers, in tables, or in plain words.

A statement is a run of numbers and the phrase before it. What the phrase names is known by its words; a quantity that
is stated twice with different numbers is refused, never guessed.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lpslam.errors import UserError
from lpslam.sources.calibrations.bare_numbers import matrix_of
from lpslam.sources.calibrations.depth_words import depth_of_lines
from lpslam.sources.yaml_tree import CAMEL, Tree

_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d{1,30}(?:\.\d{0,30})?|\.\d{1,30})(?:[eE][-+]?\d{1,3})?")
_WORD = re.compile(r"[a-z]+\d?")
_TERMS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
_NAMES = {name: name for name in ("fx", "fy", "cx", "cy", "width", "height", *_TERMS)} | {
    **{"flx": "fx", "fly": "fy", "fu": "fx", "fv": "fy"},
    **{"ppx": "cx", "ppy": "cy", "pu": "cx", "pv": "cy", "u0": "cx", "v0": "cy"},
}
_AXES = {
    **{"x": "x", "u": "x", "horizontal": "x", "horizontally": "x", "h": "x"},
    **{"y": "y", "v": "y", "vertical": "y", "vertically": "y"},
}
# What may stand between the numbers of one statement, and after the name of a quantity.
_FILLERS = frozenset(
    """px pixel pixels pix in and by is are at the for along axis direction deg degree degrees was to of about
    respectively value values equals approximately image""".split()  # noqa: SIM905
) | set(_AXES)
_ABOUT = {
    "focal": ("fx", "fy"), "principal": ("cx", "cy"), "optical": ("cx", "cy"), "centre": ("cx", "cy"),
    "center": ("cx", "cy"), "pp": ("cx", "cy"), "size": ("width", "height"), "resolution": ("width", "height"),
    "calibrated": ("width", "height"), "dimensions": ("width", "height"),
    "fov": ("horizontal_fov", "vertical_fov"), "view": ("horizontal_fov", "vertical_fov"), "fps": ("fps",),
    "rate": ("fps",), "distortion": (), "coeffs": (), "coefficients": (), "dist": (), "radial": ("k1", "k2", "k3"),
    "tangential": ("p1", "p2"), "matrix": (), "intrinsics": (), "intrinsic": (), "k": (), "cam0": (),
}  # fmt: skip
# Words that say that a number is of something else.
_ELSEWHERE = frozenset(
    """depth infrared ir imu baseline rotation translation extrinsic extrinsics projection rectification error rms
    sensor std deviation uncertainty tolerance map pitch resampled cropped""".split()  # noqa: SIM905
)
_LENGTHS = re.compile(r"\s*(?:mm|millimet|cm\b|um\b|µm|%)")
_SECTION = re.compile(
    r"\s*(?:\[([A-Za-z][^\]=]{0,80})\]|((?:intrinsic|extrinsic)s?\b.{0,200}|[^:=\d|]{2,80}:))\s*", re.I
)
_HEADING = re.compile(r"#{1,6}\s+(.{1,200})")
_COLOUR = re.compile(r"colou?r|rgb|left|cam0")
_OTHER = re.compile(r"depth|\bir\b|infra|imu|right|extrinsic|gyro|accel|fish|pose")
_FOCAL = ("fx", "fy", "horizontal_fov", "vertical_fov", "diagonal_fov")


@dataclass(frozen=True, slots=True)
class _Statement:
    """Numbers, the words before them, and the axes that are named before, between and after them, in order."""

    words: list[str]
    numbers: list[float]
    axes: list[str]


@dataclass(slots=True)
class _Section:
    name: str
    lines: list[str]


def tree_of_words(text: str, path: Path, image_size: tuple[int, int] | None) -> Tree:
    """What lines or sentences state of a camera, under the usual keys; empty where they state no focal length.

    Raises:
        UserError: a quantity is stated twice with different numbers.
    """
    is_markdown = path.suffix.lower() in (".md", ".rst", "") or path.stem.lower().startswith("readme")
    sections = _sections(text, is_markdown)
    chosen = _chosen(sections, path, image_size)
    if not any(name in chosen for name in _FOCAL):
        # A header of names may be a comment above its numbers.
        chosen = _stated(_paragraphs(re.sub(r"(?m)^\s*[#;%/]+", " ", text).splitlines()), path)
    if not any(name in chosen for name in _FOCAL):
        return {}
    return chosen | depth_of_lines([(section.name, section.lines) for section in sections], text)


def _sections(text: str, is_markdown: bool) -> list[_Section]:
    sections = [_Section("", [])]
    open_brackets = 0
    for line in text.splitlines():
        heading = _HEADING.fullmatch(line.strip()) if is_markdown else None
        bare = re.sub(r"(?:^|\s)(?:#|//|%).*|^\s*;.*", "", line[:2000])
        found = heading or (None if open_brackets > 0 else _SECTION.fullmatch(bare))
        if found is not None:
            sections.append(_Section(next(group for group in found.groups() if group).lower(), []))
        elif open_brackets > 0:
            sections[-1].lines[-1] += " " + bare
        else:
            sections[-1].lines.append(bare)
        if found is None:
            open_brackets = max(0, open_brackets + bare.count("[") - bare.count("]"))
    return sections


def _chosen(sections: list[_Section], path: Path, image_size: tuple[int, int] | None) -> Tree:
    """What the colour camera's section states, and what sections without a camera state."""
    found = [(section.name, _of_section(section, path)) for section in sections if not _is_of_another(section.name)]
    cameras = [(name, tree) for name, tree in found if any(key in tree for key in _FOCAL)]
    best = [(name, tree) for name, tree in cameras if _COLOUR.search(name)] or cameras
    fitting = [(name, tree) for name, tree in best if (tree.get("width"), tree.get("height")) == image_size]
    kept = fitting[:1] if len(best) > 1 and fitting else best
    rest = [tree for name, tree in found if (name, tree) not in cameras]
    together: Tree = {}
    for tree in [*(tree for _, tree in kept), *rest]:
        for key, value in tree.items():
            _put(together, key, value, path)
    return together


def _is_of_another(name: str) -> bool:
    return bool(_OTHER.search(name)) and not (_COLOUR.search(name) and "extrinsic" not in name)


def _of_section(section: _Section, path: Path) -> Tree:
    """By lines, or by sentences where these state more."""
    by_lines = _stated(section.lines, path)
    try:
        by_sentences = _stated(_paragraphs(section.lines), path)
    except UserError:
        if len(by_lines) > 3:
            return by_lines
        raise
    return by_sentences if len(by_sentences) > len(by_lines) else by_lines


def _paragraphs(lines: list[str]) -> list[str]:
    joined: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            joined[-1].append(line)
        elif joined[-1]:
            joined.append([])
    return [" ".join(words) for words in joined]


def _stated(lines: list[str], path: Path) -> Tree:
    tree: Tree = {}
    for line in lines:
        for statement in _statements(line):
            for key, value in _quantities(statement).items():
                _put(tree, key, value, path)
    return tree


def _put(tree: Tree, key: str, value: float, path: Path) -> None:
    if tree.setdefault(key, value) != value:
        raise UserError(
            f"calibration {path}: it states {key} as {tree[key]:g} and as {value:g}; write which one holds, as one "
            "`key: value` a line"
        )


def _statements(line: str) -> Iterator[_Statement]:
    text = re.sub(r"(?<=\d)\s?[x×X*]\s?(?=\d)", " , ", CAMEL.sub(" ", line).lower())
    text = re.sub(r"\b(f|c|fl)_([xyuv])\b", r"\1\2", text)
    end, words, numbers, axes = 0, [""], list[float](), list[str]()
    for found in _NUMBER.finditer(text):
        gap = text[end : found.start()]
        between = _words(gap)
        is_more = bool(numbers) and all(word in _FILLERS for word in between) and not re.search(r"[.!?|]\s+\w|[|]", gap)
        if not is_more:
            if numbers:
                yield _Statement(words, numbers, axes + _tail_axes(gap))
            words, numbers = _words(re.split(r"[.!?]\s", gap)[-1]), []
            axes = [_AXES[word] for word in words[-3:] if word in _AXES]
        else:
            axes = axes + [_AXES[word] for word in between if word in _AXES]
        end = found.end()
        if _LENGTHS.match(text, end):
            words = [*words, "tolerance"]  # no pixels
        numbers.append(float(found.group()))
    if numbers:
        yield _Statement(words, numbers, axes + _tail_axes(text[end:]))


def _tail_axes(gap: str) -> list[str]:
    """Axes that stand after a number: “pixels in x”."""
    tail = re.match(r"\s*(?:px|pixels?)?\s*(?:in|along)\s+(?:the\s+)?(\w+)", gap)
    return [_AXES[tail.group(1)]] if tail and tail.group(1) in _AXES else []


def _words(phrase: str) -> list[str]:
    return _WORD.findall(phrase.replace("_", " "))


def _quantities(statement: _Statement) -> dict[str, float]:
    words, numbers = statement.words, statement.numbers
    if _ELSEWHERE.intersection(words):
        return {}
    # Names that stand last, but for words that say nothing: “fx, fy [px]”.
    last = next((at for at in range(len(words), 0, -1) if words[at - 1] not in _FILLERS), 0)
    named: list[str] = []
    while last and (words[last - 1] in _NAMES or words[last - 1] == "and"):
        last -= 1
        if words[last] in _NAMES:
            named.insert(0, _NAMES[words[last]])
    if named:
        return dict(zip(named, numbers, strict=True)) if len(named) == len(numbers) else {}
    kinds = [word for word in ("radial", "tangential") if word in words]
    about = kinds[0] if len(kinds) == 1 else next((word for word in reversed(words) if word in _ABOUT), None)
    return {} if about is None else _of_kind(about, statement)


def _of_kind(about: str, statement: _Statement) -> dict[str, float]:
    numbers, axes, names = statement.numbers, statement.axes, _ABOUT[about]
    if about in ("radial", "tangential"):
        return dict(zip(names, numbers, strict=False)) if 2 <= len(numbers) <= len(names) else {}
    if not names:
        matrix = matrix_of(numbers)
        if matrix is not None:
            return {key: float(value) for key, value in matrix.items()}
        is_lens = about in ("distortion", "coeffs", "coefficients", "dist") and len(numbers) in (4, 5, 8)
        return dict(zip(_TERMS, numbers, strict=False)) if is_lens else {}
    if len(numbers) == 2 and len(names) == 2:
        first, second = numbers if axes[:2] != ["y", "x"] else reversed(numbers)
        return {names[0]: first, names[1]: second}
    if len(numbers) != 1 or (about == "view" and "field" not in statement.words):
        return {}
    if axes:
        return {names["xy".index(axes[0])]: numbers[0]} if len(names) == 2 else {}
    if "diagonal" in statement.words and names[0] == "horizontal_fov":
        return {"diagonal_fov": numbers[0]}
    if names == ("fx", "fy"):
        return dict.fromkeys(names, numbers[0])
    return {names[0]: numbers[0]} if len(names) == 1 else {}
