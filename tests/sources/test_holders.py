"""Pictures that lie with many others in one file: arrays, videos, OpenEXR; and what is hostile in them."""

import io
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import av
import cv2
import h5py
import numpy as np
import OpenEXR
import pytest
import scipy.io
import yaml
from numpy.typing import NDArray
from PIL import Image

from lpslam.errors import UserError
from lpslam.sources.open import open_source

COUNT, WIDTH, HEIGHT = 5, 64, 48
K = np.array([[70.0, 0.0, 31.0], [0.0, 71.0, 24.0], [0.0, 0.0, 1.0]])
TIMES = 1.7e9 + np.arange(COUNT) / 10.0
LENS = {"fx": 70, "fy": 71, "cx": 31, "cy": 24, "width": WIDTH, "height": HEIGHT, "depth_scale": 2000}


@pytest.fixture
def colour() -> NDArray[np.uint8]:
    noise = np.random.default_rng(3).integers(0, 255, (COUNT, HEIGHT, WIDTH, 3), np.uint8)
    return np.stack([cv2.GaussianBlur(each, (9, 9), 3) for each in noise]).astype(np.uint8)


@pytest.fixture
def depth() -> NDArray[np.uint16]:
    ramp = np.linspace(2000, 5000, WIDTH)[None, :] + 10 * np.arange(HEIGHT)[:, None]
    return np.stack([ramp + 100 * index for index in range(COUNT)]).astype(np.uint16)


Write = Callable[[Path, NDArray[np.uint8], NDArray[np.uint16]], Path]


def in_npz(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    np.savez_compressed(folder / "a.npz", rgb=colour, depth=depth, K=K, timestamps=TIMES, depth_scale=2000)
    return folder / "a.npz"


def in_npy(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    np.save(folder / "colors.npy", np.moveaxis(colour, -1, 1))
    np.save(folder / "depths.npy", depth)
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    (folder / "times.txt").write_text("\n".join(f"{time:.6f}" for time in TIMES))
    return folder


def in_hdf5(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    with h5py.File(folder / "a.h5", "w") as file:
        file["camera/color/data"], file["camera/depth/data"] = colour, depth
        file["camera/color/intrinsics"] = np.repeat(K[None], COUNT, axis=0)
        file["camera/timestamps_ns"] = np.round(TIMES * 1e9).astype(np.int64)
        file["camera/depth"].attrs["depth_unit"] = "0.5 mm"
    return folder / "a.h5"


def in_hdf5_by_frames(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    with h5py.File(folder / "a.hdf5", "w") as file:
        for index in range(COUNT):
            file[f"rgb/{index}"], file[f"depth/{index}"] = colour[index], depth[index]
        file["time"] = TIMES
        file.attrs["depth_scale"], file["K"] = 2000.0, K
    return folder / "a.hdf5"


def in_a_file_for_each_frame(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    for index in range(COUNT):
        with h5py.File(folder / f"{index + 8}.hdf5", "w") as file:
            file["colors"], file["depth"] = colour[index], depth[index]
            file["segmentation"] = np.zeros((HEIGHT, WIDTH), np.uint8)
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    (folder / "times.txt").write_text("\n".join(f"{time:.6f}" for time in TIMES))
    return folder


def in_an_archive_for_each_frame(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    for index in range(COUNT):
        np.savez(folder / f"frame{index + 8}.npz", image=colour[index], depth=depth[index])
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    (folder / "times.txt").write_text("\n".join(f"{time:.6f}" for time in TIMES))
    return folder


def in_pages(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    for name, pictures in (("colour_stack", colour), ("depth_stack", depth)):
        first, *others = (Image.fromarray(picture) for picture in pictures)
        first.save(folder / f"{name}.tif", save_all=True, append_images=others)
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    (folder / "times.txt").write_text("\n".join(f"{time:.6f}" for time in TIMES))
    return folder


def in_hdf5_encoded(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    with h5py.File(folder / "a.h5", "w") as file:
        for name, pictures in (("rgb", colour[..., ::-1]), ("depth", depth)):
            kept = file.create_dataset(name, (COUNT,), h5py.vlen_dtype(np.uint8))
            for index, picture in enumerate(pictures):
                kept[index] = cv2.imencode(".png", picture)[1].ravel()
        file["time"], file["K"], file["depth_scale"] = TIMES, K, 2000.0
    return folder / "a.h5"


def in_matlab(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    whole = {"rgb": np.moveaxis(colour, 0, -1), "depth": np.moveaxis(depth, 0, -1), "K": K, "depth_scale": 2000.0}
    scipy.io.savemat(folder / "a.mat", {**whole, "timestamps": TIMES})
    return folder / "a.mat"


def in_new_matlab(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    """MATLAB writes HDF5 with its axes in reversed order."""
    with h5py.File(folder / "a.mat", "w", userblock_size=512) as file:
        whole = {"images": np.moveaxis(colour, 0, -1), "depths": np.moveaxis(depth, 0, -1), "K": K, "time": TIMES}
        for name, array in (*whole.items(), ("depth_scale", np.array([[2000.0]]))):
            file[name] = array.T
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    with (folder / "a.mat").open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file")
    return folder / "a.mat"


def in_videos(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    for name, pictures, kind in (("color.mkv", colour, "rgb24"), ("depth.mkv", depth, "gray16le")):
        with av.open(str(folder / name), "w") as file:
            track: Any = file.add_stream("ffv1", rate=10)
            track.width, track.height, track.pix_fmt = WIDTH, HEIGHT, "bgr0" if kind == "rgb24" else kind
            for picture in pictures:
                frame = av.VideoFrame.from_ndarray(picture, format=kind)
                file.mux(track.encode(frame.reformat(format=track.pix_fmt)))
            file.mux(track.encode())
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    return folder


def video_and_pictures(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    in_videos(folder, colour, depth)
    (folder / "depth.mkv").unlink()
    (folder / "depth").mkdir()
    for index, picture in enumerate(depth):
        cv2.imwrite(str(folder / "depth" / f"{index:05d}.png"), picture)
    (folder / "timestamps.csv").write_text("frame,timestamp\n" + "".join(f"{i},{t:.6f}\n" for i, t in enumerate(TIMES)))
    return folder


def npz_by_frames(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    for name in ("rgb", "depth"):
        (folder / name).mkdir()
    for index in range(COUNT):
        cv2.imwrite(str(folder / "rgb" / f"{index}.png"), colour[index][..., ::-1])
        np.savez(folder / "depth" / f"{index}.npz", depth=depth[index], timestamp=TIMES[index])
    (folder / "camera.yaml").write_text(yaml.safe_dump(LENS))
    return folder


def in_exr(folder: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]) -> Path:
    """Depth in metres and half as large, which the calibration says."""
    for name in ("rgb", "depth"):
        (folder / name).mkdir()
    for index in range(COUNT):
        cv2.imwrite(str(folder / "rgb" / f"{index}.png"), colour[index][..., ::-1])
        metres = (depth[index, ::2, ::2] / 2000.0).astype(np.float32)
        OpenEXR.File({"type": OpenEXR.scanlineimage}, {"R": metres}).write(str(folder / "depth" / f"{index}.exr"))
    stated = {**LENS, "dw": WIDTH // 2, "dh": HEIGHT // 2, "frameTimestamps": TIMES.tolist()}
    (folder / "metadata.json").write_text(yaml.safe_dump(stated))
    return folder


FORMS: tuple[Write, ...] = (
    *(in_npz, in_npy, in_hdf5, in_hdf5_by_frames, in_hdf5_encoded, in_matlab, in_new_matlab),
    *(
        in_videos,
        video_and_pictures,
        npz_by_frames,
        in_exr,
        in_a_file_for_each_frame,
        in_an_archive_for_each_frame,
        in_pages,
    ),
)


@pytest.mark.parametrize("write", FORMS, ids=lambda write: str(write.__name__))
def test_every_form_gives_the_same_frames(
    write: Write, tmp_path: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]
) -> None:
    source = open_source(write(tmp_path, colour, depth))
    frames = list(source)
    assert len(frames) == COUNT
    camera = source.camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (70.0, 71.0, 31.0, 24.0)
    assert (camera.width, camera.height) == (WIDTH, HEIGHT)
    for index, frame in enumerate(frames):
        assert np.array_equal(frame.rgb, colour[index])
        if write is not in_exr:
            assert np.allclose(frame.depth, depth[index] / 2000.0, atol=1e-4)
        assert np.median(frame.depth) == pytest.approx(np.median(depth[index]) / 2000.0, abs=0.03)
    assert np.allclose(np.diff([frame.timestamp for frame in frames]), 1 / 30 if write is in_exr else 0.1, atol=1e-3)
    again = source.frame(1)
    assert again is not None
    assert np.array_equal(again.rgb, colour[1])


class _Program:
    def __reduce__(self) -> tuple[Any, ...]:
        return (Path.touch, (Path("executed"),))


def pickled(folder: Path) -> Path:
    np.savez(folder / "a.npz", rgb=np.array([_Program()], object), depth=np.array([_Program()], object))
    return folder / "a.npz"


def pickled_picture(folder: Path) -> Path:
    np.save(folder / "color.npy", np.array([_Program()], object))
    (folder / "depth.npy").write_bytes(pickle.dumps(_Program()))
    return folder


def linked_elsewhere(folder: Path) -> Path:
    with h5py.File(folder / "other.h5", "w") as file:
        file["rgb"] = np.zeros((3, 48, 64, 3), np.uint8)
    with h5py.File(folder / "a.h5", "w") as file:
        file["rgb"] = h5py.ExternalLink("other.h5", "/rgb")
        file.create_dataset("depth", (3, 48, 64), np.uint16, external=[("/etc/hostname", 0, h5py.h5f.UNLIMITED)])
    return folder / "a.h5"


def boundless(folder: Path) -> Path:
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<u2", "fortran_order": False, "shape": (9**9, 480, 640)})
    with zipfile.ZipFile(folder / "a.npz", "w") as archive:
        archive.writestr("depth.npy", head.getvalue())
    return folder / "a.npz"


def cut_off(folder: Path) -> Path:
    with h5py.File(folder / "whole.h5", "w") as file:
        file["rgb"], file["depth"] = np.ones((9, 48, 64, 3), np.uint8), np.ones((9, 48, 64), np.uint16)
    (folder / "a.h5").write_bytes((folder / "whole.h5").read_bytes()[:900])
    return folder / "a.h5"


def no_arrays(folder: Path) -> Path:
    (folder / "a.mat").write_text("rgb = 1")
    return folder / "a.mat"


def a_playlist(folder: Path) -> Path:
    (folder / "color.mp4").write_text("#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:1/a.ts\n")
    np.save(folder / "depth.npy", np.full((3, 48, 64), 1000, np.uint16))
    return folder


def eight_bits_of_depth(folder: Path) -> Path:
    in_videos(folder, np.zeros((3, HEIGHT, WIDTH, 3), np.uint8), np.ones((3, HEIGHT, WIDTH), np.uint16))
    (folder / "color.mkv").rename(folder / "depth.mkv")
    return folder


@pytest.mark.parametrize(
    ("write", "words"),
    [
        (pickled, "objects of Python"),
        (pickled_picture, "is no recording"),
        (linked_elsewhere, "is a file"),
        (boundless, "claims to hold"),
        (cut_off, "no arrays that can be read"),
        (no_arrays, "no arrays that can be read"),
        (a_playlist, "is no video"),
        (eight_bits_of_depth, "is called depth, and its pictures are"),
    ],
    ids=lambda each: each.__name__ if callable(each) else "",
)
def test_what_is_hostile_or_damaged_is_one_line(
    write: Callable[[Path], Path], words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=words) as refusal:
        open_source(write(tmp_path))
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "executed").exists()


def test_a_video_that_ends_early_loses_its_last_frames_alone(
    tmp_path: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]
) -> None:
    folder = video_and_pictures(tmp_path, colour, depth)
    whole = (folder / "color.mkv").read_bytes()
    (folder / "color.mkv").write_bytes(whole[: len(whole) * 3 // 4])
    source = open_source(folder)
    assert 1 <= len(list(source)) < COUNT


def test_a_page_that_is_damaged_is_a_fault_and_nothing_else(
    tmp_path: Path, colour: NDArray[np.uint8], depth: NDArray[np.uint16]
) -> None:
    folder = in_pages(tmp_path, colour, depth)
    path = folder / "depth_stack.tif"
    data = path.read_bytes()
    path.write_bytes(data[: len(data) * 3 // 5])
    try:
        frames = list(open_source(folder))
    except UserError:
        return
    assert len(frames) < COUNT
