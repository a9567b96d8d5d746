"""Calibrations that are numbers alone: a matrix, one row of fx fy cx cy and what follows, COLMAP's cameras.txt."""

import re

from lpslam.sources.yaml_tree import Tree

_MOST_ROWS = 8
_LEAST_FOCAL, _MOST_FOCAL = 20.0, 100_000.0  # pixels: below it, a matrix is a pose or an identity
_MOST_UNEVEN = 1.5  # fy by fx: pixels are nearly square
_TERMS = ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
# COLMAP's models, https://colmap.github.io/cameras.html, by the names of their parameters.
_COLMAP = {
    "SIMPLE_PINHOLE": ("f", "cx", "cy"),
    "PINHOLE": ("fx", "fy", "cx", "cy"),
    "SIMPLE_RADIAL": ("f", "cx", "cy", "k1"),
    "RADIAL": ("f", "cx", "cy", "k1", "k2"),
    "OPENCV": ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"),
    "FULL_OPENCV": ("fx", "fy", "cx", "cy", *_TERMS),
}
_NO_PINHOLES = ("OPENCV_FISHEYE", "FOV", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE", "THIN_PRISM_FISHEYE")
_COLMAP_LINE = re.compile(r"\s*\d+\s+([A-Z][A-Z_]+)\s+(\d+)\s+(\d+)((?:\s+[-+.\deE]+)+)\s*")


def tree_of_numbers(text: str, image_size: tuple[int, int] | None) -> Tree | None:
    """The calibration of a text that holds nothing but numbers (and comments); None of any other text."""
    rows = _rows(text)
    if rows is None:
        return None
    for first in range(len(rows)):
        # Four rows first: the last of a 4×4 matrix alone would be terms of distortion.
        for count in (4, 3):
            matrix = matrix_of(_joined(rows[first : first + count]))
            if matrix is not None:
                return _with_rest(matrix, [*rows[:first], *rows[first + count :]])
    if all(len(row) == 1 for row in rows):
        rows = [_joined(rows)]
    if len(rows) == 1:
        return matrix_of(rows[0]) or _tree_of_row(rows[0], image_size)
    return None


def _joined(rows: list[list[float]]) -> list[float]:
    return [number for row in rows for number in row]


def matrix_of(numbers: list[float]) -> Tree | None:
    """The camera of a 3×3, 3×4 or 4×4 matrix, by rows or (3×3) by columns; None if the numbers are none."""
    if len(numbers) == 9 and numbers[1] == numbers[2] == numbers[5] == 0.0:
        numbers = [numbers[row + 3 * column] for row in range(3) for column in range(3)]
    width = {9: 3, 12: 4, 16: 4}.get(len(numbers), 0)
    if not width:
        return None
    rows = [numbers[at : at + width] for at in range(0, len(numbers), width)]
    (fx, _, cx), (below, fy, cy) = rows[0][:3], rows[1][:3]
    is_affine = below == 0.0 and rows[2][:3] == [0.0, 0.0, 1.0] and all(row[3:] in ([], [0.0]) for row in rows[:3])
    if not is_affine or rows[3:] not in ([], [[0.0, 0.0, 0.0, 1.0]]) or not _is_camera(fx, fy, cx, cy):
        return None
    return {"fx": fx, "fy": fy, "cx": cx, "cy": cy}


def tree_of_colmap(text: str, image_size: tuple[int, int] | None) -> Tree | None:
    """The camera of COLMAP's cameras.txt: the only one, or the only one of the images' size; None of other texts."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    found = [_COLMAP_LINE.fullmatch(line) for line in lines[:1000] if len(line) < 1000]
    if not found or len(found) != len(lines):
        return None
    cameras: list[Tree] = []
    for line in found:
        if line is None:
            return None
        model, width, height, values = line.groups()
        names, numbers = _COLMAP.get(model), _floats(values)
        tree: Tree = {"width": int(width), "height": int(height)}
        if names is None and model.startswith(_NO_PINHOLES):
            # Whoever reads the tree refuses it by its model.
            tree |= {"camera_model": model.lower(), "k1": 1.0, "fx": 1.0, "fy": 1.0, "cx": 1.0, "cy": 1.0}
        elif names is None or numbers is None or len(numbers) != len(names):
            return None
        else:
            tree |= dict(zip(names, numbers, strict=True))
        if "f" in tree:
            tree["fx"] = tree["fy"] = tree.pop("f")
        if tree not in cameras:
            cameras.append(tree)
    fitting = [tree for tree in cameras if (tree["width"], tree["height"]) == image_size]
    chosen = cameras if len(cameras) == 1 else fitting
    return chosen[0] if len(chosen) == 1 else None


def _rows(text: str) -> list[list[float]] | None:
    rows: list[list[float]] = []
    for line in text.splitlines():
        bare = re.split(r"#|//|%", line, maxsplit=1)[0]
        if not bare.strip(" \t\r,;[]()"):
            continue
        numbers = _floats(re.sub(r"[,;\[\]()]", " ", bare))
        if numbers is None or len(rows) >= 4 * _MOST_ROWS:
            return None
        rows.append(numbers)
    return rows or None


def _floats(text: str) -> list[float] | None:
    words = text.split()
    if len(words) > 100 or not all(re.fullmatch(r"[-+.\deE]{1,40}", word) for word in words):
        return None
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def _with_rest(tree: Tree, rest: list[list[float]]) -> Tree | None:
    """The tree with what stands around a matrix: a size, terms of distortion."""
    for row in rest:
        if len(row) == 2 and all(value.is_integer() and value > 1 for value in row) and "width" not in tree:
            tree |= {"width": int(row[0]), "height": int(row[1])}
        elif len(row) in (4, 5, 8) and "k1" not in tree:
            tree |= dict(zip(_TERMS, row, strict=False))
        else:
            return None
    return tree


def _tree_of_row(row: list[float], image_size: tuple[int, int] | None) -> Tree | None:
    """Fx fy cx cy, then none, four, five or eight terms and a size, or the size first; None unless one reading fits."""
    readings: list[Tree] = []
    for terms in (0, 4, 5, 8):
        if len(row) == 4 + terms:
            readings.append({**dict(zip(("fx", "fy", "cx", "cy", *_TERMS), row, strict=False))})
        if len(row) == 6 + terms:
            for size, rest in ((row[-2:], row[:-2]), (row[:2], row[2:])):
                if all(value.is_integer() and value > 1 for value in size):
                    named = dict(zip(("fx", "fy", "cx", "cy", *_TERMS), rest, strict=False))
                    readings.append({**named, "width": int(size[0]), "height": int(size[1])})
    fitting = [tree for tree in readings if _is_plausible(tree, image_size)]
    return fitting[0] if len(fitting) == 1 else None


def _is_plausible(tree: Tree, image_size: tuple[int, int] | None) -> bool:
    width, height = (tree["width"], tree["height"]) if "width" in tree else image_size or (0, 0)
    is_inside = not width or (0 < tree["cx"] < width and 0 < tree["cy"] < height)
    is_lens = all(abs(tree.get(name, 0.0)) < 50 for name in _TERMS)
    return is_inside and is_lens and _is_camera(tree["fx"], tree["fy"], tree["cx"], tree["cy"])


def _is_camera(fx: float, fy: float, cx: float, cy: float) -> bool:
    is_focal = all(_LEAST_FOCAL <= value <= _MOST_FOCAL for value in (fx, fy))
    return is_focal and 1 / _MOST_UNEVEN < fy / fx < _MOST_UNEVEN and 0 < cx < 4 * fx and 0 < cy < 4 * fy
