"""Map what a RealSense camera sees, until Ctrl-C; needs `pip install pyrealsense2`."""

import numpy as np

import lpslam


def map_realsense(rs, output: str) -> None:
    """`rs` is the module pyrealsense2."""
    pipeline, settings = rs.pipeline(), rs.config()
    settings.enable_stream(rs.stream.color, 640, 480, rs.format.rgb8, 30)
    settings.enable_stream(rs.stream.depth, 640, 480, rs.format.z16, 30)
    profile = pipeline.start(settings)
    metres = profile.get_device().first_depth_sensor().get_depth_scale()
    lens = profile.get_stream(rs.stream.color).as_video_stream_profile().get_intrinsics()
    camera = lpslam.PinholeCamera(lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy, tuple(lens.coeffs))
    align = rs.align(rs.stream.color)
    session = lpslam.Session(camera, live=True, on_landmark=lambda mark: print("read:", mark.name))
    try:
        while True:
            frames = align.process(pipeline.wait_for_frames())
            # Copied: the driver uses its buffers again.
            rgb = np.array(frames.get_color_frame().get_data())
            depth = np.asarray(frames.get_depth_frame().get_data()) * np.float32(metres)
            session.step(rgb, depth, frames.get_timestamp() / 1000.0)
    except KeyboardInterrupt:
        session.close(hurry=True).save(output)
    finally:
        pipeline.stop()


if __name__ == "__main__":
    import pyrealsense2

    map_realsense(pyrealsense2, "realsense.lpmap")
