"""Synthetic rigid motions, views of points and maps, for tests of the SLAM parts."""

from collections.abc import Iterator

import numpy as np
from hypothesis import strategies as st

from lpslam.camera import PinholeCamera, inverse_transform, transform_points
from lpslam.config import CalibrationCheckConfig, FocalCheckConfig, RegistrationCheckConfig, SlamConfig
from lpslam.slam.features import Features
from lpslam.slam.kernels.geometry import exponential
from lpslam.slam.kernels.graph import MapColumns
from lpslam.slam.map import SlamMap
from lpslam.slam.sensor import SensorModel

CAMERA = PinholeCamera(width=640, height=480, fx=525.0, fy=520.0, cx=318.2, cy=243.7)
SENSOR = SensorModel.of(CAMERA, SlamConfig())
BASELINE_FX = float(SENSOR.intrinsics[4])

UNCHECKED = CalibrationCheckConfig(focal=FocalCheckConfig(pairs=0), registration=RegistrationCheckConfig(frames=0))
"""For recordings that are opened for what they show, and not for whether their calibration is right."""

LOOKING_AHEAD = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
"""world_from_camera of a camera at the origin that looks along x, with z up."""


def rigid(translation: list[float], rotation: list[float]) -> np.ndarray:
    """The 4×4 motion of a twist: translation part in metres, rotation vector in radians."""
    return exponential(np.array([*translation, *rotation], dtype=np.float64))


def twists(distance: float = 3.0, angle: float = 3.0) -> st.SearchStrategy[np.ndarray]:
    """Twists whose parts are below the given metres and radians."""
    metres = st.floats(-distance, distance)
    radians = st.floats(-angle / 3**0.5, angle / 3**0.5)
    return st.tuples(metres, metres, metres, radians, radians, radians).map(np.array)


def rotation_angle(rotation: np.ndarray) -> float:
    """Radians by which a 3×3 rotation turns."""
    skew = (rotation - rotation.T) / 2
    sine = np.linalg.norm([skew[2, 1], skew[0, 2], skew[1, 0]])
    return float(np.arctan2(sine, (np.trace(rotation) - 1) / 2))


def pose_error(estimate: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """Metres and radians between two 4×4 poses."""
    apart = estimate @ inverse_transform(truth)
    return float(np.linalg.norm(apart[:3, 3])), rotation_angle(apart[:3, :3])


def points_ahead(random: np.random.Generator, count: int, near: float = 1.0, far: float = 5.0) -> np.ndarray:
    """(n, 3) points in the optical frame that fill the image between two depths."""
    pixels = random.uniform([20, 20], [CAMERA.width - 20, CAMERA.height - 20], (count, 2))
    return CAMERA.back_project(pixels, random.uniform(near, far, count))


def disparities(depths: np.ndarray) -> np.ndarray:
    """u − u_r of depths in metres."""
    return (BASELINE_FX / depths).astype(np.float32)


def features_at(
    pixels: np.ndarray,
    depths: np.ndarray,
    descriptors: np.ndarray,
    octaves: np.ndarray | None = None,
    angles: np.ndarray | None = None,
) -> Features:
    """Keypoints at pixels (n, 2) with depths (n,), 0 where there is none, and descriptors (n, 4)."""
    depths = np.asarray(depths, np.float32)
    has_depth = depths > 0
    disparity = np.where(has_depth, BASELINE_FX / np.where(has_depth, depths, 1.0), 0.0)
    return Features(
        pixels=np.asarray(pixels, np.float32),
        u_right=(pixels[:, 0] - disparity).astype(np.float32),
        depth=depths,
        has_depth=has_depth,
        octave=np.zeros(len(depths), np.uint8) if octaves is None else octaves.astype(np.uint8),
        angle=np.zeros(len(depths), np.float32) if angles is None else angles.astype(np.float32),
        descriptor=descriptors,
    )


def descriptors_of(random: np.random.Generator, count: int) -> np.ndarray:
    """(n, 4) random descriptors; any two differ by about 128 bits."""
    return random.integers(0, 2**64, (count, 4), dtype=np.uint64)


def flip_bits(random: np.random.Generator, descriptors: np.ndarray, bits: int) -> np.ndarray:
    """The descriptors with `bits` different bits of each flipped."""
    flipped = np.unpackbits(descriptors.view(np.uint8), axis=1)
    where = np.argsort(random.random(flipped.shape), axis=1)[:, :bits]
    np.put_along_axis(flipped, where, 1 - np.take_along_axis(flipped, where, axis=1), axis=1)
    return np.packbits(flipped, axis=1).view(np.uint64)


def hamming_table(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(n, m) differing bits of descriptors a (n, 4) and b (m, 4), by the definition."""
    bits = [np.unpackbits(np.ascontiguousarray(d).view(np.uint8), axis=1).astype(np.int32) for d in (a, b)]
    return bits[0].sum(1)[:, None] + bits[1].sum(1)[None] - 2 * bits[0] @ bits[1].T


def add_view(slam_map: SlamMap, camera_from_world: np.ndarray, features: Features, parent: int) -> int:
    """Add a keyframe one second after the one before."""
    number = slam_map.keyframe_count
    information = SENSOR.disparity_information(features.depth)
    return slam_map.add_keyframe(camera_from_world, features, information, float(number), 10 * number, parent)


def view_of(camera_from_world: np.ndarray, points: np.ndarray, descriptors: np.ndarray) -> Features:
    """Noise-free keypoints of world points (n, 3), all taken to be in view."""
    in_camera = transform_points(camera_from_world, points)
    return features_at(CAMERA.project(in_camera), in_camera[:, 2], descriptors)


def observations_of(m: MapColumns, point: int) -> Iterator[tuple[int, int]]:
    """Slot and keypoint of each entry in a point's list; stops with an error where the list does not end."""
    capacity = m.point.shape[1]
    observation, steps = int(m.head[point]), 0
    while observation >= 0:
        yield observation // capacity, observation % capacity
        observation = int(m.next_observation[observation // capacity, observation % capacity])
        steps += 1
        assert steps <= m.point.size, f"the list of point {point} is a circle"


def check_graph(slam_map: SlamMap) -> None:
    """Hold the linked lists to their invariants."""
    m = slam_map.columns
    listed = set()
    for point in range(slam_map.point_count):
        mine = list(observations_of(m, point))
        assert len(mine) == m.observations[point], f"point {point} counts {m.observations[point]}, lists {len(mine)}"
        assert bool(m.point_alive[point]) == (len(mine) > 0), f"point {point} is alive without observations, or dead"
        slots = [slot for slot, _ in mine]
        assert len(set(slots)) == len(slots), f"point {point} is seen twice by one keyframe"
        for slot, feature in mine:
            assert m.point[slot, feature] == point, f"keypoint {slot}, {feature} does not point back to {point}"
            assert m.slot_keyframe[slot] >= 0, f"point {point} is seen from the free slot {slot}"
            assert feature < m.feature_count[slot]
            listed.add((slot, feature))
    pointing = {(int(slot), int(feature)) for slot, feature in zip(*np.nonzero(m.point >= 0), strict=True)}
    assert pointing == listed, "a keypoint points to a point that does not list it"
    living = slam_map.living_keyframes()
    assert (m.slot_keyframe[m.keyframe_slot[living]] == living).all()
    assert len(set(m.keyframe_slot[living].tolist())) == len(living), "two keyframes share a slot"
