"""What recordings cost beside the map: decoding by layout, large bags, registration, a session's step.

python benchmarks/sources.py reading FOLDER          # a TUM folder, copied as bags, is read and mapped
python benchmarks/sources.py large --gigabytes 10    # first frame and memory; writes to the folder for temporary files
python benchmarks/sources.py registration
python benchmarks/sources.py session FOLDER
"""

import argparse
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer
from rosbags.typesys import Stores, get_typestore

from lpslam import pipeline
from lpslam.camera import PinholeCamera
from lpslam.frames import FrameSource, RgbdFrame
from lpslam.session.session import Session
from lpslam.slam.system import RgbdSlam
from lpslam.slam.warm_up import warm_up
from lpslam.sources.open import open_source
from lpslam.sources.registering.registration import DepthRegistration, DepthRig
from lpslam.sources.writing.recordings import written

COLOUR, DEPTH, INFO = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw", "/camera/color/camera_info"
KINDS = ("bag", "db3", "mcap")
ROUNDS = 3  # of each measurement


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("reading", "session"):
        command = commands.add_parser(name)
        command.add_argument("folder", type=Path)
        command.add_argument("--frames", type=int, default=200)
    command = commands.add_parser("large")
    command.add_argument("--gigabytes", type=float, default=10.0)
    command.add_argument("--kinds", nargs="*", default=KINDS)
    commands.add_parser("registration")
    command = commands.add_parser("_first")
    command.add_argument("path", type=Path)
    options = parser.parse_args()
    if options.command == "reading":
        reading(options.folder, options.frames)
    elif options.command == "session":
        session(options.folder, options.frames)
    elif options.command == "large":
        large(options.gigabytes, options.kinds)
    elif options.command == "registration":
        registration()
    else:
        first(options.path)


def reading(folder: Path, count: int) -> None:
    """Processor time of decoding alone and of a run without reading text, by layout."""
    warm_up(lambda line: None)
    with tempfile.TemporaryDirectory() as place:
        recordings = {"TUM folder": folder}
        source = open_source(folder, max_frames=count)
        written(source, Path(place) / "png")
        recordings["TUM folder, PNG"] = Path(place) / "png"
        written(source, Path(place) / "png.mcap")
        recordings["MCAP, PNG and raw depth"] = Path(place) / "png.mcap"
        for kind in KINDS:
            path = Path(place) / f"raw.{kind}"
            write_raw(path, iter(source), source.camera)
            recordings[f"{kind}, raw"] = path
        works: tuple[Callable[[FrameSource], object], ...] = (
            lambda source: sum(1 for _ in source),
            lambda source: pipeline.run(source, text=False),
        )
        # By turns, so that what else the machine does counts for all alike; the least of each.
        taken = {name: np.full(len(works), np.inf) for name in recordings}
        for _ in range(ROUNDS):
            for at, work in enumerate(works):
                for name, path in recordings.items():
                    begun = time.process_time()
                    work(open_source(path, max_frames=count))
                    taken[name][at] = min(taken[name][at], time.process_time() - begun)
        print("layout | decoding, ms a frame | run --no-text, ms a frame | of the run of the PNG folder")
        for name, each in taken.items():
            decoded, mapped = 1000 * each / count
            print(f"{name} | {decoded:.2f} | {mapped:.2f} | {each[1] / taken['TUM folder, PNG'][1]:.3f}", flush=True)


def large(gigabytes: float, kinds: list[str]) -> None:
    """Seconds to the first frame of a large bag and to one in its middle, and memory after a thousand frames."""
    draw = np.random.default_rng(0)
    camera = PinholeCamera(640, 480, 525.0, 525.0, 319.5, 239.5)
    rgb = draw.integers(0, 255, (480, 640, 3), dtype=np.uint8)
    depth = np.full((480, 640), 2.0, np.float32)
    count = round(gigabytes * 1e9 / (rgb.nbytes + 2 * depth.size))
    frames = (RgbdFrame(number, 1000 + number / 30, rgb, depth) for number in range(count))
    for kind in kinds:
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / f"large.{kind}"
            write_raw(path, frames, camera)
            frames = (RgbdFrame(number, 1000 + number / 30, rgb, depth) for number in range(count))
            print(f"{kind}, {path.stat().st_size / 1e9:.1f} GB, {count} frames")
            subprocess.run([sys.executable, __file__, "_first", str(path)], check=True)


def first(path: Path) -> None:
    """In a process of its own, whose memory is this file's alone."""
    begun, worked = time.perf_counter(), time.process_time()
    source = open_source(path)
    frames = iter(source)
    next(frames)
    taken, work = time.perf_counter() - begun, time.process_time() - worked
    print(f"  first frame after {taken:.2f} s, {work:.2f} s of processor time, {memory():.0f} MB")
    for _ in range(1000):
        if next(frames, None) is None:
            break
    print(f"  after a thousand frames {memory():.0f} MB")
    begun = time.perf_counter()
    assert source.frame(len(source) // 2) is not None
    print(f"  a frame in the middle after {time.perf_counter() - begun:.2f} s", flush=True)


def memory() -> float:
    """The most that this process has held, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def registration() -> None:
    """Milliseconds of registering 640×480 depth into 640×480 colour."""
    pose = np.eye(4)
    pose[:3, 3] = 0.015, -0.001, 0.002
    v, u = np.mgrid[0:480, 0:640]
    depth = (1.2 + 0.002 * u + 0.001 * v).astype(np.float32)
    depth[100:250, 150:300] = 0.8
    for name, lens in (("without lens", (0.0,) * 5), ("with lens", (0.14, -0.3, 0.001, 0.0005, 0.1))):
        depth_camera = PinholeCamera(640, 480, 390.0, 390.0, 320.0, 240.0, lens)
        colour_camera = PinholeCamera(640, 480, 610.0, 612.0, 322.0, 244.0, lens)
        register = DepthRegistration(DepthRig(depth_camera, colour_camera, pose))
        register(depth)
        taken = []
        for _ in range(100):
            begun = clocks()
            register(depth)
            taken.append(clocks() - begun)
        print(f"{name}: {said(taken)} (medians of 100)")


def clocks() -> NDArray[np.float64]:
    """Seconds by the wall, and of this thread's processor time."""
    return np.array([time.perf_counter(), time.thread_time()])


def said(taken: list[NDArray[np.float64]]) -> str:
    """Medians of differences of `clocks`."""
    wall, processor = 1000 * np.median(taken, axis=0)
    return f"{processor:.3f} ms of processor time, {wall:.3f} ms by the wall"


def session(folder: Path, count: int) -> None:
    """What `Session.step` takes around tracking and mapping."""
    warm_up(lambda line: None)
    source = open_source(folder, max_frames=count)
    frames = list(source)
    inside = np.zeros(2)
    process = RgbdSlam.process

    def timed(slam: RgbdSlam, frame: RgbdFrame) -> Any:
        nonlocal inside
        begun = clocks()
        tracked = process(slam, frame)
        inside = clocks() - begun
        return tracked

    RgbdSlam.process = timed  # type: ignore[method-assign]
    around = []
    with Session(source.camera, text=False) as running:
        for frame in frames:
            begun = clocks()
            running.step(frame.rgb, frame.depth, frame.timestamp)
            around.append(clocks() - begun - inside)
    RgbdSlam.process = process  # type: ignore[method-assign]
    print(f"a step around tracking: {said(around)} (medians of {count} frames)")
    by_turns(source.camera, frames)


def by_turns(camera: PinholeCamera, frames: list[RgbdFrame]) -> None:
    """A session and the bare tracker, frame by frame by turns, each with pixels of its own, as a decoder gives them."""
    more = []
    for turn in range(2):
        bare = RgbdSlam(camera)
        with Session(camera, text=False) as running:
            for at, frame in enumerate(frames):
                taken = np.zeros((2, 2))
                for is_session in (0, 1) if (at + turn) % 2 else (1, 0):
                    rgb, depth = frame.rgb.copy(), frame.depth.copy()
                    begun = clocks()
                    if is_session:
                        running.step(rgb, depth, frame.timestamp)
                    else:
                        bare.process(RgbdFrame(at, frame.timestamp, rgb, depth))
                    taken[is_session] = clocks() - begun
                more.append(taken[1] - taken[0])
        bare.finish()
    print(f"a session more than the bare tracker: {said(more)} (medians of {len(more)} frames)")


def write_raw(path: Path, frames: Iterator[RgbdFrame], camera: PinholeCamera) -> None:
    """A bag of uncompressed pictures, as drivers publish them: rgb8, and depth in millimetres."""
    if path.suffix == ".bag":
        with Ros1Writer(path) as writer:
            _fill(writer, Stores.ROS1_NOETIC, frames, camera)
        return
    folder = path.with_suffix("")
    plugin = StoragePlugin.MCAP if path.suffix == ".mcap" else StoragePlugin.SQLITE3
    with Ros2Writer(folder, version=9, storage_plugin=plugin) as writer:
        _fill(writer, Stores.ROS2_HUMBLE, frames, camera)
    next(folder.glob(f"*{path.suffix}")).rename(path)
    shutil.rmtree(folder)


def _fill(writer: Any, kind: Stores, frames: Iterator[RgbdFrame], camera: PinholeCamera) -> None:
    store = get_typestore(kind)
    types = store.types
    is_first = kind == Stores.ROS1_NOETIC
    serialised = store.serialize_ros1 if is_first else store.serialize_cdr
    image, info = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
    topics = {
        name: writer.add_connection(name, kind, typestore=store)
        for name, kind in ((INFO, info), (COLOUR, image), (DEPTH, image))
    }
    projection = np.column_stack([camera.matrix, np.zeros(3)]).ravel()
    lens = np.array(camera.distortion), camera.matrix.ravel(), np.eye(3).ravel(), projection
    region = types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    for frame in frames:
        stamp = round(frame.timestamp * 1e9)
        moment = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        header = types["std_msgs/msg/Header"](*((0,) if is_first else ()), moment, "camera_color_optical_frame")
        raw = np.rint(frame.depth * 1000).astype(np.uint16)
        height, width = raw.shape
        messages = {
            INFO: types[info](header, height, width, "plumb_bob", *lens, 0, 0, region),
            COLOUR: types[image](header, height, width, "rgb8", 0, 3 * width, frame.rgb.ravel()),
            DEPTH: types[image](header, height, width, "16UC1", 0, 2 * width, raw.view(np.uint8).ravel()),
        }
        for name, message in messages.items():
            writer.write(topics[name], stamp, bytes(serialised(message, message.__msgtype__)))


if __name__ == "__main__":
    main()
