import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from lpslam import pipeline
from lpslam.errors import UserError
from lpslam.mapfile import container
from lpslam.mapfile.container import FORMAT_VERSION, read_map_file, write_map_file
from lpslam.mapfile.export import landmark_record
from lpslam.mapfile.language_map import LanguageMap

pytestmark = pytest.mark.slow


def test_a_map_saved_loaded_and_saved_again_is_equal(world: LanguageMap, walked: Path, tmp_path: Path) -> None:
    pipeline.distill(world)
    world.save(tmp_path / "a.lpmap")
    loaded = LanguageMap.load(tmp_path / "a.lpmap")
    loaded.save(tmp_path / "b.lpmap")
    a, b = read_map_file(tmp_path / "a.lpmap"), read_map_file(tmp_path / "b.lpmap")
    assert a.documents == b.documents
    assert a.arrays.keys() == b.arrays.keys()
    for name in a.arrays:
        assert (a.arrays[name].dtype, a.arrays[name].shape) == (b.arrays[name].dtype, b.arrays[name].shape)
        assert a.arrays[name].tobytes() == b.arrays[name].tobytes(), name
    assert [landmark_record(mark) for mark in loaded.landmarks()] == [
        landmark_record(mark) for mark in world.landmarks()
    ]
    assert loaded.camera == world.camera
    assert (loaded.source, loaded.statistics) == (world.source, world.statistics)
    assert np.array_equal(loaded.frame_poses().world_from_camera, world.frame_poses().world_from_camera)
    assert np.array_equal(loaded.cloud(), world.cloud())


def test_a_loaded_map_is_distilled_and_asked_like_a_new_one(world: LanguageMap, tmp_path: Path) -> None:
    new = [landmark_record(mark) for mark in pipeline.distill(world)]
    answer = pipeline.ask(world, "Where is the washroom?")
    world.save(tmp_path / "map.lpmap")
    loaded = LanguageMap.load(tmp_path / "map.lpmap")
    assert [landmark_record(mark) for mark in loaded.landmarks()] == new
    assert [landmark_record(mark) for mark in pipeline.distill(loaded)] == new
    again = pipeline.ask(loaded, "Where is the washroom?")
    assert answer.landmark is not None
    assert again.landmark is not None
    assert (again.choice, again.distance) == (answer.choice, answer.distance)


def test_landmarks_follow_their_keyframes(world: LanguageMap) -> None:
    before = {mark.id: mark for mark in world.landmarks()}
    moved_from_map = np.eye(4)
    moved_from_map[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    moved_from_map[:3, 3] = (5.0, -2.0, 0.5)
    world.slam.transform(moved_from_map)
    for mark in world.landmarks():
        expected = moved_from_map[:3, :3] @ before[mark.id].position + moved_from_map[:3, 3]
        np.testing.assert_allclose(mark.position, expected, atol=1e-9)


def test_a_map_that_lacks_a_part_is_said_to_be_damaged(begun: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(begun) as whole:
        members = {member.filename: whole.read(member) for member in whole.infolist()}
    manifest = json.loads(members.pop("manifest.json"))
    # A map of version 2 may lack these, and is whole.
    for missing in members.keys() - {"arrays/patterns.rows.npy", "arrays/slam.inverse_sigma.npy"}:
        listed = {
            kind: [n for n in manifest[kind] if f"{kind}/{n}." not in missing] for kind in ("documents", "arrays")
        }
        assert sum(map(len, listed.values())) == len(members) - 1
        with zipfile.ZipFile(tmp_path / "map.lpmap", "w") as part:
            part.writestr("manifest.json", json.dumps({**manifest, **listed}))
            for name in members.keys() - {missing}:
                part.writestr(name, members[name])
        with pytest.raises(UserError, match=r"map the (recording|sequence) again"):
            LanguageMap.load(tmp_path / "map.lpmap")


def test_a_map_of_version_2_is_read_and_its_reader_refuses_the_newer_one(
    walked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    contents = read_map_file(walked)
    # Of before patterns and points known by direction alone were kept.
    arrays = {k: v for k, v in contents.arrays.items() if k not in {"patterns.rows", "slam.inverse_sigma"}}
    monkeypatch.setattr(container, "FORMAT_VERSION", 2)
    write_map_file(tmp_path / "old.lpmap", contents.documents, arrays)
    with pytest.raises(UserError, match=r"format version 3, this lpslam reads up to 2: update lpslam$"):
        LanguageMap.load(walked)
    monkeypatch.undo()
    old, new = LanguageMap.load(tmp_path / "old.lpmap"), LanguageMap.load(walked)
    assert len(old.cloud()) == len(contents.arrays["slam.head"][contents.arrays["slam.point_alive"]])
    assert [mark.name for mark in old.landmarks()] == [mark.name for mark in new.landmarks()]
    old.save(tmp_path / "old.lpmap")
    assert read_map_file(tmp_path / "old.lpmap").manifest["format_version"] == 3


@pytest.mark.parametrize("value", [None, [], {}, "text", 7, [1, 2]])
def test_documents_of_another_shape_are_said_to_be_damaged(walked: Path, tmp_path: Path, value: object) -> None:
    contents = read_map_file(walked)
    for name in contents.documents:
        write_map_file(tmp_path / "map.lpmap", {**contents.documents, name: value}, contents.arrays)
        with pytest.raises(UserError) as caught:
            LanguageMap.load(tmp_path / "map.lpmap")
        assert "\n" not in str(caught.value)


def test_the_file_says_what_it_is(walked: Path) -> None:
    with zipfile.ZipFile(walked) as archive:
        assert archive.namelist()[0] == "manifest.json"
        manifest = json.loads(archive.read("manifest.json"))
    assert (manifest["format"], manifest["format_version"]) == ("lpslam map", FORMAT_VERSION)
    assert manifest["created"].endswith("+00:00")
