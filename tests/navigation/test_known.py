"""What is known of a map by whoever asks it: as the map itself says, read once, and anew when the map is another."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lpslam.cli_runs import keep
from lpslam.config import NavigationConfig
from lpslam.errors import UserError
from lpslam.language.model import Judgement
from lpslam.mapfile.container import identity_of
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.asking import ask
from lpslam.navigation.known import directory_of, known_in, known_of
from lpslam.text.correcting.corrections import Anchor, Correction, Corrections, Kind
from small_maps import small_map


@pytest.fixture(autouse=True)
def _cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def map_file(tmp_path: Path) -> Path:
    world = small_map()
    first, *_ = world.landmarks()
    said = Correction(1, Kind.RENAME, Anchor(first.id, first.name, 0, (-0.0, -1.0, 0.0)), "Starbucks Reserve")
    world.text.corrections = Corrections().with_one(said)
    judged = Judgement("Is this a shop?", True, 0.9, "a café", "test")
    world.text.judge([(mark.wording, judged) for mark in world.landmarks()[1:]], judged.question)
    world.save(tmp_path / "mall.lpmap")
    return tmp_path / "mall.lpmap"


def plain(value: Any) -> Any:
    """A value and its type, and all that it is made of."""
    if isinstance(value, np.ndarray):
        return value.dtype, value.tolist()
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, tuple):
        return tuple(map(plain, value))
    if hasattr(value, "__dataclass_fields__"):
        return type(value), {each.name: plain(getattr(value, each.name)) for each in fields(value)}
    return type(value), value


def test_it_is_what_the_map_itself_says(map_file: Path) -> None:
    first, again, true = known_in(map_file), known_in(map_file), known_of(LanguageMap.load(map_file))
    assert true.landmarks[0].name == "Starbucks Reserve"
    assert true.landmarks[0].corrections
    assert true.landmarks[1].is_landmark
    assert plain(first) == plain(again) == plain(true)


def test_a_map_is_read_once(map_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    known_in(map_file)
    monkeypatch.setattr(LanguageMap, "load", lambda path: pytest.fail("read once more"))
    assert known_in(map_file).landmarks
    moved = map_file.rename(map_file.with_name("moved.lpmap"))
    assert known_in(moved).landmarks


def test_what_is_saved_need_not_be_read(map_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    world = LanguageMap.load(map_file)
    world.source = "another"
    true = known_of(world)
    keep(world, map_file, landmarks=world.landmarks())
    monkeypatch.setattr(LanguageMap, "load", lambda path: pytest.fail("read"))
    assert plain(known_in(map_file)) == plain(true)


def test_saving_says_which_map_it_is(map_file: Path) -> None:
    assert LanguageMap.load(map_file).save(map_file) == identity_of(map_file)


def test_another_map_in_its_place_is_read(map_file: Path) -> None:
    before = known_in(map_file).landmarks
    world = LanguageMap.load(map_file)
    world.text.corrections = Corrections(2)
    world.save(map_file)
    assert before[0].name == "Starbucks Reserve"
    assert known_in(map_file).landmarks[0].name == "Starbucks"
    moved = world.text.memory.long_term[1].observations
    moved[:] = [replace(each, placement=replace(each.place, position=(9.0, 0.0, 9.0))) for each in moved]
    world.save(map_file)
    assert not np.allclose(known_in(map_file).landmarks[1].position, before[1].position)


def test_what_is_no_map_is_refused_as_ever(tmp_path: Path, map_file: Path) -> None:
    (tmp_path / "no.lpmap").write_bytes(b"no map")
    for path in (tmp_path / "no.lpmap", tmp_path / "absent.lpmap", tmp_path):
        with pytest.raises(UserError) as said:
            known_in(path)
        with pytest.raises(UserError) as expected:
            LanguageMap.load(path)
        assert str(said.value) == str(expected.value)
    map_file.write_bytes(map_file.read_bytes()[:-200])
    with pytest.raises(UserError, match="damaged"):
        known_in(map_file)


def test_a_map_at_hand_is_made_ready_once_until_it_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    world = small_map()
    first, *_ = world.landmarks()
    directory, view = directory_of(world)
    assert directory_of(world)[0] is directory
    assert plain(view) == plain(known_of(world).view)

    changed = []
    judged = Judgement("Is this a shop?", True, 0.9, "a café", "test")
    world.text.judge([(first.wording, judged)], judged.question)
    changed.append(directory_of(world)[0])
    said = Correction(1, Kind.RENAME, Anchor(first.id, first.name, 0, (-0.0, -1.0, 0.0)), "Starbucks Reserve")
    world.text.corrections = world.text.corrections.with_one(said)
    changed.append(directory_of(world)[0])
    del world.text.memory.long_term[3]
    changed.append(directory_of(world)[0])
    moved = np.eye(4)
    moved[0, 3] = 5.0
    monkeypatch.setattr(type(world), "world_from_keyframe", lambda self, keyframe: moved)
    monkeypatch.setattr(type(world.slam), "world_from_keyframe", lambda self, keyframe: moved)
    changed.append(directory_of(world)[0])

    assert len({id(each) for each in (directory, *changed)}) == 5
    assert changed[0].by_id[first.id].is_landmark
    assert changed[1].by_id[first.id].name == "Starbucks Reserve"
    assert 3 not in changed[2].by_id
    assert [plain(mark) for mark in changed[3].landmarks] == [plain(mark) for mark in world.landmarks()]
    assert directory_of(world, NavigationConfig(listed=3))[0].config.listed == 3


def test_asking_a_map_again_derives_no_landmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    world = small_map()
    assert ask(world, "Where is KFC?").landmark is not None
    monkeypatch.setattr(LanguageMap, "landmarks", lambda self: pytest.fail("derived once more"))
    answer = ask(world, "Where is the toilet?")
    assert answer.landmark is not None
    assert answer.landmark.name == "Toilets"
