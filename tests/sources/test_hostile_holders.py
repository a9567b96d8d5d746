"""Files of many pictures that lie about what they hold, or are made to fill the memory; each is opened once."""

import io
import os
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import h5py
import Imath
import numpy as np
import OpenEXR
import pytest
from PIL import Image
from tests.sources.test_holders import COUNT, HEIGHT, TIMES, WIDTH, K, in_hdf5, in_npz, in_pages, npz_by_frames
from tests.sources.test_holders import colour as colour
from tests.sources.test_holders import depth as depth
from tests.sources.test_holders import in_a_file_for_each_frame as by_frames
from tests.sources.test_holders import video_and_pictures as video

from lpslam.errors import UserError
from lpslam.sources.captures.holders import arrays, pages
from lpslam.sources.images import BadImageError, read_depth, read_raw
from lpslam.sources.open import open_source

Pictures = np.ndarray[tuple[int, ...], np.dtype[Any]]


def header(shape: tuple[int, ...]) -> bytes:
    """Of an `.npy` of sixteen bits."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<u2", "fortran_order": False, "shape": shape})
    return head.getvalue()


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ((2 * 10**9, HEIGHT, WIDTH), "claims to hold 2,000,000,000 pictures"),
        ((COUNT, 60_000, 60_000), "larger than any camera"),
    ],
)
def test_arrays_that_claim_what_no_recording_has_are_one_line(tmp_path: Path, shape: Any, words: str) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["rgb"] = np.zeros((COUNT, HEIGHT, WIDTH, 3), np.uint8)
        file.create_dataset("depth", shape, np.uint16, chunks=(1, HEIGHT, WIDTH))
    with pytest.raises(UserError, match=words):
        open_source(tmp_path / "a.h5")


def test_what_can_be_read_as_a_whole_only_must_fit(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("rgb", (HEIGHT, WIDTH, 3, 900_000), np.uint8, chunks=(HEIGHT, WIDTH, 3, 1))
        file.create_dataset("depth", (HEIGHT, WIDTH, 900_000), np.uint16, chunks=(HEIGHT, WIDTH, 1))
    with pytest.raises(UserError, match="along its first axis"):
        open_source(tmp_path / "a.h5")


def test_matrices_of_a_billion_pictures_are_not_read(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    path = in_hdf5(tmp_path, colour, depth)
    with h5py.File(path, "a") as file:
        file.create_dataset("extra", (10**9, 4, 4), np.float64, chunks=(1000, 4, 4))
        file["/".join("a" * 900)] = 1.0
        file.create_dataset("nothing", data=h5py.Empty("f4"))
        file.attrs["nothing"] = h5py.Empty("f4")
    assert len(list(open_source(path))) == COUNT


@pytest.mark.parametrize("times", [TIMES * np.nan, np.where(TIMES[2] == TIMES, np.inf, TIMES)])
def test_times_that_are_no_numbers_are_not_used(
    tmp_path: Path, times: Pictures, colour: Pictures, depth: Pictures, caplog: pytest.LogCaptureFixture
) -> None:
    np.savez(tmp_path / "a.npz", rgb=colour, depth=depth, K=K, timestamps=times, depth_scale=2000)
    source = open_source(tmp_path / "a.npz")
    assert np.allclose(np.diff(source.timestamps), 1 / 30)
    assert "times that are no numbers" in caplog.text


def test_a_large_archive_of_arrays_stays_on_the_disk(
    tmp_path: Path, colour: Pictures, depth: Pictures, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "_IN_MEMORY", 1000)
    frames = list(open_source(in_npz(tmp_path, colour, depth)))
    assert np.array_equal([frame.rgb for frame in frames], colour)


def test_an_archive_of_arrays_that_unpacks_a_thousandfold_is_one_line(
    tmp_path: Path, colour: Pictures, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arrays, "_IN_MEMORY", 1 << 20)
    count = (80 << 20) // (2 * WIDTH * HEIGHT)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        archive.writestr("depth.npy", header((count, HEIGHT, WIDTH)) + bytes(2 * count * WIDTH * HEIGHT))
    with pytest.raises(UserError, match="unpacks to more than"):
        open_source(tmp_path / "a.npz")


@pytest.mark.parametrize("shape", [(10**7, 10**7), (-1, WIDTH), (2**70, 2)])
def test_a_picture_that_states_more_than_there_is_is_a_fault(
    tmp_path: Path, shape: tuple[int, ...], colour: Pictures, depth: Pictures
) -> None:
    folder = npz_by_frames(tmp_path, colour, depth)
    with zipfile.ZipFile(folder / "depth" / "2.npz", "w") as archive:
        archive.writestr("depth.npy", header(shape) + b"abc")
    source: Any = open_source(folder)
    assert len(list(source)) == COUNT - 1
    assert [fault.index for fault in source.faults] == [2]
    (folder / "2.npy").write_bytes(header(shape) + b"abc")
    with pytest.raises(BadImageError):
        read_depth(folder / "2.npy", 1000.0)


def test_a_damaged_archive_of_one_frame_is_a_fault(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    for index in range(COUNT):
        np.savez_compressed(tmp_path / f"{index}.npz", image=colour[index], depth=depth[index], K=K)
    data = bytearray((tmp_path / "2.npz").read_bytes())
    data[300:340] = bytes(40)
    (tmp_path / "2.npz").write_bytes(data)
    source: Any = open_source(tmp_path)
    assert len(list(source)) == COUNT - 1


def test_a_video_that_claims_days_is_one_line(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    folder = video(tmp_path, colour, depth)
    writer = cv2.VideoWriter(str(folder / "color.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, (WIDTH, HEIGHT))
    for picture in colour:
        writer.write(np.ascontiguousarray(picture))
    writer.release()
    (folder / "color.mkv").unlink()
    data = bytearray((folder / "color.avi").read_bytes())
    # Frames of the first stream, as its header states them.
    at = data.index(b"strh") + 8 + 32
    data[at : at + 4] = (2 * 10**9).to_bytes(4, "little")
    (folder / "color.avi").write_bytes(data)
    with pytest.raises(UserError, match="claims to hold"):
        open_source(folder)


def test_of_many_channels_one_is_unpacked(tmp_path: Path) -> None:
    side, names = 1000, ["Z", *(f"c{number}" for number in range(15))]
    head = OpenEXR.Header(side, side)
    head["channels"] = {name: Imath.Channel(Imath.PixelType(Imath.PixelType.FLOAT)) for name in names}
    file = OpenEXR.OutputFile(str(tmp_path / "a.exr"), head)
    file.writePixels(dict.fromkeys(names, bytes(4 * side * side)))
    file.close()
    tracemalloc.start()
    try:
        assert read_raw(tmp_path / "a.exr").shape == (side, side)
        assert tracemalloc.get_traced_memory()[1] < 20e6
    finally:
        tracemalloc.stop()


def test_links_that_lead_in_circles_are_left_out(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    folder = npz_by_frames(tmp_path, colour, depth)
    for place in (folder, folder / "rgb"):
        (place / "loop.png").symlink_to("loop.png")
        (place / "again").symlink_to(folder, target_is_directory=True)
    assert len(list(open_source(folder))) == COUNT


def test_a_pipe_beside_a_file_of_arrays_holds_nothing_up(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    path = in_npz(tmp_path, colour, depth)
    for ending in (".h5", ".mat", ".txt", ".mp4", ".tif"):
        os.mkfifo(path.with_suffix(ending))
    assert len(list(open_source(path))) == COUNT


def counted(monkeypatch: pytest.MonkeyPatch, place: Any, name: str) -> list[Any]:
    """The first arguments of all calls of a function from now on."""
    called: list[Any] = []
    usual: Callable[..., Any] = getattr(place, name)

    def call(*arguments: Any, **named: Any) -> Any:
        called.append(arguments[0])
        return usual(*arguments, **named)

    monkeypatch.setattr(place, name, call)
    return called


def test_a_file_of_pages_is_not_opened_anew_for_each(
    tmp_path: Path, colour: Pictures, depth: Pictures, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = open_source(in_pages(tmp_path, colour, depth))
    opened = counted(monkeypatch, pages.Image, "open")
    assert len(list(source)) == len(list(source)) == COUNT
    assert not opened


def test_a_page_of_a_damaged_file_is_not_read_in_part(tmp_path: Path) -> None:
    path = tmp_path / "a.tif"
    first, *others = (Image.fromarray(np.full((HEIGHT, WIDTH), 1000 + index, np.uint16)) for index in range(3))
    first.save(path, save_all=True, append_images=others, compression="tiff_lzw")
    with Image.open(path) as image:
        image.seek(1)
        at = image.tag_v2[273][0]  # type: ignore[attr-defined]
    data = bytearray(path.read_bytes())
    data[at : at + 20] = b"\xff" * 20
    path.write_bytes(data)
    (entry,) = pages.entries_of(path)
    for _ in range(2):
        with pytest.raises(ValueError, match="page 1 cannot be read"):
            entry.read(1)
        assert entry.read(2)[0, 0] == 1002


def test_a_file_of_one_frame_is_listed_once(
    tmp_path: Path, colour: Pictures, depth: Pictures, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = open_source(by_frames(tmp_path, colour, depth))
    listed = counted(monkeypatch, arrays, "_entries")
    assert len(list(source)) == COUNT
    assert len(listed) <= COUNT


@pytest.mark.parametrize(("rgb", "far"), [(np.nan, 1.0), (1e300, 1e300)])
def test_fractions_that_are_no_numbers_are_no_pixels(tmp_path: Path, rgb: float, far: float, depth: Pictures) -> None:
    colours = np.full((COUNT, HEIGHT, WIDTH, 3), rgb)
    metres = depth / 2000.0
    metres[:, 0, 0] *= far
    np.savez(tmp_path / "a.npz", rgb=colours, depth=metres, K=K, timestamps=TIMES)
    assert len(list(open_source(tmp_path / "a.npz"))) == COUNT


def test_an_archive_whose_name_is_dots_is_unpacked(tmp_path: Path, colour: Pictures, depth: Pictures) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    npz_by_frames(folder, colour, depth)
    with zipfile.ZipFile(tmp_path / "...zip", "w") as archive:
        for path in folder.rglob("*.*"):
            archive.write(path, path.relative_to(folder))
    assert len(list(open_source(tmp_path / "...zip"))) == COUNT
