"""Pictures of texts as they were seen best: chosen, bounded, kept in the map, and refused where a file lies."""

import base64
from pathlib import Path

import cv2
import numpy as np
import pytest

from lpslam.config import PageConfig, SightingConfig
from lpslam.errors import UserError
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.signs import sign_pictures
from lpslam.slam.features import Features
from lpslam.text.sightings import Sighting, SightingStore, pictured
from small_maps import WORLD_FROM_CAMERA, small_map

CONFIG = SightingConfig()
JPEG = b"\xff\xd8\xff"


def sighting(keyframe: int, seen: float, size: int = 100, place: tuple[float, float, float] = (0, 0, 1)) -> Sighting:
    return Sighting(keyframe, place, seen, JPEG + bytes([keyframe]) * (size - 3))


def always(text_class: int) -> bool:
    return True


def test_a_picture_shows_the_text_and_what_is_around_it_no_wider_than_it_may_be() -> None:
    image = np.full((480, 640, 3), (20, 40, 60), np.uint8)
    image[200:240, 100:500] = (250, 200, 10)
    box = np.array([[100, 200], [500, 200], [500, 240], [100, 240]], np.float64)
    jpeg = pictured(image, box, 40.0, SightingConfig(width=240))
    seen = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    assert seen.shape[1] == 240
    # 40 pixels around 400 by 40.
    assert seen.shape[0] == pytest.approx(240 * 120 / 480, abs=2)
    np.testing.assert_allclose(seen[seen.shape[0] // 2, 120], (250, 200, 10), atol=12)
    np.testing.assert_allclose(seen[3, 3], (20, 40, 60), atol=12)


def test_the_largest_sightings_of_a_class_stay_and_one_a_keyframe() -> None:
    store = SightingStore(SightingConfig(of_class=2))
    for keyframe, seen in enumerate((10.0, 30.0, 20.0, 12.0)):
        if store.wants(0, keyframe, seen):
            store.keep(0, sighting(keyframe, seen), always)
    assert sorted(each.seen for each in store.by_class[0]) == [20.0, 30.0]
    store.keep(0, sighting(2, 40.0), always)
    assert sorted((each.keyframe, each.seen) for each in store.by_class[0]) == [(1, 30.0), (2, 40.0)]
    assert not store.wants(0, 3, 31.0)
    assert store.wants(0, 3, 60.0)
    assert not store.wants(0, 2, 41.0)
    assert store.wants(1, 0, 1.0)


def test_where_room_is_short_what_is_forgotten_goes_and_then_what_was_seen_smallest() -> None:
    store = SightingStore(SightingConfig(all_bytes=250))
    store.keep(0, sighting(0, 50.0), always)
    store.keep(1, sighting(1, 10.0), always)
    store.keep(2, sighting(2, 20.0), lambda text_class: text_class != 0)
    assert sorted(store.by_class) == [1, 2]
    store.keep(3, sighting(3, 30.0), always)
    assert sorted(store.by_class) == [2, 3]


def test_only_what_is_remembered_comes_back_as_it_was() -> None:
    store = SightingStore(CONFIG)
    for key in range(3):
        store.keep(key, sighting(key, 5.0 + key, 50 + key, (0.5, key, 2.0)), always)
    again = SightingStore.from_arrays(store.to_arrays(lambda key: key != 1), CONFIG)
    assert again.by_class == {key: store.by_class[key] for key in (0, 2)}
    assert len(SightingStore.from_arrays({}, CONFIG)) == 0
    assert len(SightingStore.from_arrays(SightingStore(CONFIG).to_arrays(always), CONFIG)) == 0


@pytest.mark.parametrize(("column", "value"), [(6, 49.0), (6, 0.0), (6, 1e12), (6, np.nan), (2, np.inf)])
def test_pictures_that_lie_about_their_size_are_refused(column: int, value: float) -> None:
    store = SightingStore(CONFIG)
    store.keep(0, sighting(0, 5.0, 50), always)
    arrays = store.to_arrays(always)
    arrays["rows"][0, column] = value  # type: ignore[index]
    with pytest.raises(ValueError, match="sighting"):
        SightingStore.from_arrays(arrays, CONFIG)


def test_what_is_no_picture_is_refused_and_so_is_one_of_a_strange_keyframe(tmp_path: Path) -> None:
    world = small_map()
    world.text.sightings.keep(0, Sighting(0, (0, 0, 1), 9.0, b"<svg onload=alert(1)>"), always)
    world.save(tmp_path / "a.lpmap")
    with pytest.raises(UserError, match="no JPEG"):
        LanguageMap.load(tmp_path / "a.lpmap")
    world.text.sightings.drop([0])
    world.text.sightings.keep(0, sighting(7, 9.0), always)
    world.save(tmp_path / "b.lpmap")
    with pytest.raises(UserError, match="keyframe"):
        LanguageMap.load(tmp_path / "b.lpmap")


def test_each_landmark_has_the_picture_that_was_taken_of_it(tmp_path: Path) -> None:
    world = small_map(signs=("KFC", "ATM", "EXIT"))
    # Boards stand at x = 0, 4 and 8, y = 0, z = 1 of the map: up to 8 m before a camera at the origin.
    for key, seen in ((0, 12.0), (1, 9.0)):
        world.text.sightings.keep(key, sighting(0, seen, 60 + key, (0.0, -1.0, 4.0 * key)), always)
    # A larger one of something 2 m beside the second board.
    world.text.sightings.keep(9, sighting(0, 90.0, 80, (2.0, -1.0, 4.0)), always)
    world.save(tmp_path / "a.lpmap")
    world = LanguageMap.load(tmp_path / "a.lpmap")
    assert len(world.text.sightings) == 2, "what is not remembered is not saved"
    pictures = sign_pictures(world, None, PageConfig())
    assert sorted(pictures) == ["0", "1000"]
    for landmark, size in (("0", 60), ("1000", 61)):
        (address,) = pictures[landmark]
        kind, _, content = address.partition(",")
        assert kind == "data:image/jpeg;base64"
        assert len(base64.b64decode(content)) == size
    assert sign_pictures(world, len(pictures["0"][0]) + 5, PageConfig()).keys() == {"0"}
    assert sign_pictures(small_map(), None, PageConfig()) == {}


def test_the_best_of_each_come_before_second_ones_and_one_keyframe_shows_a_sign_once() -> None:
    world = small_map(signs=("KFC", "ATM"))
    nothing = np.zeros(1, np.float32)
    blank = Features(
        np.zeros((1, 2), np.float32), nothing, nothing, np.zeros(1, bool), np.zeros(1, np.uint8), nothing,
        np.zeros((1, 4), np.uint64),
    )  # fmt: skip
    assert world.slam.add_keyframe(np.linalg.inv(WORLD_FROM_CAMERA), blank, nothing, 1.0, 1, 0) == 1
    for key in (0, 1):
        place = (0.0, -1.0, 4.0 * key)
        for keyframe, seen in ((0, 10.0 + key), (1, 20.0 + key)):
            world.text.sightings.keep(key, sighting(keyframe, seen, 60, place), always)
        # Another line of the same board, of the same keyframe.
        world.text.sightings.keep(7 + key, sighting(0, 5.0, 60, place), always)
    pictures = sign_pictures(world, None, PageConfig())
    assert {key: len(each) for key, each in pictures.items()} == {"0": 2, "1000": 2}
    assert base64.b64decode(pictures["0"][0].partition(",")[2])[-1] == 1, "the largest comes first"
    three = sum(len(address) for each in pictures.values() for address in each) * 3 // 4 + 5
    assert sorted(len(each) for each in sign_pictures(world, three, PageConfig()).values()) == [1, 2]
    assert {len(each) for each in sign_pictures(world, None, PageConfig(pictures=1)).values()} == {1}
