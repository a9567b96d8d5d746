"""Walks past photographed shop fronts: what the map says of them, and what plain reading says of the flat boards."""

import shutil
from argparse import Namespace
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from lpslam import pipeline
from lpslam.config import Config, SpottingConfig
from lpslam.evaluation.report import evaluate
from lpslam.evaluation.signs import TrueSign, read_signs
from lpslam.simulation.boards.labels import LabelledBoard, read_labelled
from lpslam.simulation.boards.ornaments import ORNAMENTS, paint_ornament
from lpslam.simulation.boards.street import StreetSource, drawn_boards, read_distractors, streets_of, write_distractors
from lpslam.simulation.writer import write_sequence
from lpslam.slam.warm_up import warm_up
from lpslam.text.reading.borders import cut_by_border
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts
from lpslam.text.remembering.similarity import comparison_key
from slam_recordings import Recording
from slam_report import Report
from text_calibration import calibration_error, draw_stated, error_by_chance
from text_fronts_scores import Judged, SignScore, judge, lines_said, pictures_of, stated_and_exact, texts_of
from text_worn import interval, looks

SETS = {"development": range(1, 7), "test": range(101, 107)}
"""Seeds of streets: those to develop on, and those that nothing is tuned on."""
PLAIN_SCALE = 0.5  # of a board's own pixels for plain reading: as large as it is in a walk
EDGE = 40  # pixels of grey around a flat board, so that no text lies on the image's edge
ORNAMENT_SEED = 7
SURE = 0.9  # from which a line counts as sure
FACTORS = ("lettering", "ageing", "script", "depth")


@dataclass
class Plain:
    """What plain reading makes of flat boards."""

    named: list[bool] = field(default_factory=list)
    exact: list[bool] = field(default_factory=list)
    lines: int = 0
    read: int = 0
    texts: int = 0
    spurious: int = 0
    by_factor: dict[tuple[str, str], list[bool]] = field(default_factory=lambda: defaultdict(list))


@dataclass
class Total:
    """Everything that is added up over streets."""

    judged: list[Judged] = field(default_factory=list)
    scores: list[SignScore] = field(default_factory=list)
    ate: list[float] = field(default_factory=list)
    boards: list[LabelledBoard] = field(default_factory=list)
    stated: list[tuple[float, bool]] = field(default_factory=list)
    pictures: list[str] = field(default_factory=list)


def measure(given: Namespace, config: Config, report: Report, photographs: Path) -> None:
    """Render what is not in the cache, map every street, score, and read the flat boards beside it."""
    if given.cache is None:
        raise SystemExit("name a folder for rendered streets: --cache DIR")
    if given.set not in (None, *SETS):
        raise SystemExit(f"photographed: sets are {', '.join(SETS)}")
    which = given.set or "development"
    seeds = _seeds(given.seeds) if given.seeds else list(SETS[which])
    streets = [StreetOf(f"street-{seed}", seed, None) for seed in seeds]
    if given.folders:
        streets = []
    for folder in given.folders or [photographs]:
        # The given photographs are to be reported on: they come with the test set.
        if given.folders or which == "test":
            streets += _streets_of_photographs(folder, given.looks)
    print(f"kernels ready in {warm_up(print):.1f} s")
    total = Total()
    spotter = PaddleSpotter(config.text.spotting)
    for street in streets:
        total.boards += _measure_street(street, given.cache, spotter, config, report, total)
    if given.plot is not None and total.stated:
        draw_stated(given.plot, f"lines of {which} streets", total.stated)
    _tables(total, read_flat(total.boards, spotter, config.text.spotting), report)
    read_ornaments(spotter, config.text.spotting)


@dataclass(frozen=True)
class StreetOf:
    """A street to walk past: of a seed, or of photographs."""

    name: str
    seed: int
    boards: Sequence[LabelledBoard] | None


def _seeds(text: str) -> list[int]:
    try:
        first, _, last = text.partition("-")
        seeds = list(range(int(first), int(last or first) + 1))
    except ValueError:
        raise SystemExit(f"--seeds {text}: expected A-B") from None
    return seeds


def _streets_of_photographs(folder: Path, count: int) -> list[StreetOf]:
    if not (folder / "labels.json").exists():
        print(f"{folder} has no photographs with labels.json; left out")
        return []
    boards = read_labelled(folder)
    if count:
        rows = [(look, row, part) for look, some in enumerate(looks(boards, count)) for row, part in _rows(some)]
        return [StreetOf(f"worn-{folder.name}-{look}-{row}", 9000 + 10 * look + row, part) for look, row, part in rows]
    parts = streets_of(boards)
    return [StreetOf(f"photographs-{folder.name}-{row}", 900 + row, part) for row, part in enumerate(parts)]


def _rows(boards: Sequence[LabelledBoard]) -> list[tuple[int, list[LabelledBoard]]]:
    return list(enumerate(streets_of(boards)))


def _measure_street(
    street: StreetOf, cache: Path, spotter: PaddleSpotter, config: Config, report: Report, total: Total
) -> list[LabelledBoard]:
    boards = list(street.boards or drawn_boards(street.seed))
    folder = cache / street.name
    if not (folder / "ornaments.json").exists():  # written last
        shutil.rmtree(folder, ignore_errors=True)
        source = StreetSource(street.seed, boards)
        write_sequence(source, folder)
        write_distractors(folder, source.distractors)
    recording = Recording.at(folder)
    world = pipeline.run(recording.open(), config, spotter=spotter, sequential=True)
    pipeline.distill(world)
    signs, frames = read_signs(folder) or [], len(recording.truth)
    scores = evaluate(world, recording.truth, signs, frames, config.evaluation)
    truth_from_map = scores.ate.truth_from_estimate
    judged, of_signs = judge(world.landmarks(), signs, read_distractors(folder), truth_from_map, config.evaluation)
    total.stated += stated_and_exact(world.landmarks(), signs, truth_from_map)
    total.pictures += pictures_of(world.landmarks(), signs, truth_from_map)
    total.judged += judged
    total.scores += of_signs
    total.ate.append(scores.ate.rmse)
    expected = [each for each in of_signs if each.expected]
    report.line(
        street=street.name,
        frames=frames,
        tracked=scores.frames_tracked,
        ate_rmse_m=round(scores.ate.rmse, 4),
        expected=len(expected),
        found=sum(each.found for each in expected),
        fates=dict(Counter(each.fate for each in judged)),
    )
    _print_errors(judged, of_signs, config.evaluation.readable_frames)
    return boards


def _print_errors(judged: Sequence[Judged], scores: Sequence[SignScore], frames: int) -> None:
    """Each error with what was painted and what came out."""
    for score in scores:
        if score.expected and not score.found:
            came = [f"{each.mark.name!r} ({each.fate})" for each in judged if each.is_of(score.sign)]
            print(f"  missed  {_painted(score.sign)}: came out {', '.join(came) or 'nothing'}")
        elif score.found and not score.exact:
            came = [repr(text) for each in score.name_marks for text in texts_of(each.mark)]
            print(f"  inexact {_painted(score.sign)}: came out {', '.join(came)}")
        if score.split:
            print(f"  split   {_painted(score.sign)}: into {[each.mark.name for each in score.marks]}")
        for each in score.marks:
            if each.stray:
                print(f"  stray   lines of {each.mark.name!r}: {texts_of(each.mark)} beside {_painted(score.sign)}")
        unsaid = [line.text for line in score.expected_lines(frames)[1:] if not score.said(line)]
        if unsaid:
            print(f"  unsaid  {unsaid} of {_painted(score.sign)}")
    for each in judged:
        if each.fate != "real":
            beside = [_painted(sign) for sign in each.merged or [each.sign] if sign]
            print(f"  {each.fate:9}{each.mark.name!r} ({each.mark.observations} sightings) at {' and '.join(beside)}")


def _painted(sign: TrueSign) -> str:
    lines = " / ".join(f"{line.text} [{line.role or 'line'}]" for line in sign.lines)
    made = [sign.features[factor] for factor in FACTORS[:3] if factor in sign.features]
    made += ["no depth"] if sign.features.get("depth") == "no" else []
    return f"{lines} ({', '.join(made)})"


def read_flat(boards: Sequence[LabelledBoard], spotter: PaddleSpotter, config: SpottingConfig) -> Plain:
    """The simple way: detect and recognise on the flat picture of every board."""
    plain = Plain()
    for board in boards:
        texts = _texts(board.image, spotter, config, PLAIN_SCALE if board.features else 1.0)
        lines = board.lines
        said = [lines_said(text, lines, 0.8) for text in texts]  # type: ignore[arg-type]
        whole = lines_said(" ".join(texts), lines, 0.8)  # type: ignore[arg-type]
        plain.lines += len(lines)
        plain.read += sum(line in whole for line in lines)
        plain.texts += len(texts)
        plain.spurious += sum(not each for each in said)
        if not lines:
            continue
        named = lines[0] in whole
        plain.named.append(named)
        plain.exact.append(comparison_key(lines[0].text) in comparison_key(" ".join(texts)))
        for factor in FACTORS[:3]:
            for kind in _kinds(board.features, factor):
                plain.by_factor[factor, kind].append(named)
    return plain


def _texts(image: Any, spotter: PaddleSpotter, config: SpottingConfig, scale: float) -> list[str]:
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    framed = cv2.copyMakeBorder(small, EDGE, EDGE, EDGE, EDGE, cv2.BORDER_CONSTANT, value=(128, 126, 122))
    framed = np.asarray(framed, np.uint8)
    boxes, _ = spotter.detect(framed)
    boxes = boxes[~cut_by_border(framed, boxes)]
    boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
    accepted = accepted_texts(boxes, spotter.recognise(framed, boxes), config)
    return [each.text for each in accepted if each is not None]


def read_ornaments(spotter: PaddleSpotter, config: SpottingConfig, pictures: int = 4) -> None:
    """Texture sets: what plain reading takes for text on so many pictures of every ornament."""
    print("Ornaments read as text, of so many pictures:")
    for kind in ORNAMENTS:
        rng = np.random.default_rng([ORNAMENT_SEED, ORNAMENTS.index(kind)])
        texts = []
        for _ in range(pictures):
            picture = paint_ornament(rng, kind, float(rng.uniform(0.16, 0.5)), float(rng.uniform(0.8, 2.0)))
            texts.append(_texts(picture, spotter, config, PLAIN_SCALE))
        read = [text for each in texts for text in each]
        print(f"  {kind}: {sum(map(bool, texts))} of {pictures}; {read[:8]}")


def _tables(total: Total, plain: Plain, report: Report) -> None:
    expected = [each for each in total.scores if each.expected]
    fates = Counter(each.fate for each in total.judged)
    lines = [(each, line) for each in total.scores for line in each.expected_lines(10)]
    lines_all = sum(len(texts_of(each.mark)) for each in total.judged)
    lines_right = sum(len(texts_of(each.mark)) - each.stray for each in total.judged if each.fate == "real")
    off = [each.distance for each in total.judged if each.fate == "real"]
    report.table(
        ["Figure", "Map of a walk", "Plain reading of the flat board"],
        [
            ["Main names found", _share([each.found for each in expected]), _share(plain.named)],
            ["landmarks called by them", _share([each.called for each in expected]), ""],
            ["exact to the letter", _share([each.exact for each in expected]), _share(plain.exact)],
            ["All lines found", _share([each.said(line) for each, line in lines]), f"{plain.read} of {plain.lines}"],
            [
                "Precision",
                f"{fates['real']} of {len(total.judged)}",
                f"{plain.texts - plain.spurious} of {plain.texts}",
            ],
            ["Precision of lines", f"{lines_right} of {lines_all}", ""],
            ["Inventions: on ornaments", str(fates["ornament"]), ""],
            ["elsewhere", str(fates["invented"]), str(plain.spurious)],
            ["misread", str(fates["misread"]), ""],
            ["misplaced", str(fates["misplaced"]), ""],
            ["Merged boards", f"{sum(each.merged for each in total.scores)}, in {fates['merged']} landmarks", ""],
            ["Split boards", str(sum(each.split for each in total.scores)), ""],
            ["Duplicates", str(sum(each.doubles for each in total.scores)), ""],
            ["Lines right in role", _share([own == true for each in total.judged for own, true in each.roles]), ""],
            *_calibration(total.stated, total.pictures),
            ["Position, median", f"{np.median(off):.3f} m" if off else "none", ""],
            ["ATE, median", f"{np.median(total.ate):.4f} m" if total.ate else "none", ""],
        ],
    )
    rows = []
    for factor in FACTORS:
        groups: dict[str, list[SignScore]] = defaultdict(list)
        for each in expected:
            for kind in _kinds(each.sign.features, factor):
                groups[kind].append(each)
        for name in sorted(groups):
            some = groups[name]
            flat = plain.by_factor.get((factor, name), [])
            found, exact = _share([each.found for each in some]), _share([each.exact for each in some])
            rows.append([factor, name, found, exact, _share(flat)])
    report.table(["Factor", "Kind", "Found", "Exact", "Plain reading finds"], rows)


def _calibration(stated: Sequence[tuple[float, bool]], pictures: Sequence[str]) -> list[list[str]]:
    """How well lines are what they are said to be."""
    if not stated:
        return []
    said, exact = np.array([each for each, _ in stated]), np.array([each for _, each in stated])
    sure = exact[said >= SURE].tolist()
    mean, most = error_by_chance(said)
    once, low, high = interval(said, exact, pictures)
    return [
        [f"Lines said to be {SURE} sure or more; exact", _share(sure), ""],
        ["Expected calibration error of lines", f"{calibration_error(said, exact):.3f}", ""],
        ["each board counted once; 95 % of resamplings", f"{once:.3f}; {low:.3f} to {high:.3f}", ""],
        ["by chance, if all were as sure as said; nine in ten", f"{mean:.3f}; {most:.3f}", ""],
    ]


def _kinds(features: Mapping[str, str], factor: str) -> list[str]:
    """What a board is by a factor: of two kinds of age, both."""
    return features.get(factor, "photograph").split("+")


def _share(right: Sequence[bool]) -> str:
    return f"{sum(right)} of {len(right)}" if right else "none"
