import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lpslam.errors import UserError
from lpslam.sources.calibration import Calibration, read_calibration

FLAT = """
fx: 535.4
fy: 539.2
cx: 320.1
cy: 247.6
width: 640
height: 480
depth_scale: 5000
distortion: [0.1, -0.2, 0.001, 0.002, 0.3]
fps: 25
"""

SAME = {
    "flat": FLAT,
    "nested": "camera:\n" + "\n".join("  " + line for line in FLAT.strip().splitlines()),
    "ros": """
image_width: 640
image_height: 480
camera_name: head
camera_matrix: {rows: 3, cols: 3, data: [535.4, 0, 320.1, 0, 539.2, 247.6, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, -0.2, 0.001, 0.002, 0.3]}
projection_matrix: {rows: 3, cols: 4, data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}
depth_scale: 0.0002
fps: 25
""",
    "json, indented by tabs": """{
\t"width": 640,
\t"height": 480,
\t"fx": 535.4, "fy": 539.2, "cx": 320.1, "cy": 247.6,
\t"distortion": [0.1, -0.2, 0.001, 0.002, 0.3],
\t"depth_scale": 5000, "fps": 25
}""",
    "open3d": """{"width": 640, "height": 480, "depth_scale": 5000, "fps": 25,
"intrinsic_matrix": [535.4, 0, 0, 0, 539.2, 0, 320.1, 247.6, 1], "distortion": [0.1, -0.2, 0.001, 0.002, 0.3]}""",
    "kalibr": """
cam0:
  camera_model: pinhole
  distortion_coeffs: [0.1, -0.2, 0.001, 0.002, 0.3]
  distortion_model: radtan
  intrinsics: [535.4, 539.2, 320.1, 247.6]
  resolution: [640, 480]
  rostopic: /camera/color
cam1: {intrinsics: [1, 1, 1, 1], resolution: [2, 2]}
depth_scale: 5000
fps: 25
""",
    "matrix": """
K: [[535.4, 0, 320.1], [0, 539.2, 247.6], [0, 0, 1]]
D: [0.1, -0.2, 0.001, 0.002, 0.3]
image_size: [640, 480]
depth_scale: 5e3
fps: 25
""",
    "dotted": """%YAML:1.0
---
# Camera Parameters
Camera.type: "PinHole"
Camera.fx: 535.4
Camera.fy:539.2
Camera.cx: 320.1
Camera.cy: 247.6
Camera.k1: 0.1
Camera.k2: -0.2
Camera.p1: 0.001
Camera.p2: 0.002
Camera.k3: 0.3
Camera.width: 640
Camera.height: 480
Camera.fps: 25.0
Camera.bf: 40.0
DepthMapFactor: 5000.0
ORBextractor.nFeatures: 1000
""",
    "dotted, newer": """%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: 535.4
Camera1.fy: 539.2
Camera1.cx: 320.1
Camera1.cy: 247.6
Camera1.k1: 0.1
Camera1.k2: -0.2
Camera1.p1: 0.001
Camera1.p2: 0.002
Camera1.k3: 0.3
Camera.width: 640
Camera.height: 480
Camera.fps: 25
RGBD.DepthMapFactor: 5000.0
""",
    "opencv": """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 535.4, 0., 320.1, 0., 539.2, 247.6, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0.1, -0.2, 0.001, 0.002, 0.3 ]
depth_scale: 5000
fps: 25
""",
    "colour beside depth": """
depth: {fx: 1, fy: 1, cx: 1, cy: 1, width: 10, height: 10, scale: 5000}
color:
  intrinsics: {fx: 535.4, fy: 539.2, cx: 320.1, cy: 247.6}
  distortion: {k1: 0.1, k2: -0.2, p1: 0.001, p2: 0.002, k3: 0.3}
width: 640
height: 480
fps: 25
""",
}


def read(tmp_path: Path, text: str, **arguments: object) -> Calibration:
    path = tmp_path / "camera.yaml"
    path.write_text(text, encoding="utf-8")
    return read_calibration(path, **arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize("form", SAME)
def test_every_form_gives_the_same_camera(tmp_path: Path, form: str) -> None:
    camera = read(tmp_path, SAME[form]).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (535.4, 539.2, 320.1, 247.6)
    assert (camera.width, camera.height) == (640, 480)
    assert camera.distortion == (0.1, -0.2, 0.001, 0.002, 0.3)
    assert camera.depth_scale == pytest.approx(5000)
    assert camera.fps == 25


def test_what_is_not_stated_is_assumed_and_said(tmp_path: Path) -> None:
    calibration = read(
        tmp_path, "fx: 1\nfy: 2\ncx: 3\ncy: 4\ndistortion: null\n", image_size=(320, 240), default_depth_scale=5000
    )
    camera = calibration.camera
    assert (camera.width, camera.height, camera.depth_scale, camera.fps) == (320, 240, 5000, 30)
    assert not camera.is_distorted
    assert len(calibration.notes) == 1
    assert "depth_scale" in calibration.notes[0]


def test_a_scale_below_one_is_metres_a_unit(tmp_path: Path) -> None:
    calibration = read(tmp_path, FLAT.replace("5000", "0.001"))
    assert calibration.camera.depth_scale == pytest.approx(1000)
    assert "0.001" in calibration.notes[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FLAT.replace("fx: 535.4", ""), "fx is missing"),
        (FLAT.replace("cy: 247.6", ""), "cy is missing"),
        (FLAT.replace("width: 640", ""), "width is missing"),
        (FLAT.replace("535.4", "wide"), "fx is 'wide'"),
        (FLAT.replace("535.4", "-535.4"), "fx is -535.4"),
        (FLAT.replace("535.4", ".nan"), "fx is nan"),
        (FLAT.replace("640", "640.5"), "whole number"),
        (FLAT.replace("640", "0"), "whole number"),
        (FLAT.replace("5000", "0"), "depth_scale"),
        (FLAT.replace("5000", "-3"), "depth_scale"),
        (FLAT.replace("5000", "deep"), "depth_scale is 'deep'"),
        (FLAT.replace("[0.1,", "[.inf,"), "finite"),
        (FLAT.replace("[0.1, -0.2, 0.001, 0.002, 0.3]", "7"), "distortion is 7"),
        (FLAT.replace("0.3]", "0.3, 0.1, 0.2, 0.3]"), "cannot stand for"),
        (FLAT + "distortion_model: equidistant\n", "equidistant is not supported"),
        ("K: [1, 2, 3]\nwidth: 4\nheight: 4\n", "3 numbers"),
        ("", "holds no keys"),
        ("- 1\n- 2\n", "holds no keys"),
        ("fx: [1\n", "is not YAML"),
        ("fx: \x07\n", "is not YAML"),
        ("a: &a {b: *a}\n", "fx|YAML"),
    ],
)
def test_faults_name_the_key_and_the_file(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(UserError, match=words) as caught:
        read(tmp_path, text)
    assert "camera.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


KEYS = st.sampled_from(
    ["fx", "fy", "cx", "cy", "K", "camera_matrix", "intrinsics", "data", "width", "height", "resolution", "distortion",
     "k1", "D", "distortion_model", "depth_scale", "depth", "scale", "fps", "camera", "cam0", "Camera.fx", "a.b.c", "x"]
)  # fmt: skip
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-1, 700) | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=10) | st.dictionaries(KEYS, inner, max_size=6),
    max_leaves=20,
)


TREES = st.dictionaries(KEYS, VALUES, max_size=12)
VALID = {"fx": 500, "fy": 500, "cx": 320, "cy": 240, "width": 640, "height": 480}


@given(TREES | TREES.map(lambda tree: VALID | tree) | VALUES)
@settings(deadline=None, max_examples=100, suppress_health_check=[HealthCheck.too_slow])
def test_whatever_stands_in_the_file_is_a_camera_or_a_clear_error(
    tmp_path_factory: pytest.TempPathFactory, tree: object
) -> None:
    path = tmp_path_factory.getbasetemp() / "camera.yaml"
    path.write_text(yaml.safe_dump(tree), encoding="utf-8")
    try:
        read_calibration(path)
    except UserError as error:
        message = str(error)
        assert "camera.yaml" in message
        assert "\n" not in message


def test_no_code_runs_from_a_calibration(tmp_path: Path) -> None:
    with pytest.raises(UserError):
        read(tmp_path, f"fx: !!python/object/apply:os.mkdir ['{tmp_path / 'made'}']\n")
    assert not (tmp_path / "made").exists()


def test_a_binary_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "camera.yaml").write_bytes(b"\xff\x00\xfe")
    with pytest.raises(UserError, match="not a text file"):
        read_calibration(tmp_path / "camera.yaml")
    with pytest.raises(UserError, match="cannot be read"):
        read_calibration(tmp_path)


@pytest.mark.parametrize(
    ("stated", "units"),
    [
        ("depth_units_per_metre: 1000", 1000.0),
        ("units_per_metre_of_depth: 4000", 4000.0),
        ("depth_scale_factor: 5000", 5000.0),
        ("DepthMapFactor: 6553.5", 6553.5),
        ("depth: {scale_factor: 2000}", 2000.0),
        ("depth: {units: mm}", 1000.0),
        ("depth_unit: 0.1 mm", 10000.0),
        ("depth_unit: metres", 1.0),
        ("depth_unit: micrometres", 1e6),
        ("depth_units: 0.00025", 4000.0),
        ("depth_scale: 1000 per metre", 1000.0),
        ("depth_millimetres_per_step: 0.25", 4000.0),
        ("depth: {metres_per_unit: 0.0002}", 5000.0),
        ("{depth_scale_spread: 0.02, depth_scale: 1000}", 1000.0),
    ],
)
def test_raw_depth_units_are_known_by_what_their_key_says(tmp_path: Path, stated: str, units: float) -> None:
    file = tmp_path / "camera.yaml"
    tree = {"fx": 500, "fy": 500, "cx": 320, "cy": 240, "width": 640, "height": 480, **yaml.safe_load(stated)}
    file.write_text(yaml.safe_dump(tree))
    calibration = read_calibration(file, default_depth_scale=77.0)
    assert calibration.camera.depth_scale == pytest.approx(units)
    assert not calibration.is_scale_assumed


@pytest.mark.parametrize(
    "silent", ["{}", "max_depth: 6.5", "depth_displacement: {scale: 1, shift: [0, 0], parallax: [0, 0]}"]
)
def test_a_scale_that_nothing_states_is_assumed_and_said(tmp_path: Path, silent: str) -> None:
    file = tmp_path / "camera.yaml"
    tree = {"fx": 500, "fy": 500, "cx": 320, "cy": 240, "width": 640, "height": 480, **yaml.safe_load(silent)}
    file.write_text(yaml.safe_dump(tree))
    calibration = read_calibration(file, default_depth_scale=77.0)
    assert calibration.camera.depth_scale == 77.0
    assert calibration.is_scale_assumed
    assert "states no depth_scale" in calibration.notes[0]


@pytest.mark.parametrize(
    "stated",
    [
        {"focal_length": [535.4, 539.2], "principal_point": [320.1, 247.6]},
        {"focal_length": {"x": 535.4, "y": 539.2}, "principal_point": {"x": 320.1, "y": 247.6}},
        {"intrinsics": {"focal": [535.4, 539.2], "center": [320.1, 247.6]}},
        {"f": [535.4, 539.2], "cx": 320.1, "cy": 247.6},
    ],
)
def test_both_axes_may_stand_under_one_key(tmp_path: Path, stated: dict[str, object]) -> None:
    file = tmp_path / "camera.json"
    file.write_text(json.dumps({"image_size": [640, 480], "depth_scale": 5000, **stated}))
    camera = read_calibration(file).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (535.4, 539.2, 320.1, 247.6)


def test_one_focal_length_is_that_of_both_axes(tmp_path: Path) -> None:
    file = tmp_path / "camera.yaml"
    file.write_text("{focal_length: 500, cx: 320, cy: 240, width: 640, height: 480}")
    camera = read_calibration(file).camera
    assert (camera.fx, camera.fy) == (500.0, 500.0)


PLAIN = """Kitchen, 5 March. The camera sees 640 x 480 pixels.
Focal lengths 535.4 and 539.2 pixels, principal point 320.1, 247.6.
Distortion k1 k2 p1 p2 k3 = 0.1 -0.2 0.001 0.002 0.3. Depth: 5000 units = 1 metre. 25 pictures a second.
"""

FORMS = {
    "notes.txt": PLAIN,
    "README": PLAIN,
    "camera.ini": "[image]\nwidth=640\nheight=480\n[lens]\nfx = 535.4\nfy = 539.2 ; px\ncx=320.1\ncy=247.6\n"
    "[distortion]\nk1=0.1\nk2=-0.2\np1=0.001\np2=0.002\nk3=0.3\n[depth]\nunits_per_metre=5000\n",
    "specs.md": "# Camera\n\n| | |\n|---|---|\n| width | 640 |\n| height | 480 |\n| fx | 535.4 |\n| fy | 539.2 |\n"
    "| cx | 320.1 |\n| cy | 247.6 |\n| k1, k2, p1, p2, k3 | 0.1, -0.2, 0.001, 0.002, 0.3 |\n\n"
    "Depth: one unit is 0.2 mm.\n",
    "storage.xml": '<?xml version="1.0"?><opencv_storage><image_width>640</image_width><image_height>480</image_height>'
    '<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt><data>535.4 0. 320.1 0. 539.2 247.6'
    " 0. 0. 1.</data></camera_matrix><distortion_coefficients><rows>1</rows><cols>5</cols><data>0.1 -0.2 0.001 0.002"
    " 0.3</data></distortion_coefficients><depth_factor>5000</depth_factor></opencv_storage>",
    "parts.json": '{"lens": {"focal_length": {"x": 535.4, "y": 539.2}, "principal_point": [320.1, 247.6], "distortion":'
    ' {"radial": [0.1, -0.2, 0.3], "tangential": [0.001, 0.002]}}, "size": [640, 480], "depth_units": "0.2 mm"}',
}


@pytest.mark.parametrize("name", FORMS)
def test_a_calibration_in_words_tables_and_other_forms_is_the_same(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(FORMS[name])
    camera = read_calibration(file, image_size=(640, 480)).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (535.4, 539.2, 320.1, 247.6)
    assert (camera.width, camera.height) == (640, 480)
    assert camera.distortion == (0.1, -0.2, 0.001, 0.002, 0.3)
    assert camera.depth_scale == pytest.approx(5000.0)


@pytest.mark.parametrize(
    "text",
    [
        "535.4 0 320.1\n0 539.2 247.6\n0 0 1\n",
        "# rows\n535.4, 0, 320.1, 0\n0, 539.2, 247.6, 0\n0, 0, 1, 0\n0, 0, 0, 1\n",
        "535.4 539.2 320.1 247.6",
        "640 480 535.4 539.2 320.1 247.6",
        "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 PINHOLE 640 480 535.4 539.2 320.1 247.6\n",
    ],
)
def test_a_calibration_may_be_numbers_alone(tmp_path: Path, text: str) -> None:
    file = tmp_path / "K.txt"
    file.write_text(text)
    camera = read_calibration(file, image_size=(640, 480)).camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (535.4, 539.2, 320.1, 247.6)


@pytest.mark.parametrize(
    "stated", ["hfov: 60", "horizontal_fov_deg: 60", "{fov_x: 60 deg, fov_y: 46.8265}", "dfov: 71.6355"]
)
def test_a_field_of_view_is_a_focal_length(tmp_path: Path, stated: str) -> None:
    file = tmp_path / "camera.yaml"
    file.write_text(yaml.safe_dump({"width": 640, "height": 480, **yaml.safe_load(stated)}))
    calibration = read_calibration(file)
    assert calibration.camera.fx == pytest.approx(320 / np.tan(np.radians(30)), rel=1e-3)
    assert calibration.camera.fy == pytest.approx(calibration.camera.fx, rel=1e-3)
    assert (calibration.camera.cx, calibration.camera.cy) == (319.5, 239.5)
    assert any("principal point" in note for note in calibration.notes)


def test_a_calibration_of_larger_images_is_scaled_and_that_is_said(tmp_path: Path) -> None:
    file = tmp_path / "camera.yaml"
    file.write_text("{fx: 600, fy: 604, cx: 319.5, cy: 241.5, width: 640, height: 480}")
    calibration = read_calibration(file, image_size=(320, 240))
    camera = calibration.camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (300.0, 302.0, 159.5, 120.5)
    assert (camera.width, camera.height) == (320, 240)
    assert any("is scaled to 320×240" in note for note in calibration.notes)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("notes.txt", "fx 500 fy 500 cx 320 cy 240, and later fx 600"),
        ("camera.xml", "<!DOCTYPE x [<!ENTITY a 'aaaa'>]><x><fx>&a;</fx></x>"),
        ("camera.xml", "<a>" * 5000),
        ("camera.txt", "1 0 0\n0 1 0\n0 0 1\n"),
        ("camera.txt", "9" * 5000),
        ("camera.txt", "fx" * 50_000),
        ("camera.txt", "(" * 20_000 + "fx 5"),
        ("camera.md", "| " * 50_000),
        ("camera.yaml", "hfov: 190\nwidth: 64\nheight: 48"),
        ("camera.yaml", "hfov: wide\nwidth: 64\nheight: 48"),
    ],
)
def test_what_states_no_one_camera_is_refused_in_one_line(tmp_path: Path, name: str, text: str) -> None:
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(UserError) as refusal:
        read_calibration(file, image_size=(640, 480))
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 600


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("cameras.txt", "1 OPENCV_FISHEYE 640 480 500 500 320 240 0.1 0 0 0\n", "opencv_fisheye is no pinhole"),
        ("cameras.txt", "1 THIN_PRISM_FISHEYE 640 480 500 500 320 240 0 0 0 0 0 0 0 0\n", "not supported"),
        ("cameras.txt", "1 SOME_OTHER 640 480 500 500 320 240\n", "cameras.txt"),
        ("camera.json", json.dumps(VALID | {"camera_model": "OPENCV_FISHEYE", "k1": 0.1}), "not supported"),
        ("camera.json", json.dumps(VALID | {"k1": 0.1, "k4": 9.0}), "cannot stand for"),
    ],
)
def test_a_lens_that_five_terms_do_not_describe_is_refused(tmp_path: Path, name: str, text: str, words: str) -> None:
    file = tmp_path / name
    file.write_text(text)
    with pytest.raises(UserError, match=words):
        read_calibration(file, image_size=(640, 480))
