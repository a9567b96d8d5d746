"""One wrong value anywhere in a map is one line, and nothing is made of the rest."""

import copy
import fcntl
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from command_line import Command
from lpslam.errors import UserError
from lpslam.mapfile import correcting
from lpslam.mapfile.container import read_map_file, write_map_file
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.types import Placement
from small_maps import small_map, with_floor

JUDGED = {"question": "?", "answer": True, "confidence": 1.0, "evidence": "", "model": "offline"}


def _set(document: Any, place: tuple[Any, ...], value: object) -> Any:
    """A copy of a document with another value at one place."""
    if not place:
        return value
    changed = copy.copy(document)
    changed[place[0]] = _set(document[place[0]], place[1:], value)
    return changed


@pytest.mark.parametrize(
    ("name", "place", "value"),
    [
        ("text", ("judgements",), {"a": {"?": {**JUDGED, "answer": "yes"}}}),
        ("text", ("judgements",), {"a": {"?": {**JUDGED, "confidence": float("nan")}}}),
        ("text", ("question",), ["?"]),
        ("text", ("memory", "next_id"), 0),
        ("text", ("memory", "clock"), "now"),
        ("text", ("memory", "classes", 0, "variants"), {}),
        ("text", ("memory", "classes", 0, "id"), -1),
        ("text", ("memory", "classes", 0, "score"), None),
        ("text", ("memory", "classes", 0, "naming", "name"), 5),
        ("text", ("memory", "classes", 0, "observations", 0, "keyframe"), 10**6),
        ("text", ("memory", "classes", 0, "observations", 0, "placement", "position"), [0.0, 1e300, 0.0]),
        ("text", ("memory", "classes", 0, "observations", 0, "placement", "width"), -1.0),
        ("text", ("memory", "classes", 0, "observations", 0, "ground"), [1, 2, 3000]),
        ("run", ("statistics",), {"run": "fast"}),
        ("run", ("statistics",), {"run": {"seconds": "long"}}),
        ("run", ("statistics",), {"reading": {"frames_read": {}}}),
        ("run", ("source",), 7),
        ("camera", ("fx",), "wide"),
        ("camera", ("distortion",), [0.0]),
    ],
)
def test_a_document_with_one_wrong_value_is_said_to_be_damaged(
    tmp_path: Path, name: str, place: tuple[Any, ...], value: object
) -> None:
    small_map().save(tmp_path / "good.lpmap")
    good = read_map_file(tmp_path / "good.lpmap")
    LanguageMap.load(tmp_path / "good.lpmap")
    changed = {**good.documents, name: _set(good.documents[name], place, value)}
    write_map_file(tmp_path / "map.lpmap", changed, good.arrays)
    with pytest.raises(UserError, match=r"map the (recording|sequence) again") as caught:
        LanguageMap.load(tmp_path / "map.lpmap")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "row", "value"),
    [
        ("trajectory.keyframe", 0, 2**31 - 1),
        ("trajectory.timestamp", 0, np.nan),
        ("trajectory.session", 0, -1),
        ("trajectory.keyframe_from_camera", (0, 0, 0), 9.0),
        ("slam.camera_from_world", (0, 1, 1), 9.0),
        ("slam.position", (0, 0), 1e30),
        ("slam.scales", 0, 1e30),
        ("slam.timestamp", 0, np.inf),
        ("scans.keyframe", 0, 7),
    ],
)
def test_a_column_with_one_wrong_value_is_said_to_be_damaged(tmp_path: Path, name: str, row: Any, value: float) -> None:
    with_floor(small_map()).save(tmp_path / "good.lpmap")
    good = read_map_file(tmp_path / "good.lpmap")
    LanguageMap.load(tmp_path / "good.lpmap")
    column = good.arrays[name].copy()
    column[row] = value
    write_map_file(tmp_path / "map.lpmap", good.documents, {**good.arrays, name: column})
    with pytest.raises(UserError, match="map the recording again"):
        LanguageMap.load(tmp_path / "map.lpmap")


def test_whoever_changes_a_map_waits_for_others(
    lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.lpmap"
    small_map().save(path)
    before = path.read_bytes()
    monkeypatch.setattr(correcting, "_PATIENCE", 0.1)
    with (tmp_path / ".a.lpmap.lock").open("w") as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        for words in (["distill", path], ["correct", path, "0", "--name", "Cafe"]):
            assert "by another program" in lpslam(*words).complaint
    assert path.read_bytes() == before
    assert lpslam("distill", path).code == 0


def test_a_map_that_is_not_there_gets_no_lock(lpslam: Command, tmp_path: Path) -> None:
    for words in (["distill", tmp_path / "a.lpmap"], ["correct", tmp_path / "a.lpmap", "0", "--hide"]):
        assert "cannot be read" in lpslam(*words).complaint
    assert not os.listdir(tmp_path)


def test_a_correction_reads_the_map_once(lpslam: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    small_map().save(tmp_path / "a.lpmap")
    read: list[Path] = []
    load = LanguageMap.load
    monkeypatch.setattr(LanguageMap, "load", lambda path: read.append(path) or load(path))
    assert lpslam("correct", tmp_path / "a.lpmap", "0", "--name", "Cafe").code == 0
    assert len(read) == 1


def test_places_that_were_refused_as_patterns_are_kept_and_hang_on_keyframes(tmp_path: Path) -> None:
    frieze = Placement((0.0, 0.0, 2.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), 2.0, 0.1, 0.0)
    world = small_map()
    world.text.patterns.add(0, frieze)
    world.save(tmp_path / "a.lpmap")
    (again,) = LanguageMap.load(tmp_path / "a.lpmap").text.patterns.seen
    assert (again.keyframe, again.placement, again.count) == (0, frieze, 1)
    world.text.patterns.add(77, frieze)
    world.save(tmp_path / "b.lpmap")
    with pytest.raises(UserError, match="a pattern names keyframe 77"):
        LanguageMap.load(tmp_path / "b.lpmap")
