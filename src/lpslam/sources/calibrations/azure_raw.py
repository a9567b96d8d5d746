"""Azure Kinect's raw calibration, as its recorder attaches it: in parts of an image, before cutting and binning.

How they become pixels: https://github.com/microsoft/Azure-Kinect-Sensor-SDK (MIT).
"""

from typing import Any

from lpslam.sources.yaml_tree import Tree

_COLOUR, _TOP = "PV0", "calibration_information"
_FULL_ASPECT = 3 / 4
"""Height by width of the colour sensor; of its wider modes rows are cut off at the top and at the bottom."""
# Width and height of a depth mode, to the size of the image that its calibration is in parts of, and what is cut off at
# its left and top.
_DEPTH_MODES = {(320, 288): (512, 512, 96, 90), (640, 576): (1024, 1024, 192, 180)}


def states_azure(tree: Tree) -> bool:
    """Whether a tree of lower-case keys is such a calibration."""
    return bool(_cameras(tree))


def tree_of_azure(tree: Tree, image_size: tuple[int, int] | None) -> Tree | None:
    """The colour camera under the usual keys; None of any other calibration, or where the images' size is not known."""
    camera = next((each for place, each in _cameras(tree).items() if place.endswith(_COLOUR)), None)
    if camera is None or image_size is None:
        return None
    try:
        matrix, terms = azure_lens(camera["intrinsics"]["model_parameters"], image_size, is_depth=False)
    except (KeyError, TypeError, ValueError):
        return None
    named = dict(zip(("fx", "fy", "cx", "cy"), matrix, strict=True))
    return {**named, "distortion": terms, "width": image_size[0], "height": image_size[1], "depth_unit": "mm"}


def azure_lens(
    parameters: Any, size: tuple[int, int], *, is_depth: bool
) -> tuple[tuple[float, float, float, float], list[float]]:
    """Pixels fx, fy, cx, cy and the terms k1, k2, p1, p2, k3 to k6 of a camera's mode.

    Args:
        parameters: its `ModelParameters`.
        size: width and height of the mode, pixels.
        is_depth: whether it is the depth camera.

    Raises:
        ValueError, TypeError: they are not fourteen numbers.
    """
    cx, cy, fx, fy, k1, k2, k3, k4, k5, k6, _, _, p2, p1 = (float(value) for value in list(parameters)[:14])
    if is_depth:
        width, height, left, top = _DEPTH_MODES.get(size, (*size, 0, 0))
    else:
        width, height, left = size[0], max(round(size[0] * _FULL_ASPECT), size[1]), 0
        top = (height - size[1]) // 2
    # Its pixels' corners are whole numbers; here their centres are.
    matrix = fx * width, fy * height, cx * width - left - 0.5, cy * height - top - 0.5
    return matrix, [k1, k2, p1, p2, k3, k4, k5, k6]


def _cameras(tree: Tree) -> dict[str, Any]:
    """By place."""
    around = tree.get(_TOP)
    listed = around.get("cameras") if isinstance(around, dict) else None
    cameras = [each for each in listed.values() if isinstance(each, dict)] if isinstance(listed, dict) else []
    return {str(each.get("location")): each for each in cameras}
