"""Values of a calibration's keys: the first that is there, numbers, and lists of them."""

from pathlib import Path
from typing import Any

from lpslam.errors import UserError
from lpslam.sources.yaml_tree import Tree


def found_in(scopes: tuple[Tree, ...], keys: tuple[str, ...]) -> Any:
    """The first value under any of the keys, scope by scope; None where there is none."""
    for scope in scopes:
        for key in keys:
            if scope.get(key) is not None:
                return scope[key]
    return None


def number_of(value: object, name: str, path: Path) -> float:
    """A number, or a `UserError` that names the key and the file."""
    try:
        if isinstance(value, bool):
            raise ValueError
        return float(str(value))
    except ValueError as error:
        raise UserError(f"calibration {path}: {name} is {value!r}; it must be a number") from error


def numbers_of(value: object) -> list[float] | None:
    """The numbers of a flat or nested list, or of ROS's and OpenCV's {rows, cols, data}; None if there is no list."""
    if isinstance(value, dict):
        value = value.get("data", value.get("values"))
    if not isinstance(value, list):
        return None
    flat = [item for row in value for item in (row if isinstance(row, list) else [row])]
    try:
        return [float(str(item)) for item in flat]
    except ValueError:
        return None
