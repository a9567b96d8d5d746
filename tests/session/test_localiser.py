"""The camera found in a saved map, a frame at a time."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lpslam
from lpslam import pipeline
from lpslam.errors import UserError
from lpslam.mapfile.language_map import LanguageMap
from lpslam.sources.open import open_source

FRAMES = 12


@pytest.mark.slow
def test_a_frame_at_a_time_gives_the_poses_of_a_whole_recording(begun: Path, walk: Path) -> None:
    whole = pipeline.localise(open_source(walk, max_frames=FRAMES), LanguageMap.load(begun)).poses
    source, world = open_source(walk, max_frames=FRAMES), LanguageMap.load(begun)
    before = world.slam.to_arrays()
    localiser = lpslam.Localiser(source.camera, world)
    steps = [localiser.step(frame.rgb, frame.depth, frame.timestamp) for frame in source]
    localiser.finish()
    assert localiser.poses.world_from_camera.tobytes() == whole.world_from_camera.tobytes()
    assert localiser.frames == FRAMES
    assert steps[-1].pose is not None
    told = [event for step in steps for event in step.events]
    assert told
    assert told == localiser.events[: len(told)]
    after = world.slam.to_arrays()
    assert all(before[name].tobytes() == after[name].tobytes() for name in before)


@pytest.mark.slow
def test_what_is_no_frame_is_refused_and_not_taken(begun: Path, walk: Path) -> None:
    source, world = open_source(walk, max_frames=2), LanguageMap.load(begun)
    with pytest.raises(UserError, match=r"give lpslam\.PinholeCamera"):
        lpslam.Localiser("camera", world)  # type: ignore[arg-type]
    with pytest.raises(UserError, match="camera"):
        lpslam.Localiser(replace(source.camera, fx=2 * source.camera.fx), world)
    localiser = lpslam.Localiser(source.camera, world, text=False)
    first, second = source
    with pytest.raises(UserError, match="grey"):
        localiser.step(first.rgb[:, :, 0], first.depth, 0.0)
    with pytest.raises(UserError, match="metre"):
        localiser.step(first.rgb, np.zeros_like(first.depth) + np.float32(5000.0), 0.0)
    localiser.step(first.rgb, first.depth, first.timestamp)
    with pytest.raises(UserError):
        localiser.step(second.rgb, second.depth, first.timestamp - 1.0)
    assert localiser.frames == 1
