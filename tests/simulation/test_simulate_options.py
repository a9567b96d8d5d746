"""What `lpslam simulate` can be asked for."""

from dataclasses import replace
from pathlib import Path

import pytest

from command_line import Command
from lpslam.evaluation.signs import read_signs
from lpslam.simulation.boards import street
from lpslam.simulation.boards.labels import write_labelled
from lpslam.simulation.boards.painting import paint_shop_board
from lpslam.simulation.boards.street import pass_by as street_walk


@pytest.mark.slow
def test_a_mall_of_ones_own(lpslam: Command, tmp_path: Path) -> None:
    options = ("--duplicate-distances", "3,15", "--similar-names", "--projecting-share", 1, "--way", "there-and-back")
    done = lpslam("simulate", tmp_path / "mall", "--frames", 1, "--language", "english", "--json", *options)
    assert (done.code, done.json["frames"]) == (0, 1)
    signs = read_signs(tmp_path / "mall")
    assert signs is not None
    texts = [sign.text for sign in signs]
    assert {"GAP", "GAO"} <= set(texts)
    assert len(set(texts)) < len(texts)
    assert sum(sign.double_sided for sign in signs) >= 5
    assert all(sign.lines and sign.lines[0].text == sign.text for sign in signs)


@pytest.mark.parametrize(
    ("option", "value"),
    [("--duplicate-distances", "3,near"), ("--duplicate-distances", "-3"), ("--projecting-share", "2"),
     ("--way", "back")],
)  # fmt: skip
def test_what_no_mall_can_be_is_one_clear_line(lpslam: Command, tmp_path: Path, option: str, value: str) -> None:
    complaint = lpslam("simulate", tmp_path / "mall", f"{option}={value}").complaint
    assert complaint.startswith(f"option {option}: Input should")
    assert not (tmp_path / "mall").exists()


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [("--duplicates", 10**9, "can repeat another one; ask for fewer"), ("--frames", 10**15, "108000, an hour's"),
     ("--duplicate-distances", "3,1e300", "do not fit a loop of 32 m")],
)  # fmt: skip
def test_more_than_a_mall_holds_is_one_clear_line(
    lpslam: Command, tmp_path: Path, option: str, value: object, said: str
) -> None:
    assert said in lpslam("simulate", tmp_path / "mall", option, value).complaint
    assert not (tmp_path / "mall").exists()


@pytest.mark.slow
def test_a_world_of_a_seed(lpslam: Command, tmp_path: Path) -> None:
    options = ("--world", 5, "--frames", 3, "--factor", "place=corridor", "--factor", "size=320x240", "--json")
    done = lpslam("simulate", tmp_path / "world", *options)
    assert (done.code, done.json["frames"]) == (0, 3)
    assert (done.json["place"], done.json["size"]) == ("corridor", "320x240")
    assert read_signs(tmp_path / "world") is not None
    assert (tmp_path / "world" / "world.json").is_file()


def test_what_no_world_has_is_one_clear_line(lpslam: Command, tmp_path: Path) -> None:
    unknown = lpslam("simulate", tmp_path / "world", "--world", 5, "--factor", "weather=rain").complaint
    assert unknown.startswith("option --factor: weather is no factor")
    value = lpslam("simulate", tmp_path / "world", "--world", 5, "--factor", "depth=sonar").complaint
    assert "depth is 'sonar'; it must be one of structured" in value
    mall = lpslam("simulate", tmp_path / "world", "--factor", "depth=tof").complaint
    assert mall.startswith("option --factor: malls have none")


@pytest.mark.slow
def test_fronts_of_ones_own_pictures(lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the walk past them the first ten frames."""
    monkeypatch.setattr(street, "pass_by", lambda seed, shops: replace(street_walk(seed, shops), frames=10))
    write_labelled(tmp_path / "mine", [paint_shop_board(3, 0)])
    done = lpslam("simulate", tmp_path / "street", "--fronts", tmp_path / "mine", "--json")
    assert (done.code, done.json["signs"], done.json["boards"]) == (0, 1, "1 of 1")
    signs = read_signs(tmp_path / "street")
    assert signs is not None
    assert signs[0].lines[0].role == "primary"
    assert (tmp_path / "street" / "ornaments.json").is_file()


def test_fronts_that_cannot_be_are_one_clear_line(lpslam: Command, tmp_path: Path) -> None:
    assert "cannot be read" in lpslam("simulate", tmp_path / "street", "--fronts", tmp_path / "none").complaint
    complaint = lpslam("simulate", tmp_path / "street", "--fronts", tmp_path, "--frames", 9).complaint
    assert complaint == "--fronts and --frames exclude each other"
    assert not (tmp_path / "street").exists()
