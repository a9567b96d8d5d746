"""A TUM RGB-D folder, written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from lpslam.camera import PinholeCamera
from lpslam.frames import RgbdFrame
from lpslam.sources.images import read_depth
from lpslam.sources.writing.pixels import packed, raw_depth, stamp_of


class FolderSink:
    """A `Sink` for a TUM RGB-D folder; stamps keep their nanoseconds."""

    def __init__(self, folder: Path, camera: PinholeCamera) -> None:
        self._folder, self._camera = folder, camera
        self._lists: dict[str, list[str]] = {"rgb": [], "depth": []}
        self._is_in_metres = False
        for name in self._lists:
            (folder / name).mkdir(parents=True)

    def add(self, frame: RgbdFrame) -> None:
        """See `Sink`."""
        stamp = stamp_of(frame.timestamp)
        self._keep("rgb", f"rgb/{stamp}.png", stamp, packed(".png", frame.rgb[:, :, ::-1]))
        raw = frame.depth if self._is_in_metres else raw_depth(frame.depth, self._camera.depth_scale)
        if raw.dtype == np.float32 and not self._is_in_metres:
            self._change_to_metres()
        suffix = "tiff" if self._is_in_metres else "png"
        self._keep("depth", f"depth/{stamp}.{suffix}", stamp, packed(f".{suffix}", raw))

    def _keep(self, name: str, file: str, stamp: str, data: bytes) -> None:
        (self._folder / file).write_bytes(data)
        self._lists[name].append(f"{stamp} {file}")

    def _change_to_metres(self) -> None:
        """Readings that no whole number of raw units gives: all depth becomes floating point, also what is written."""
        self._is_in_metres = True
        scale, self._camera = self._camera.depth_scale, replace(self._camera, depth_scale=1.0)
        earlier, self._lists["depth"] = self._lists["depth"], []
        for line in earlier:
            stamp, file = line.split()
            depth = read_depth(self._folder / file, scale)
            (self._folder / file).unlink()
            self._keep("depth", f"depth/{stamp}.tiff", stamp, packed(".tiff", depth))

    def finish(self) -> None:
        """See `Sink`."""
        for name, lines in self._lists.items():
            text = "\n".join(["# timestamp filename", *lines]) + "\n"
            (self._folder / f"{name}.txt").write_text(text, encoding="utf-8")
        camera = self._camera
        fields = {name: getattr(camera, name) for name in ("width", "height", "fx", "fy", "cx", "cy")}
        tail = {"distortion": list(camera.distortion), "depth_scale": camera.depth_scale, "fps": camera.fps}
        (self._folder / "camera.yaml").write_text(yaml.safe_dump(fields | tail, sort_keys=False), encoding="utf-8")

    def close(self) -> None:
        """Every file is closed already."""
