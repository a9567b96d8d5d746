"""Map frames of one's own, one at a time, from a queue that a camera's thread fills."""

import queue

import numpy as np

import lpslam

Frame = tuple[np.ndarray, np.ndarray, float]


def map_frames(camera: lpslam.PinholeCamera, frames: "queue.Queue[Frame | None]", output: str) -> None:
    """Take (rgb uint8, depth in metres, seconds) until None comes."""
    with lpslam.Session(camera, on_landmark=lambda mark: print("read:", mark.name)) as session:
        while (frame := frames.get()) is not None:
            step = session.step(*frame)
            where = step.pose[:3, 3].round(2) if step.pose is not None else step.reason
            print(f"{step.timestamp:.2f} s {step.state}: {where}")
    session.close().save(output)


if __name__ == "__main__":
    camera = lpslam.PinholeCamera(640, 480, fx=525.0, fy=525.0, cx=319.5, cy=239.5)
    waiting: "queue.Queue[Frame | None]" = queue.Queue()
    noise = np.random.default_rng(0)
    for number in range(10):
        colour = noise.integers(0, 256, (480, 640, 3), dtype=np.uint8)
        waiting.put((colour, np.full((480, 640), 2.0, np.float32), number / 30.0))
    waiting.put(None)
    map_frames(camera, waiting, "queue.lpmap")
