"""The same recording in every layout gives the same frames and the same map, bit for bit."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from bag_writers import COLOUR, COLOUR_INFO, DEPTH, DEPTH_INFO, Entry, Types, write

from lpslam import pipeline
from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.sources.open import open_source
from lpslam.sources.writing.recordings import written

pytestmark = pytest.mark.slow

_DEPTH_STREAM, _COLOUR_STREAM = "/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0"
_STILL = "rotation=1,0,0,0,1,0,0,0,1;translation=0,0,0"


def nanoseconds(frame: RgbdFrame) -> int:
    return round(frame.timestamp * 1e9)


def info(types: Types, stamp: int, camera: PinholeCamera) -> Any:
    size = camera.width, camera.height
    return types.info(stamp, k=camera.matrix.ravel(), d=camera.distortion, size=size)


def of_ros(types: Types, frames: list[RgbdFrame], camera: PinholeCamera) -> list[Entry]:
    """Pictures as they come from a driver, depth in metres."""
    entries: list[Entry] = []
    for frame in frames:
        stamp = nanoseconds(frame)
        logged = stamp + 50_000_000
        entries += [
            (COLOUR_INFO, logged, info(types, stamp, camera)),
            (COLOUR, logged, types.image(stamp, frame.rgb, "rgb8")),
            (DEPTH_INFO, logged, info(types, stamp, camera)),
            (DEPTH, logged, types.image(stamp, frame.depth, "32FC1")),
        ]
    return entries


def of_realsense(types: Types, frames: list[RgbdFrame], camera: PinholeCamera) -> list[Entry]:
    """As librealsense 2.59 records: pictures in PNG, what is known of them in words, capture times in milliseconds."""

    def words(text: str) -> Any:
        return types.make("std_msgs/msg/String", text)

    units = f"{1 / camera.depth_scale:.6f}"
    entries: list[Entry] = [("/device_0/sensor_0/option/Depth_Units/value", 0, words(units))]
    entries += [(f"{stream}/tf/ref_1", 0, words(_STILL)) for stream in (_DEPTH_STREAM, _COLOUR_STREAM)]
    for number, frame in enumerate(frames):
        raw = np.rint(frame.depth * camera.depth_scale).astype(np.uint16)
        pictures = (
            (_DEPTH_STREAM, "compressedDepth", "16UC1; compressedDepth png", raw),
            (_COLOUR_STREAM, "compressed", "bgr8; png compressed bgr8", frame.rgb[:, :, ::-1]),
        )
        for stream, kind, text, pixels in pictures:
            # The recorder stamps its messages with when they came, since it began.
            logged = 3_000 + number * 66_000_000 + (number * 7_919) % 1_000
            packed = cv2.imencode(".png", np.ascontiguousarray(pixels))[1].tobytes()
            taken = f"Frame number={number};timestamp={nanoseconds(frame) / 1e6:.6f};"
            entries += [
                (f"{stream}/image/data/{kind}", logged, types.compressed(logged, text, packed)),
                (f"{stream}/image/metadata", logged, words(taken)),
                (f"{stream}/image/camera_info", logged, info(types, logged, camera)),
            ]
    return entries


def test_a_recording_is_the_same_in_every_layout(clip: Callable[[int], Path], tmp_path: Path) -> None:
    folder = clip(8)
    source = open_source(folder)
    frames, camera = list(source), source.camera
    recordings = [
        *(
            write(tmp_path / f"ros.{kind}", lambda types: of_ros(types, frames, camera))
            for kind in ("bag", "db3", "mcap")
        ),
        write(tmp_path / "realsense.db3", lambda types: of_realsense(types, frames, camera)),
    ]
    written(open_source(folder), tmp_path / "converted.mcap")
    recordings.append(tmp_path / "converted.mcap")
    for recording in recordings:
        opened = open_source(recording)
        # What depth was packed in, and how fast the frames came, is the recording's own.
        assert replace(opened.camera, fps=camera.fps, depth_scale=camera.depth_scale) == camera, recording.name
        for frame, expected in zip(opened, frames, strict=True):
            assert (frame.index, frame.timestamp) == (expected.index, expected.timestamp), recording.name
            np.testing.assert_array_equal(frame.rgb, expected.rgb, recording.name)
            np.testing.assert_array_equal(frame.depth, expected.depth, recording.name)
        assert not opened.faults, recording.name
    # Of equal frames come equal maps: of the folder, and of what is stored least like it.
    wanted, found = (pipeline.run(each, sequential=True, text=False) for each in (folder, tmp_path / "ros.bag"))
    np.testing.assert_array_equal(found.frame_poses().timestamps, wanted.frame_poses().timestamps)
    np.testing.assert_array_equal(found.frame_poses().world_from_camera, wanted.frame_poses().world_from_camera)
