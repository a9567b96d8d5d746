import copy
import pickle
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import pytest
import yaml
from pydantic import ValidationError

from lpslam.config import CalibratingConfig, Config
from lpslam.config.section import Section
from lpslam.errors import UserError


def leaves(section: Section, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every threshold with the path of its names."""
    for name in type(section).model_fields:
        value = getattr(section, name)
        if isinstance(value, Section):
            yield from leaves(value, (*path, name))
        else:
            yield (*path, name), value


def nested(path: tuple[str, ...], value: Any) -> dict[str, Any]:
    """A tree with one leaf."""
    tree: Any = value
    for name in reversed(path):
        tree = {name: tree}
    return dict(tree)


def at(config: Section, path: tuple[str, ...]) -> Any:
    """The value at a path of names."""
    value: Any = config
    for name in path:
        value = getattr(value, name)
    return value


LEAVES = dict(leaves(Config()))
NUMBERS = {path: value for path, value in LEAVES.items() if type(value) in (int, float)}


def written(folder: Path, text: str) -> Path:
    path = folder / "settings.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_every_default_passes_its_own_check_and_survives_a_file(tmp_path: Path) -> None:
    assert len(NUMBERS) > 80
    tree = Config().model_dump(mode="json")
    path = written(tmp_path, yaml.safe_dump(tree))
    assert Config.from_yaml(path) == Config()
    assert Config.model_validate(tree) == Config()


@pytest.mark.parametrize("text", ["", "# nothing but a comment\n", "{}\n", "slam: {}\n"])
def test_a_file_that_changes_nothing_gives_the_defaults(tmp_path: Path, text: str) -> None:
    assert Config.from_yaml(written(tmp_path, text)) == Config()


def test_a_file_changes_what_it_names_and_nothing_else(tmp_path: Path) -> None:
    text = "slam:\n  features: {count: 1500}\n  mapping:\n    fuse_radius: 4\ntext: {memory: {similarity: 0.7}}\n"
    changed = dict(leaves(Config.from_yaml(written(tmp_path, text))))
    assert {path: value for path, value in changed.items() if value != LEAVES[path]} == {
        ("slam", "features", "count"): 1500,
        ("slam", "mapping", "fuse_radius"): 4.0,
        ("text", "memory", "similarity"): 0.7,
    }


def test_what_is_no_number_is_refused_by_its_full_name(tmp_path: Path) -> None:
    taken, unclear = [], []
    for path in NUMBERS:
        file = written(tmp_path, yaml.safe_dump(nested(path, "plenty")))
        try:
            Config.from_yaml(file)
            taken.append(".".join(path))
        except UserError as refusal:
            message = str(refusal)
            if not (".".join(path) in message and str(file) in message and "\n" not in message):
                unclear.append(message)
    assert (taken, unclear) == ([], [])


@pytest.mark.parametrize("value", [-1, float("nan"), float("inf")])
def test_no_threshold_may_be_negative_or_endless(value: float) -> None:
    taken = []
    for path in NUMBERS:
        with suppress(ValidationError):
            Config.model_validate(nested(path, value))
            taken.append(".".join(path))
    assert taken == []


@pytest.mark.parametrize(
    "path",
    [
        ("slam", "features", "count"),
        ("slam", "features", "levels"),
        ("slam", "features", "cell_pixels"),
        ("slam", "features", "virtual_baseline"),
        ("slam", "noise", "pixel_sigma"),
        ("slam", "noise", "depth_sigma"),
        ("slam", "tracking", "pose_rounds"),
    ],
    ids=".".join,
)
def test_what_is_divided_by_or_counted_to_may_not_be_nought(path: tuple[str, ...]) -> None:
    with pytest.raises(ValidationError):
        Config.model_validate(nested(path, 0))


@pytest.mark.parametrize("value", [1.0, 0.9])
def test_a_pyramid_must_shrink(value: float) -> None:
    with pytest.raises(ValidationError):
        Config.model_validate({"slam": {"features": {"scale_factor": value}}})


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("slam: {featurs: {}}\n", "slam.featurs"),
        ("colour: red\n", "colour"),
        ("slam: {features: {count: 10, cuont: 11}}\n", "slam.features.cuont"),
        ("slam: 3\n", "slam"),
        ("- a\n- list\n", "settings.yaml"),
        ("just words\n", "settings.yaml"),
        ("slam: {features: \n", "is not YAML"),
        ("a: b: c\n", "is not YAML"),
        ("slam: !!python/object/apply:os.getcwd []\n", "is not YAML"),
        ("\x00", "is not YAML"),
    ],
)
def test_a_mistake_in_the_file_is_one_line_that_names_it(tmp_path: Path, text: str, named: str) -> None:
    with pytest.raises(UserError) as refusal:
        Config.from_yaml(written(tmp_path, text))
    assert named in str(refusal.value)
    assert "settings.yaml" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_not_there_or_no_text_is_one_line(tmp_path: Path) -> None:
    binary = tmp_path / "binary.yaml"
    binary.write_bytes(b"\xff\xfe\xfa\x80")
    for path in (tmp_path / "missing.yaml", tmp_path, binary):
        with pytest.raises(UserError, match=r"configuration ") as refusal:
            Config.from_yaml(path)
        assert str(path) in str(refusal.value)
        assert "\n" not in str(refusal.value)


def test_a_configuration_cannot_be_changed() -> None:
    config = Config()
    with pytest.raises(FrozenInstanceError):
        config.slam.features.count = 5  # type: ignore[misc]
    assert config.slam.features.count == LEAVES["slam", "features", "count"]
    assert at(config.model_copy(), ("slam", "features", "count")) == config.slam.features.count


def test_what_is_given_is_checked_however_it_is_given() -> None:
    with pytest.raises(ValidationError, match="greater than or equal to 4"):
        CalibratingConfig(views=3)
    with pytest.raises(ValidationError, match="Extra inputs"):
        Config(slamm=Config().slam)  # type: ignore[call-arg]
    with pytest.raises(ValidationError, match="valid dictionary"):
        Config(slam=Config().text)  # type: ignore[arg-type]
    given = Config(calibrating=CalibratingConfig(views=30), pairing=Config().pairing)
    assert given.calibrating.views == 30
    assert given != Config()
    assert Config.model_validate_json(given.model_dump_json()) == given
    assert pickle.loads(pickle.dumps(given)) == copy.deepcopy(given) == given
    assert hash(Config()) == hash(Config.model_validate({}))


def test_defaults_are_had_without_pydantic() -> None:
    script = "import sys; from lpslam.config import Config; Config(); print('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
