"""A saved map used again: found in, continued, and mapped live; through the library and the command line."""

import hashlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray

from command_line import Command
from lpslam import pipeline
from lpslam.camera import PinholeCamera
from lpslam.config import Config, SpottingConfig
from lpslam.errors import UserError
from lpslam.evaluation.report import evaluate_recording
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.mapfile.language_map import LanguageMap
from lpslam.poses import StampedPoses
from lpslam.simulation.replay import NoisyAgain
from lpslam.slam.state import EventKind
from lpslam.sources.ground_truth import read_ground_truth
from lpslam.sources.open import open_source
from lpslam.sources.seen_by import SeenBy
from lpslam.sources.writing.recordings import written
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.text.types import Recognition

pytestmark = pytest.mark.slow

BEGINNING = 30  # frames that `begun` is made of
OTHER = PinholeCamera(800, 448, 470.0, 472.0, 410.0, 221.0, (0.05, -0.08, 0.001, -0.0005, 0.01))


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def again(walk: Path, frames: int) -> FrameSource:
    """The recording as the sensor sees it another time."""
    return NoisyAgain(open_source(walk, max_frames=frames), seed=4)


def apart(poses: StampedPoses, reference: StampedPoses) -> np.ndarray:
    """(n,) metres between poses and those of the same times, without any alignment."""
    rows = np.abs(reference.timestamps[:, None] - poses.timestamps[None]).argmin(axis=0)
    np.testing.assert_allclose(reference.timestamps[rows], poses.timestamps, atol=1e-3)
    return np.linalg.norm(reference.positions[rows] - poses.positions, axis=1)


def copy_of(walked: Path, folder: Path) -> Path:
    path = folder / "base.lpmap"
    path.write_bytes(walked.read_bytes())
    return path


class CountingSpotter:
    """The real reader, and how often it was asked."""

    def __init__(self) -> None:
        self._spotter = PaddleSpotter(SpottingConfig())
        self.asked = 0

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As `TextSpotter`."""
        self.asked += 1
        return self._spotter.detect(rgb)

    def recognise(self, rgb: NDArray[np.uint8], boxes: NDArray[np.float64]) -> list[Recognition]:
        """As `TextSpotter`."""
        return self._spotter.recognise(rgb, boxes)


# Finding the camera in a map ----------------------------------------------------------------------------------------


def test_frames_are_found_to_two_centimetres_and_signs_are_read_while_the_place_is_not_sure(
    world: LanguageMap, walk: Path
) -> None:
    before = world.slam.to_arrays()
    frames_before = len(world.trajectory)
    spotter = CountingSpotter()
    frames = 60
    found = pipeline.localise(again(walk, frames), world, spotter=spotter)
    assert 1 <= spotter.asked <= 12
    assert found.frames == frames
    assert len(found.poses) >= frames - 3
    error = apart(found.poses, world.frame_poses())
    assert np.median(error) < 0.01
    assert error.max() < 0.04
    assert found.events[0].kind is EventKind.RELOCALISED
    assert found.seconds_tracking > 0
    after = world.slam.to_arrays()
    assert all(before[name].tobytes() == after[name].tobytes() for name in before)
    assert len(world.trajectory) == frames_before


def test_localising_twice_gives_the_same_poses(begun: Path, walk: Path) -> None:
    poses = [pipeline.localise(again(walk, 12), LanguageMap.load(begun)).poses for _ in range(2)]
    assert poses[0].world_from_camera.tobytes() == poses[1].world_from_camera.tobytes()


def test_signs_are_left_unread_where_that_is_asked_for(world: LanguageMap, walk: Path) -> None:
    unread = CountingSpotter()
    assert len(pipeline.localise(again(walk, 12), world, spotter=unread, text=False).poses) >= 12 - 3
    assert unread.asked == 0


def test_in_a_place_that_looks_the_same_and_has_other_signs_the_camera_is_not_found(walked: Path, walk: Path) -> None:
    elsewhere = LanguageMap.load(walked)
    for text_class in elsewhere.text.memory.classes:
        for at, seen in enumerate(text_class.observations):
            other = "".join(chr(ord("a") + (7 * ord(ch) + 3) % 26) for ch in reversed(seen.text))
            text_class.observations[at] = replace(seen, text=other)
    # Every frame is read: a sixth of the walk says it as well.
    found = pipeline.localise(again(walk, 20), elsewhere)
    assert any(event.kind is EventKind.LOST and "signs" in event.reason for event in found.events)
    assert len(found.poses) < 20 / 2
    assert len(pipeline.localise(again(walk, 20), elsewhere, text=False).poses) >= 20 - 3


def test_asked_to_stop_it_gives_what_it_has(world: LanguageMap, walk: Path) -> None:
    seen: list[int] = []
    found = pipeline.localise(
        again(walk, 20),
        world,
        on_progress=lambda progress: seen.append(progress.frames),
        should_stop=lambda: len(seen) >= 6,
    )
    assert seen == [1, 2, 3, 4, 5, 6]
    assert found.frames == len(found.poses) == 6


def test_localize_writes_poses_and_leaves_the_file_alone(
    lpslam: Command, walked: Path, walk: Path, tmp_path: Path
) -> None:
    path, poses = copy_of(walked, tmp_path), tmp_path / "poses.txt"
    before, files = digest(path), sorted(tmp_path.iterdir())
    done = lpslam("run", walk, "--localize", path, "--trajectory", poses, "--max-frames", 20, "--json").json
    assert digest(path) == before
    assert sorted(tmp_path.iterdir()) == sorted([*files, poses])
    written = StampedPoses.from_tum_file(poses)
    assert done["frames"] == 20
    assert done["frames_localised"] == len(written) >= 19
    assert np.median(apart(written, LanguageMap.load(walked).frame_poses())) < 0.01
    assert "camera optical frame in the frame of base.lpmap" in poses.read_text().splitlines()[0]
    shown = lpslam("run", walk, "--localize", path, "--trajectory", poses, "--max-frames", 4)
    assert shown.code == 0
    assert "frames localised" in shown.out


def test_where_nothing_is_found_it_says_so_and_writes_no_pose(
    lpslam: Command, begun: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    import cv2

    recording = clip(6)
    for file in (recording / "rgb").iterdir():
        image = cv2.imread(str(file))
        assert image is not None
        cv2.imwrite(str(file), np.random.default_rng(len(file.name)).integers(60, 70, image.shape, dtype=np.uint8))
    done = lpslam("run", recording, "--localize", begun, "--trajectory", tmp_path / "none.txt", "--json")
    assert "none of 2 frames is found" in done.complaint
    assert not (tmp_path / "none.txt").exists()


# Letting a map grow --------------------------------------------------------------------------------------------------


def test_a_continued_map_keeps_what_it_had_and_grows(begun: Path, walk: Path, tmp_path: Path) -> None:
    base = LanguageMap.load(begun)
    old = LanguageMap.load(begun)
    frames = 2 * BEGINNING
    grown = pipeline.run(again(walk, frames), text=False, base=base)
    keyframes = old.slam.keyframe_count
    assert grown.slam.keyframe_count > keyframes
    assert set(grown.slam.submaps().tolist()) == {0}
    np.testing.assert_array_equal(grown.slam.timestamps()[:keyframes], old.slam.timestamps())
    # Old keyframes stay where they were, to what adjusting with new views may change.
    kept = [k for k in old.slam.living_keyframes().tolist() if grown.slam.is_alive(k)]
    assert len(kept) > 0.7 * len(old.slam.living_keyframes())
    moved = [
        np.linalg.norm((grown.slam.world_from_keyframe(k) - old.slam.world_from_keyframe(k))[:3, 3])
        for k in range(keyframes)
    ]
    assert max(moved) < 0.03
    # Each recording has its own frames.
    assert (grown.trajectory.session, grown.trajectory.frame_count) == (1, frames)
    assert grown.trajectory.tracked_count >= frames - 3
    assert grown.statistics["run"]["frames_tracked"] == grown.trajectory.tracked_count
    indices = grown.trajectory.to_arrays()["index"]
    assert len(set(indices.tolist())) == len(indices) == BEGINNING + frames
    first = StampedPoses(*grown.trajectory.world_from_camera(grown.slam, 0))
    assert len(first) == BEGINNING
    assert apart(first, old.frame_poses()).max() < 0.03
    # Where both recordings went, they agree: for one is the other seen again.
    both = StampedPoses(*(column[: BEGINNING - 4] for column in grown.trajectory.world_from_camera(grown.slam)))
    assert apart(both, first).max() < 0.03
    scores = evaluate_recording(grown, walk)
    assert scores.frames_mapped == frames
    assert scores.ate.rmse < 0.02
    # And it is a map like any other.
    grown.save(tmp_path / "grown.lpmap")
    twice = LanguageMap.load(tmp_path / "grown.lpmap")
    assert twice.trajectory.session == 1
    np.testing.assert_array_equal(twice.frame_poses().world_from_camera, grown.frame_poses().world_from_camera)


def test_continue_keeps_old_landmarks_and_its_input(
    lpslam: Command, walked: Path, walk: Path, world: LanguageMap, tmp_path: Path
) -> None:
    base, output = copy_of(walked, tmp_path), tmp_path / "grown.lpmap"
    before = digest(base)
    words = ["run", walk, "--continue", base, "-o", output, "--no-text", "--max-frames", 12, "--json"]
    done = lpslam(*words, "--trajectory", tmp_path / "poses.txt")
    assert digest(base) == before
    facts = done.json
    assert facts["frames"] == 12
    assert facts["frames_tracked"] >= 11
    grown = LanguageMap.load(output)
    old = {mark.id: mark for mark in world.landmarks()}
    new = {mark.id: mark for mark in grown.landmarks()}
    assert old.keys() <= new.keys()
    for number, mark in old.items():
        assert new[number].name == mark.name
        assert np.linalg.norm(new[number].position - mark.position) < 0.05
    assert len(StampedPoses.from_tum_file(tmp_path / "poses.txt")) == facts["frames_tracked"]


def test_the_frames_that_were_not_tracked_are_counted_in_this_recording_only(
    lpslam: Command, begun: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    """Not among all that the map has ever seen."""
    import cv2

    recording = clip(24)
    # To the end: what is seen again after a moment has a pose.
    for file in sorted((recording / "rgb").iterdir())[18:]:
        cv2.imwrite(str(file), np.random.default_rng(int(file.stat().st_size)).integers(20, 24, (480, 640, 3)))
    for file in sorted((recording / "depth").iterdir())[18:]:
        cv2.imwrite(str(file), np.zeros((480, 640), np.uint16))
    done = lpslam("run", recording, "--continue", begun, "-o", tmp_path / "grown.lpmap", "--no-text", "--json")
    untracked = done.json["frames"] - done.json["frames_tracked"]
    assert done.json["frames"] == 24
    assert 4 <= untracked <= 8
    assert f"lpslam: {untracked} frames not tracked; the first, frame" in done.err


# Mistakes -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--localize", "MAP", "-o", "OUT", "--trajectory", "POSES"], "--localize and --output exclude each other"),
        (["--localize", "MAP", "--continue", "MAP", "--trajectory", "POSES"], "--localize and --continue exclude"),
        (["--localize", "MAP", "--live", "--trajectory", "POSES"], "--localize and --live exclude each other"),
        (["--localize", "MAP"], "give --trajectory OUT.txt with --localize"),
        (["--continue", "MAP"], "where should the map go?"),
        ([], "where should the map go?"),
        (["--continue", "MAP", "-o", "MAP"], "is the map that is read, which is not overwritten"),
        (["--continue", "MAP", "-o", "OUT", "--trajectory", "MAP"], "is the map that is read"),
        (["--localize", "MAP", "--trajectory", "MAP"], "--trajectory"),
        (["--localize", "MAP", "--trajectory", "LINK"], "is the map that is read"),
        (["-o", "OUT", "--trajectory", "OUT"], "--output and --trajectory are both"),
        (["-o", "OUT", "--live", "--sequential"], "--live and --sequential exclude each other"),
        (["--localize", "MAP", "--trajectory", "nowhere/poses.txt"], "does not exist; make it first"),
        (["--localize", "MAP", "--trajectory", "."], "it is a folder"),
        (["--localize", "missing.lpmap", "--trajectory", "POSES"], "missing.lpmap"),
        (["--continue", "missing.lpmap", "-o", "OUT"], "missing.lpmap"),
    ],
)
def test_options_that_contradict_each_other_are_refused_before_anything_is_done(
    lpslam: Command,
    begun: Path,
    walk: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: list[str],
    said: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    base = copy_of(begun, tmp_path)
    (tmp_path / "link.txt").symlink_to(base)
    before, files = digest(base), sorted(tmp_path.iterdir())
    names = {"MAP": base, "OUT": tmp_path / "out.lpmap", "POSES": tmp_path / "poses.txt", "LINK": tmp_path / "link.txt"}
    assert said in lpslam("run", walk, *[names.get(word, word) for word in words]).complaint
    assert digest(base) == before
    assert sorted(tmp_path.iterdir()) == files


@pytest.mark.parametrize("option", ["--localize", "--continue"])
def test_a_camera_that_sees_too_little_of_a_map_is_refused(
    lpslam: Command, begun: Path, clip: Callable[[int], Path], tmp_path: Path, option: str
) -> None:
    recording = clip(3)
    camera = yaml.safe_load((recording / "camera.yaml").read_text())
    camera["fx"], camera["fy"] = 2.5 * camera["fx"], 2.5 * camera["fy"]
    (recording / "camera.yaml").write_text(yaml.safe_dump(camera))
    result = tmp_path / "result"
    where = ["--trajectory" if option == "--localize" else "-o", result]
    done = lpslam("run", recording, option, begun, *where)
    assert done.code == 2
    assert f"{begun} was made with another camera: its fx is " in done.err
    assert "shows 16% of that one's picture" in done.err
    assert not result.exists()


@pytest.mark.parametrize(
    ("features", "said"), [({"count": 3000}, "keypoints a frame"), ({"levels": 6}, "pyramid levels")]
)
def test_keypoints_that_do_not_fit_the_map_are_refused(
    lpslam: Command, begun: Path, walk: Path, tmp_path: Path, features: dict[str, int], said: str
) -> None:
    config = tmp_path / "config.yaml"
    config.write_text(yaml.safe_dump({"slam": {"features": features}}))
    words = ["--continue", begun, "-o", tmp_path / "grown.lpmap", "--no-text", "--config", config]
    assert said in lpslam("run", walk, *words).err
    settings = Config.model_validate({"slam": {"features": features}})
    with pytest.raises(UserError, match=said):
        pipeline.run(again(walk, 3), settings, text=False, base=LanguageMap.load(begun))


# Live ----------------------------------------------------------------------------------------------------------------


class Slowly:
    """A recording at half its pace, so that a busy machine can follow."""

    def __init__(self, source: FrameSource) -> None:
        self._source = source
        self.name, self.camera, self.faults = source.name, source.camera, source.faults

    def __len__(self) -> int:
        return len(self._source)

    def __iter__(self) -> Iterator[RgbdFrame]:
        return (replace(frame, timestamp=2 * frame.timestamp) for frame in self._source)


def test_a_live_run_tracks_what_it_is_given_and_counts_the_rest(walk: Path) -> None:
    frames = 45
    world = pipeline.run(Slowly(open_source(walk, max_frames=frames)), live=True, text=False)
    run, seconds = world.statistics["run"], 2 * frames / 15
    assert run["frames"] + run["frames_dropped"] == frames
    assert run["frames"] >= frames / 3, "a machine on which this fails cannot map live"
    assert run["frames_tracked"] >= 0.9 * run["frames"]
    # It takes as long as the recording, and does not go on for much longer.
    assert seconds - 0.2 < run["seconds"] < seconds + 4
    truth = read_ground_truth(walk)
    assert truth is not None
    poses = world.frame_poses()
    estimate = StampedPoses(poses.timestamps / 2, poses.world_from_camera)
    assert absolute_trajectory_error(truth, estimate).rmse < 0.03
    assert set(world.slam.submaps().tolist()) == {0}


def test_live_on_the_command_line_with_a_map_to_continue(
    lpslam: Command, begun: Path, walk: Path, tmp_path: Path
) -> None:
    output = tmp_path / "live.lpmap"
    words = ["run", walk, "--live", "--continue", begun, "-o", output, "--no-text", "--max-frames", 30, "--json"]
    facts = lpslam(*words).json
    assert 5 <= facts["frames"] <= 30
    assert facts["frames_tracked"] >= 0.8 * facts["frames"]
    assert LanguageMap.load(output).trajectory.session == 1


def test_pictures_are_not_enlarged_to_those_of_any_map(begun: Path, walk: Path) -> None:
    """A map says what camera made it: one of 64 million pixels would take gigabytes."""
    world = LanguageMap.load(begun)
    world.camera = replace(world.camera, width=8000, height=8000)
    with pytest.raises(UserError, match="cannot be enlarged"):
        pipeline.localise(again(walk, 3), world, text=False)


def test_frames_of_another_camera_are_used_as_that_of_the_map_would_see_them(
    lpslam: Command, begun: Path, walk: Path, tmp_path: Path
) -> None:
    """A lens that is wider, in pictures of another shape, with its middle elsewhere."""
    other, poses, world = tmp_path / "other", tmp_path / "poses.txt", LanguageMap.load(begun)
    written(SeenBy(again(walk, 12), OTHER), other)
    done = lpslam("run", other, "--localize", begun, "--trajectory", poses, "--no-text", "--json")
    assert f"{begun} was made with another camera: its images are " in done.err
    assert "; frames are resampled to it, of which they show " in done.err
    assert done.json["frames_localised"] >= 11
    error = apart(StampedPoses.from_tum_file(poses), world.frame_poses())
    assert np.median(error) < 0.01
    assert error.max() < 0.04
    grown = pipeline.run(open_source(other), text=False, base=world)
    assert grown.trajectory.tracked_count >= 11


def test_a_map_grows_by_its_own_calibration_only_and_is_read_by_one_much_like_it(
    lpslam: Command, begun: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    """Its keyframes would be adjusted by a calibration that they were not made with, so frames are resampled to it."""
    recording = clip(3)
    camera = yaml.safe_load((recording / "camera.yaml").read_text())
    camera["cx"] += 2.0
    (recording / "camera.yaml").write_text(yaml.safe_dump(camera))
    grown = tmp_path / "grown.lpmap"
    assert ": its cx is " in lpslam("run", recording, "--continue", begun, "-o", grown, "--no-text").err
    assert LanguageMap.load(grown).camera == LanguageMap.load(begun).camera
    poses = tmp_path / "poses.txt"
    done = lpslam("run", recording, "--localize", begun, "--trajectory", poses, "--no-text")
    assert done.code == 0
    assert "another camera" not in done.err


def test_localisation_says_which_frames_it_could_not_use(
    lpslam: Command, walked: Path, clip: Callable[[int], Path], tmp_path: Path
) -> None:
    recording = clip(6)
    sorted((recording / "rgb").iterdir())[3].write_bytes(b"torn")
    done = lpslam("run", recording, "--localize", walked, "--trajectory", tmp_path / "poses.txt")
    assert done.code == 0
    assert "1 frame skipped; the first, frame 3: " in done.err
