"""What words add to geometry: loops and merges found, wrong ones, with and without the advice of texts.

    python benchmarks/words.py FOLDER...               loops of each recording
    python benchmarks/words.py FOLDER... --then AGAIN  each, then twenty blank frames, then another recording
    ... --apart                                        of which nothing shows the same place: every tie is wrong
    ... --relocalise                                   the lost camera may be found again at once
    ... --skip 60                                      after the blank frames the other begins at its 60th frame

All recordings have a ground truth; those of one pair were made in the same mall. Each is mapped in step by looks alone,
by looks and words, and by words alone, where looks propose no place. After blank frames the camera is lost; so that it
is not merely relocalised by looks, that is switched off then: a sub-map begins, and must be merged. With `--relocalise`
it is not: `found` counts the frames of the second recording that are placed in the map of the first, all of them wrong
where nothing shows the same place, and `given_up` the relocalisations that signs took back.

`right` counts the proposals of words within 3 m and 45 degrees of the truth. What a network reads is kept, so that each
frame is read once for all ways.
"""

import argparse
import time
import zlib
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, nullcontext
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import AdviceConfig, Config
from lpslam.evaluation.trajectory import absolute_trajectory_error
from lpslam.frames import RgbdFrame
from lpslam.language.offline import OfflineModel
from lpslam.poses import StampedPoses
from lpslam.slam.advice import NO_ADVICE, KeyframeMap, Recalled
from lpslam.slam.places.index import PlaceIndex
from lpslam.slam.places.relocalising import Relocaliser
from lpslam.slam.state import EventKind
from lpslam.slam.system import RgbdSlam
from lpslam.sources.prefetch import Prefetched
from lpslam.text.advice.advising import SIGNS_DIFFER, TextAdvisor
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.boxes import Boxes
from lpslam.text.reading.spotting import PaddleSpotter
from lpslam.text.types import Recognition
from slam_recordings import Recording
from slam_report import Report
from slam_scores import pose_error, true_pose

BLANK, FPS = 20, 30.0
NEAR = (3.0, 45.0)  # metres, degrees within which a proposal is right
WRONG_TIE = (0.1, 3.0)  # metres, degrees by which a tie may be off
WAYS = ("looks", "looks and words", "words")


class Kept:
    """A reader that reads no frame twice."""

    def __init__(self, reader: PaddleSpotter) -> None:
        self._reader = reader
        self._boxes: dict[int, tuple[Boxes, NDArray[np.float64]]] = {}
        self._texts: dict[tuple[int, bytes], Recognition] = {}

    def detect(self, rgb: NDArray[np.uint8]) -> tuple[Boxes, NDArray[np.float64]]:
        """As a `TextSpotter`."""
        key = zlib.crc32(rgb)
        if key not in self._boxes:
            self._boxes[key] = self._reader.detect(rgb)
        return self._boxes[key]

    def recognise(self, rgb: NDArray[np.uint8], boxes: Boxes) -> list[Recognition]:
        """As a `TextSpotter`."""
        frame = zlib.crc32(rgb)
        keys = [(frame, box.tobytes()) for box in boxes]
        new = [row for row, key in enumerate(keys) if key not in self._texts]
        if new:
            self._texts |= zip([keys[row] for row in new], self._reader.recognise(rgb, boxes[new]), strict=True)
        return [self._texts[key] for key in keys]


class Witnessed(TextAdvisor):
    """Remembers what was proposed to whom."""

    def __init__(self, config: AdviceConfig) -> None:
        super().__init__(config)
        self.told: list[tuple[int, int]] = []
        self.milliseconds = [0.0]

    def propose(self, keyframes: KeyframeMap, keyframe: int) -> list[Recalled]:
        """As a `LoopAdvisor`."""
        started = time.thread_time()
        proposals = super().propose(keyframes, keyframe)
        self.milliseconds.append(1000.0 * (time.thread_time() - started))
        self.told += [(keyframe, each.keyframe) for each in proposals]
        return proposals


def one_after_the_other(
    first: Recording, second: Recording | None, skip: int
) -> tuple[Iterator[RgbdFrame], StampedPoses, float]:
    """The frames of one recording or two, their true poses, and when the second one begins."""
    truth = first.truth
    frames = Prefetched(first.open())
    if second is None:
        return iter(frames), truth, np.inf
    begins = truth.timestamps[-1] + (BLANK + 1) / FPS
    shift = begins - second.truth.timestamps[skip]

    def all_frames() -> Iterator[RgbdFrame]:
        for frame in frames:
            yield (last := frame)
        dark, nothing = np.zeros_like(last.rgb), np.zeros_like(last.depth)
        for count in range(1, BLANK + 1):
            yield RgbdFrame(last.index + count, last.timestamp + count / FPS, dark, nothing)
        for frame in islice(Prefetched(second.open()), skip, None):
            index = last.index + BLANK + 1 + frame.index - skip
            yield replace(frame, index=index, timestamp=frame.timestamp + shift)

    stamps = np.concatenate([truth.timestamps, second.truth.timestamps[skip:] + shift])
    poses = np.concatenate([truth.world_from_camera, second.truth.world_from_camera[skip:]])
    return all_frames(), StampedPoses(stamps, poses), begins


def run(
    first: Recording,
    second: Recording | None,
    way: str,
    reader: Kept,
    *,
    is_apart: bool = False,
    relocalises: bool = False,
    skip: int = 0,
) -> dict[str, Any]:
    """Map the frames in one of the ways, and compare what was tied together with the truth."""
    config = Config()
    source = first.open()
    advisor = Witnessed(config.text.advice)
    slam = RgbdSlam(source.camera, config.slam, advisor=NO_ADVICE if way == "looks" else advisor)
    mapper = TextMapper(
        source.camera,
        reader,
        config.text,
        OfflineModel(),
        on_sighting=advisor.note,
        on_doubtful=advisor.note_doubtful,
        on_view=None if way == "looks" else advisor.note_view,
    )
    frames, truth, begins = one_after_the_other(first, second, skip)
    blind = ExitStack()
    if way == "words":
        unlike = {
            "query": lambda index, descriptors: np.zeros(1, np.float32),
            "query_keyframe": lambda index, keyframe: np.zeros(keyframe + 1, np.float32),
        }
        for name, answer in unlike.items():
            blind.enter_context(patch.object(PlaceIndex, name, answer))
    lost = patch.object(Relocaliser, "find", lambda *asked: None)
    with blind, lost if second and not relocalises else nullcontext():
        for frame in frames:
            mapper.observe(frame, slam.process(frame))
        slam.finish()
    estimate = StampedPoses(*slam.trajectory.world_from_camera(slam.map))

    def off(a: int, b: int, b_from_a: NDArray[np.float64] | None = None) -> tuple[float, float]:
        """Metres and degrees between two keyframes, or by which they are off."""
        true_a, true_b = (true_pose(truth, slam.map.frame_of(k)[1]) for k in (a, b))
        return pose_error(true_a, true_b) if b_from_a is None else pose_error(b_from_a, np.linalg.inv(true_b) @ true_a)

    def is_wrong(a: int, b: int) -> bool:
        if is_apart and (slam.map.frame_of(a)[1] < begins) != (slam.map.frame_of(b)[1] < begins):
            return True
        error = off(a, b, slam.map.camera_from_world(b) @ slam.map.world_from_keyframe(a))
        return error[0] > WRONG_TIE[0] or error[1] > WRONG_TIE[1]

    columns, submaps = slam.trajectory.to_arrays(), slam.map.submaps()
    again = columns["keyframe"][(columns["timestamp"] >= begins) & (columns["keyframe"] >= 0)]
    near = [off(*each) for each in advisor.told]
    events = [each for each in slam.events if each.kind in (EventKind.LOOP, EventKind.MERGE)]
    return {
        "loops": sum(each.kind is EventKind.LOOP for each in events),
        "merges": sum(each.kind is EventKind.MERGE for each in events),
        "at_frames": [each.frame for each in events],
        "ties": len(slam.map.loop_edges),
        "wrong_ties": sum(is_wrong(a, b) for a, b in slam.map.loop_edges),
        "proposed": len(near),
        "right": 0 if is_apart else sum(metres <= NEAR[0] and degrees <= NEAR[1] for metres, degrees in near),
        "vetoed": slam._loop_closer.counts.rejected[SIGNS_DIFFER],
        "in_the_map": len(estimate),
        "ate_rmse_m": round(absolute_trajectory_error(truth, estimate).rmse, 4),
        "submaps": len(set(slam.map.submaps().tolist())),
        "proposing_ms": [round(float(np.percentile(advisor.milliseconds, share)), 1) for share in (50, 95, 100)],
        "found": int(np.count_nonzero(submaps[again] == submaps[0])),
        "of": len(again),
        "relocalised": sum(each.kind is EventKind.RELOCALISED for each in slam.events),
        "given_up": sum(each.kind is EventKind.LOST and "signs" in each.reason for each in slam.events),
        "rejected": dict(slam._loop_closer.counts.rejected),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the recordings named on the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--then", type=Path, help="a recording to follow after blank frames")
    parser.add_argument("--apart", action="store_true", help="the two show different places, however alike")
    parser.add_argument("--relocalise", action="store_true", help="the lost camera may be found again at once")
    parser.add_argument("--skip", type=int, default=0, help="frames of the other recording to leave out")
    parser.add_argument("--by", action="append", choices=WAYS, help="only in these ways")
    parser.add_argument("--out", type=Path, help="folder for results.jsonl")
    given = parser.parse_args(arguments)
    cv2.setNumThreads(1)
    report, rows = Report(given.out), []
    second = Recording.at(given.then) if given.then else None
    for first in map(Recording.at, given.folders):
        reader = Kept(PaddleSpotter(Config().text.spotting))
        name = f"{first.name}, {second.name}" if second else first.name
        for way in given.by or WAYS:
            how = {"is_apart": given.apart, "relocalises": given.relocalise, "skip": given.skip}
            done = run(first, second, way, reader, **how)
            report.line(recording=name, way=way, **done)
            columns = (
                "loops",
                "merges",
                "wrong_ties",
                "proposed",
                "right",
                "vetoed",
                "in_the_map",
                "found",
                "given_up",
                "ate_rmse_m",
            )
            rows.append([name, way, *(str(done[column]) for column in columns)])
    report.table(
        [
            "Recording",
            "By",
            "Loops",
            "Merges",
            "Wrong ties",
            "Proposed",
            "Right",
            "Vetoed",
            "In the map",
            "Found",
            "Given up",
            "ATE m",
        ],
        rows,
    )


if __name__ == "__main__":
    main()
