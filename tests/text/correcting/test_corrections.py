"""What a person says of landmarks wins over what was read, is found again, and is taken back without a trace."""

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam import pipeline
from lpslam.errors import UserError
from lpslam.language.model import Naming
from lpslam.language.offline import embedded_model
from lpslam.mapfile.container import read_map_file, write_map_file
from lpslam.mapfile.language_map import LanguageMap
from lpslam.text.correcting.changing import Change, ConflictError, NoSuchCorrectionError, correct, take_back
from lpslam.text.correcting.corrections import Corrections, Kind
from small_maps import small_map

SIGNS = ("KFO", "Pizza Hut", "新华书店", "KFC")


def say(world: LanguageMap, kind: Kind, landmark: int, **said: Any) -> None:
    correct(world.text, world.world_from_keyframe, Change(kind, landmark, **said), embedded_model())


def names(world: LanguageMap) -> dict[int, str]:
    return {mark.id: mark.name for mark in world.landmarks()}


@pytest.fixture
def world() -> LanguageMap:
    return small_map(signs=SIGNS)


def test_a_name_that_a_person_gives_replaces_the_one_that_was_read(world: LanguageMap) -> None:
    say(world, Kind.RENAME, 0, name=" Książki\u202e i\nzabawki ")
    mark = world.landmarks()[0]
    assert (mark.name, mark.confidence) == ("Książki i zabawki", 1.0)
    assert "KFO" not in (*mark.variants, *(line.text for line in mark.lines), mark.wording)
    assert mark.corrections[0].landmark.name == "KFO"
    answer = pipeline.ask(world, "Książki i zabawki")
    assert answer.landmark is not None
    assert answer.landmark.id == 0
    say(world, Kind.RENAME, 0, name="Bookshop")
    assert names(world)[0] == "Bookshop"


def test_two_that_are_the_same_become_one_where_the_kept_one_stands(world: LanguageMap) -> None:
    kept = world.landmarks()[3]
    say(world, Kind.MERGE, 0, into=3000)
    assert names(world) == {1000: "Pizza Hut", 2000: "新华书店", 3000: "KFC"}
    merged = world.landmarks()[2]
    np.testing.assert_array_equal(merged.position, kept.position)
    assert merged.observations == 10
    assert merged.variants == {"KFC": 5, "KFO": 5}
    with pytest.raises(NoSuchCorrectionError):
        say(world, Kind.MERGE, 3000, into=0)


def test_merging_what_is_merged_ends_somewhere(world: LanguageMap) -> None:
    say(world, Kind.MERGE, 0, into=1000)
    say(world, Kind.MERGE, 1000, into=2000)
    assert names(world) == {2000: "新华书店", 3000: "KFC"}
    take_back(world.text, 1)
    assert names(world) == {0: "KFO", 2000: "新华书店", 3000: "KFC"}


def test_what_is_hidden_is_no_answer_and_comes_back(world: LanguageMap) -> None:
    before = names(world)
    say(world, Kind.HIDE, 1000)
    assert 1000 not in names(world)
    assert pipeline.ask(world, "Where can I eat pizza?").landmark is None
    (said,) = world.text.corrections.entries
    take_back(world.text, said.number)
    assert names(world) == before
    assert world.text.corrections.revision == 2


def test_a_persons_judgement_outlasts_the_models(world: LanguageMap) -> None:
    pipeline.distill(world, "Is this a shop?")
    judged = {mark.id: mark.is_landmark for mark in world.landmarks()}
    say(world, Kind.JUDGE, 2000, answer=not judged[2000])
    pipeline.distill(world, "Is this a shop?")
    assert {mark.id: mark.is_landmark for mark in world.landmarks()} == judged | {2000: not judged[2000]}
    # It was said of one question alone.
    pipeline.distill(world, "Is this a place to eat?")
    (evidence,) = [mark.judgements["Is this a place to eat?"].model for mark in world.landmarks() if mark.id == 2000]
    assert evidence != "a person"


def test_a_new_name_is_judged_by_the_maps_question(world: LanguageMap) -> None:
    pipeline.distill(world, "Is this a restaurant?")
    before = {mark.id: mark.is_landmark for mark in world.landmarks()}
    assert before[2000] is False
    say(world, Kind.RENAME, 2000, name="Pizza Hut")
    assert {mark.id: mark.is_landmark for mark in world.landmarks()} == before | {2000: True}


def test_distilling_and_saving_keep_what_was_said(world: LanguageMap, tmp_path: Path) -> None:
    say(world, Kind.RENAME, 0, name="KFC")
    say(world, Kind.HIDE, 1000)
    pipeline.distill(world)
    world.text.memory.long_term[0].naming = Naming("KFD", 0.99, "read again", "test")
    world.save(tmp_path / "map.lpmap")
    again = LanguageMap.load(tmp_path / "map.lpmap")
    assert again.text.corrections == world.text.corrections
    assert names(again) == {0: "KFC", 2000: "新华书店", 3000: "KFC"}


def test_a_map_of_an_older_program_has_no_corrections_and_takes_them(world: LanguageMap, tmp_path: Path) -> None:
    world.save(tmp_path / "old.lpmap")
    contents = read_map_file(tmp_path / "old.lpmap")
    assert "corrections" not in contents.documents
    old = LanguageMap.load(tmp_path / "old.lpmap")
    say(old, Kind.HIDE, 0)
    old.save(tmp_path / "old.lpmap")
    assert 0 not in names(LanguageMap.load(tmp_path / "old.lpmap"))


def test_what_was_said_is_found_again_when_the_map_has_moved_or_was_numbered_anew(world: LanguageMap) -> None:
    say(world, Kind.RENAME, 0, name="KFC")
    say(world, Kind.HIDE, 1000)
    turned = np.array([[0.0, -1, 0, 5], [1, 0, 0, -2], [0, 0, 1, 0.5], [0, 0, 0, 1]])

    def moved(keyframe: int) -> np.ndarray[Any, Any] | None:
        pose = world.world_from_keyframe(keyframe)
        return None if pose is None else turned @ pose

    marks = {mark.id: mark.name for mark in world.text.landmarks(moved)}
    assert marks == {0: "KFC", 2000: "新华书店", 3000: "KFC"}
    # The same sign under another number of a class, as when a map has grown.
    world.text.memory.long_term[7] = world.text.memory.long_term.pop(0)
    world.text.memory.long_term[7].id = 7
    assert names(world)[7000] == "KFC"
    # Another sign under its old number is another sign.
    world.text.memory.long_term[7].variants = {"Gap": world.text.memory.long_term[7].variants["KFO"]}
    world.text.memory.long_term[7].naming = Naming("Gap", 0.9, "", "")
    for number, seen in enumerate(world.text.memory.long_term[7].observations):
        changed = {name: getattr(seen, name) for name in seen.__dataclass_fields__} | {"text": "Gap"}
        world.text.memory.long_term[7].observations[number] = type(seen)(**changed)
    assert names(world)[7000] == "Gap"


def test_who_has_not_seen_what_there_is_is_told(world: LanguageMap) -> None:
    say(world, Kind.HIDE, 0)
    change = Change(Kind.RENAME, 1000, "Pizza")
    with pytest.raises(ConflictError) as told:
        correct(world.text, world.world_from_keyframe, change, embedded_model(), revision=0)
    assert told.value.corrections == world.text.corrections
    with pytest.raises(ConflictError):
        take_back(world.text, 1, revision=0)
    correct(world.text, world.world_from_keyframe, change, embedded_model(), revision=1)
    assert world.text.corrections.revision == 2


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (Change(Kind.RENAME, 0, " \u200b "), "the name is empty"),
        (Change(Kind.RENAME, 17, "KFC"), "no landmark 17"),
        (Change(Kind.MERGE, 0), "with which other"),
        (Change(Kind.MERGE, 0, into=0), "with which other"),
        (Change(Kind.MERGE, 0, into=17), "no landmark 17"),
        (Change(Kind.JUDGE, 0), "give yes or no"),
    ],
)
def test_a_correction_that_says_nothing_is_refused(world: LanguageMap, change: Change, words: str) -> None:
    with pytest.raises(UserError, match=words):
        correct(world.text, world.world_from_keyframe, change, embedded_model())
    assert world.text.corrections == Corrections()
    with pytest.raises(NoSuchCorrectionError):
        take_back(world.text, 1)


def test_a_copy_is_corrected_apart(world: LanguageMap) -> None:
    pipeline.distill(world)
    before = copy.deepcopy(world.text.judgements)
    other = world.text.copy()
    correct(other, world.world_from_keyframe, Change(Kind.RENAME, 0, "A new name"), embedded_model())
    assert world.text.corrections == Corrections()
    assert world.text.judgements == before


def valid() -> dict[str, Any]:
    world = small_map(signs=SIGNS)
    say(world, Kind.RENAME, 0, name="KFC")
    say(world, Kind.MERGE, 0, into=3000)
    say(world, Kind.JUDGE, 2000, answer=True)
    document: dict[str, Any] = json.loads(json.dumps(world.text.corrections.to_document()))
    assert Corrections.from_document(document) == world.text.corrections
    return document


VALID = valid()
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=5,
)


@given(st.data())
def test_whatever_stands_in_a_file_is_corrections_or_is_refused(data: st.DataObject) -> None:
    document = copy.deepcopy(VALID)
    at: Any = document
    while True:
        keys = list(at) if isinstance(at, dict) else list(range(len(at)))
        key = data.draw(st.sampled_from(keys))
        if not isinstance(at[key], dict | list) or not at[key] or data.draw(st.booleans()):
            break
        at = at[key]
    at[key] = data.draw(ANYTHING)
    try:
        read = Corrections.from_document(document)
    except (KeyError, TypeError, ValueError, AttributeError):
        return
    world = small_map(signs=SIGNS)
    world.text.corrections = read
    for mark in world.landmarks():
        assert mark.name.isprintable()
        assert len(mark.name) <= 120


def test_a_file_with_broken_corrections_is_one_clear_error(world: LanguageMap, tmp_path: Path) -> None:
    world.save(tmp_path / "map.lpmap")
    contents = read_map_file(tmp_path / "map.lpmap")
    for broken in ([], {"entries": 3}, {**VALID, "revision": -1}, {**VALID, "entries": [{}]}, "x", None):
        write_map_file(tmp_path / "map.lpmap", {**contents.documents, "corrections": broken}, contents.arrays)
        with pytest.raises(UserError, match="damaged"):
            LanguageMap.load(tmp_path / "map.lpmap")
