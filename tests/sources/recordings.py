"""Small recordings written on the spot, for tests of the readers."""

from pathlib import Path

import cv2
import numpy as np

WIDTH, HEIGHT = 64, 48
CAMERA_YAML = "fx: 50.0\nfy: 51.0\ncx: 31.5\ncy: 23.5\nwidth: 64\nheight: 48\ndepth_scale: 5000\n"


def picture(seed: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """A noise picture in the order red, green, blue."""
    return np.random.default_rng(seed).integers(0, 255, (height, width, 3), dtype=np.uint8)


def raw_depth(seed: int, width: int = WIDTH, height: int = HEIGHT) -> np.ndarray:
    """Raw depth with a stripe of zeros."""
    raw = np.random.default_rng(seed).integers(1, 40000, (height, width), dtype=np.uint16)
    raw[:, :5] = 0
    return raw


def write_tum(folder: Path, frames: int = 5, camera: str | None = CAMERA_YAML) -> Path:
    """A TUM folder at 30 Hz whose depth comes 5 ms after its colour."""
    (folder / "rgb").mkdir(parents=True)
    (folder / "depth").mkdir()
    colours, depths = ["# colour", "# timestamp filename"], ["# depth"]
    for i in range(frames):
        cv2.imwrite(str(folder / f"rgb/{i}.png"), picture(i)[:, :, ::-1])
        cv2.imwrite(str(folder / f"depth/{i}.png"), raw_depth(i))
        colours.append(f"{100 + i / 30:.6f} rgb/{i}.png")
        depths.append(f"{100 + i / 30 + 0.005:.6f} depth/{i}.png")
    (folder / "rgb.txt").write_text("\n".join(colours) + "\n")
    (folder / "depth.txt").write_text("\n".join(depths) + "\n")
    if camera is not None:
        (folder / "camera.yaml").write_text(camera)
    return folder


def write_seven_scenes(folder: Path, frames: int = 4, size: tuple[int, int] = (WIDTH, HEIGHT)) -> Path:
    """A 7-Scenes folder whose camera moves 0.1 m a frame along x."""
    folder.mkdir(parents=True)
    for i in range(frames):
        cv2.imwrite(str(folder / f"frame-{i:06d}.color.png"), picture(i, *size)[:, :, ::-1])
        cv2.imwrite(str(folder / f"frame-{i:06d}.depth.png"), raw_depth(i, *size))
        pose = np.eye(4)
        pose[0, 3] = 0.1 * i
        np.savetxt(folder / f"frame-{i:06d}.pose.txt", pose)
    return folder
