"""Depth that is too long or too short by its range, found while running (after Teichman et al., CLAMS, RSS 2013).

A telephone guesses what lies beyond its range too near, and hardly any sensor is right at all of its distances. Pixels
of several keyframes say how far points are, but for one scale; depth must be in one proportion to that, near and far.
Where it is not, the near readings are believed, and the far ones are corrected.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from lpslam.config import DepthRangeConfig
from lpslam.slam.kernels import ranges as kernels
from lpslam.slam.map import SlamMap
from lpslam.slam.medians import medians_of_groups
from lpslam.slam.ranges.curve import DepthChange, DepthCurve
from lpslam.slam.sensor import Reach, SensorModel

_Matrix = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _Votes:
    """What one keyframe says of some distances.

    Attributes:
        metres, excess, weights: (n,) where they lie, by how much depth exceeds them, and 1/σ² of that.
        own: the share of it that no other keyframe says as well.
        observers: keyframes that saw a point of its keyframe's then, on average.
    """

    metres: _Matrix
    excess: _Matrix
    weights: _Matrix
    own: float
    observers: float


class DepthRanges:
    """Learns by how much depth exceeds the truth at each distance, from a map that grows, which keeps the curve.

    Args:
        slam_map: whose newest keyframes vote.
        sensor: of the camera.
        farthest: metres that are trusted at all.
        config: thresholds.
    """

    def __init__(self, slam_map: SlamMap, sensor: SensorModel, farthest: float, config: DepthRangeConfig) -> None:
        self._map = slam_map
        self._sensor = sensor
        self._config = config
        self._first_keyframe = slam_map.keyframe_count
        self._farthest = farthest
        self._reach = Reach(config.reach_readings, config.reach_share)
        self._better: DepthCurve | None = None
        self._changes = 0
        count = int(np.ceil(farthest / config.knots)) + 2
        self._knots: _Matrix = config.knots * np.arange(count, dtype=np.float64)
        self._prior = self._stiffness()
        self._forget()

    def learn(self, keyframes: NDArray[np.int32]) -> None:
        """Let keyframes (k,) vote that have been adjusted, anew if they had; for whoever adjusts the map.

        Its lock is taken here. What a keyframe saw is known the better the more of the others have seen it since.
        """
        if self._better is not None or self._config.certain_gain <= 0.0 or self._changes >= self._config.most_changes:
            return
        with self._map.lock:
            for keyframe in keyframes.tolist():
                if keyframe >= self._first_keyframe and self._map.is_alive(keyframe):
                    self._vote(keyframe)
        self._judge()

    def _judge(self) -> None:
        """Take a curve for better that explains far more of the votes than any would, by how much they differ."""
        config = self._config
        known = self._prior + self._information
        excess = np.linalg.solve(known, self._vector).astype(np.float64)
        gain = float(2.0 * self._vector @ excess - excess @ self._information @ excess)
        is_voted = np.diag(self._information) > _LEAST_INFORMATION
        # What a smooth curve takes up of the votes: its effective parameters.
        spare = self._freedom - float(np.trace(np.linalg.solve(known, self._information)))
        if np.abs(excess[is_voted]).max(initial=0.0) < config.least_change:
            return
        # Where people walk by, votes differ by more than any curve says.
        unexplained = (self._square - gain + _SUPPOSED_VOTES * _SUPPOSED_CHI2) / (spare + _SUPPOSED_VOTES)
        needed = config.certain_gain if self._map.depth_curve.is_straight else config.refined_gain
        if unexplained < config.most_unexplained and gain > needed * max(unexplained, 1.0):
            self._better = self._map.depth_curve.reaching(self._farthest).then(self._knots, excess)

    def apply(self) -> DepthChange | None:
        """Correct by a curve that has become better known, also the map's depths, which then wants adjusting.

        For whoever adjusts the map; its lock is taken here. Returns what has changed, if anything has.
        """
        with self._map.lock:
            if self._better is None:
                return None
            change = DepthChange(self._map.depth_curve, self._better)
            self._map.depth_curve, self._better = self._better, None
            for keyframe in self._map.living_keyframes():
                if keyframe >= self._first_keyframe:
                    self._read_again(int(keyframe), change)
            self._forget()
            self._changes += 1
        return change

    def _forget(self) -> None:
        """Begin to count anew: what was voted before was measured otherwise."""
        self._votes_of: dict[int, _Votes] = {}
        self._have_told_reach: set[int] = set()
        self._information = np.zeros_like(self._prior)
        self._vector = np.zeros(len(self._knots))
        self._square, self._freedom = 0.0, 0.0

    def _stiffness(self) -> _Matrix:
        """1/σ² of the excess before anything is known: none near the camera, then a random walk by distance."""
        steps = np.diff(np.eye(len(self._knots)), axis=0) / self._config.drift
        prior: _Matrix = steps.T @ steps
        near = np.flatnonzero(self._knots <= self._config.anchored)
        prior[near, near] += _FIXED
        return prior

    def _vote(self, keyframe: int) -> None:
        """Let a keyframe vote, if others see more of its points than when it voted last."""
        observers, before = self._observers(keyframe), self._votes_of.get(keyframe)
        is_told = before is not None and observers < self._config.renewed_observers * before.observers
        if is_told and keyframe not in self._map.blurred:
            return
        votes = self._votes(keyframe, observers)
        if before is not None:
            del self._votes_of[keyframe]
            self._count(before, -1.0)
        if votes is not None:
            self._votes_of[keyframe] = votes
            self._count(votes, 1.0)

    def _observers(self, keyframe: int) -> float:
        """Keyframes that see a point of this one's, on average."""
        columns, slot = self._map.columns, self._map.columns.keyframe_slot[keyframe]
        points = columns.point[slot, : columns.feature_count[slot]]
        seen = columns.observations[points[points >= 0]]
        return float(seen.mean()) if len(seen) else 0.0

    def _votes(self, keyframe: int, observers: float) -> _Votes | None:
        """The medians of a keyframe's points by distance; None where they are all at one, or streaks."""
        config, columns = self._config, self._map.columns
        if keyframe in self._map.blurred:
            return None
        rows, far, share = kernels.by_pixels(
            columns, keyframe, self._sensor.intrinsics, self._sensor.pixel_information, config.min_observers
        )
        known = share < config.largest_share
        rows, far = rows[known], far[known]
        if len(rows) < 2 * config.min_readings:
            return None
        slot = columns.keyframe_slot[keyframe]
        excess = np.log(columns.depth[slot, rows] / far)
        # All keyframes that see a point have its distance from the same pixels: together they tell it once.
        own = 1.0 / float(columns.observations[columns.point[slot, rows]].mean())
        scale = float(np.median(excess))
        if keyframe not in self._have_told_reach:
            self._have_told_reach.add(keyframe)
            count = columns.feature_count[slot]
            self._reach.see(columns.depth[slot, :count][columns.has_depth[slot, :count]])
        # By what pixels say and not by the reading: where little lies, readings that are wrong would be most of it.
        metres = far * np.exp(scale)
        at = np.floor(metres / config.knots).astype(np.int64)
        often = np.flatnonzero(np.bincount(at)[at] >= config.min_readings)
        distances, groups = np.unique(at[often], return_inverse=True)
        if len(distances) < 2:
            return None
        counts = np.bincount(groups)
        middles = medians_of_groups(excess[often], groups)
        read = medians_of_groups(columns.depth[slot, rows[often]].astype(np.float64), groups)
        cut = _cut_off(read, self._reach.metres, self._sensor.depth_sigma_at(read))
        return _Votes(
            medians_of_groups(metres[often], groups) * np.exp(middles - scale),
            middles,
            own / (config.common_error**2 + config.reading_error**2 / counts + (cut / read) ** 2),
            own,
            observers,
        )

    def _count(self, votes: _Votes, sign: float) -> None:
        """Add votes to what is known, or take them away; the keyframe's own scale is free."""
        at = votes.metres / self._config.knots
        lower = np.minimum(at.astype(np.int64), len(self._knots) - 2)
        rows = np.zeros((len(at), len(self._knots)))
        upper_share = np.minimum(at - lower, 1.0)
        rows[np.arange(len(at)), lower] = 1.0 - upper_share
        rows[np.arange(len(at)), lower + 1] = upper_share
        weights = np.diag(votes.weights) - np.outer(votes.weights, votes.weights) / votes.weights.sum()
        self._information += sign * (rows.T @ weights @ rows)
        self._vector += sign * (rows.T @ weights @ votes.excess)
        self._square += sign * float(votes.excess @ weights @ votes.excess)
        self._freedom += sign * votes.own * (len(at) - 1)

    def _read_again(self, keyframe: int, change: DepthChange) -> None:
        """Correct a keyframe's depths by the new curve; points that it brought to the map move as they do."""
        m, sensor = self._map.columns, self._sensor
        slot = int(m.keyframe_slot[keyframe])
        rows = np.flatnonzero(m.has_depth[slot, : m.feature_count[slot]])
        was = m.depth[slot, rows].copy()
        becomes = change(was)
        points = m.point[slot, rows]
        own = (points >= 0) & (m.first_keyframe[points] == keyframe)
        moved = sensor.back_project(m.pixels[slot, rows[own]], becomes[own] - was[own])
        m.position[points[own]] += moved @ m.camera_from_world[keyframe, :3, :3]
        m.depth[slot, rows] = becomes
        m.u_right[slot, rows] = m.pixels[slot, rows, 0] - sensor.disparity(becomes)
        m.disparity_information[slot, rows] = sensor.disparity_information(becomes)


def _cut_off(read: _Matrix, reach: float, sigma: _Matrix) -> _Matrix:
    """Metres by which readings (n,) may be too near since a sensor gives none beyond its reach.

    The mean of a normal distribution that is cut off there: near its end only those are left that are too near.
    """
    away = np.maximum((reach - read) / sigma, 0.0)
    return np.asarray(sigma * np.exp(-0.5 * away**2) / np.sqrt(2.0 * np.pi) / ndtr(away), np.float64)


_LEAST_INFORMATION = 1.0
"""1/σ² of an excess, of which more is not the rounding of votes that were taken away."""

_SUPPOSED_VOTES, _SUPPOSED_CHI2 = 4.0, 2.0
"""Votes that are supposed to differ from the curve by so much each, χ², until there are enough to say how much."""

_FIXED = 1e8
"""1/σ² of an excess that is taken for none."""
