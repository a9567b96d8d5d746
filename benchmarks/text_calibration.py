"""How sure a reading and a name are, measured on drawn lettering.

    python benchmarks/text_calibration.py read --rows DIR --fonts FOLDER...   draw and read (ten minutes)
    python benchmarks/text_calibration.py fit --rows DIR   the coefficients of `text/reading/certainty.py`
    python benchmarks/text_calibration.py names --rows DIR            the coefficients of `naming/namer.py`
    python benchmarks/text_calibration.py odds --rows DIR                     the reader's own odds between two letters
    python benchmarks/text_calibration.py letters --rows DIR                  which letters of wrong readings are wrong
    python benchmarks/text_calibration.py report --rows DIR [--plot FILE]     how well all hold on other fonts

Fonts are dealt into those to develop on and those held out by their names; signs and seeds differ as well. Each sign is
seen in four views from afar to near, three frames each. A reading is right when it is what is painted but for case
and spaces.
"""

import argparse
import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rapidfuzz.distance import Hamming

from lpslam.assets import font_names, font_path
from lpslam.config import MemoryConfig, SpottingConfig
from lpslam.language.model import Reading
from lpslam.language.naming.channel import evidence_of, paint_key, steps_between
from lpslam.language.naming.namer import Certain
from lpslam.language.offline import OfflineModel
from lpslam.language.sanitise import clean_text
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.simulation import lexicon
from lpslam.text.reading.borders import cut_by_border
from lpslam.text.reading.boxes import letter_heights
from lpslam.text.reading.certainty import READING, Certainty, terms
from lpslam.text.reading.spotting import PaddleSpotter, accepted_texts
from lpslam.text.remembering.evidence import Glance, Look, note, readings_of
from lpslam.text.remembering.similarity import comparison_key
from text_drawn_lines import FAR, PAST, Font, Seen, drawn

SIGNS = {"dev": (71, 480, PAST), "held": (72, 320, PAST), "dev-far": (73, 120, FAR), "held-far": (74, 80, FAR)}
"""Sets of signs: seed, number and how they are passed; the fonts of those that are held are held out."""
COVERED = 0.6  # share of a line's ink that a box must cover to be a reading of it
SIZES = ((0, 16), (16, 28), (28, 48), (48, 999))  # pixels, of boxes
DRAWS = 1000  # of what would be right by chance
FITTED, RIDGE = 60, 1e-3  # Newton's steps, and what keeps the coefficients small


@dataclass(frozen=True)
class Row:
    """One reading of a drawn line."""

    sign: int
    view: int
    painted: str
    text: str
    confidence: float
    height: float
    frontal: float
    sharpness: float
    slots: tuple[tuple[tuple[str, float], ...], ...]

    @property
    def is_right(self) -> bool:
        """Whether it is what is painted, but for case and spaces."""
        return comparison_key(self.text) == comparison_key(clean_text(self.painted))

    @property
    def terms(self) -> tuple[float, ...]:
        """What the model sees of it."""
        return terms(self.text, self.confidence, self.slots, self.sharpness, self.height, self.frontal)


@dataclass(frozen=True, eq=False)
class Part:
    """Readings and names of one set of fonts: how sure they were said to be, and whether they are right."""

    name: str
    stated: NDArray[np.float64]
    right: NDArray[np.bool_]
    sure: NDArray[np.float64]
    exact: NDArray[np.bool_]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["read", "fit", "names", "odds", "letters", "report"])
    parser.add_argument("--rows", type=Path, required=True, help="folder for dev.jsonl and held.jsonl")
    parser.add_argument("--fonts", nargs="*", type=Path, default=[], help="folders with more fonts")
    parser.add_argument("--plot", type=Path, help="picture of stated against measured")
    given = parser.parse_args()
    if given.what == "read":
        given.rows.mkdir(parents=True, exist_ok=True)
        for which in SIGNS:
            _write(given.rows / f"{which}.jsonl", _read(which, given.fonts))
    elif given.what == "fit":
        fitted = fit(read_rows(given.rows / "dev.jsonl"))
        print("READING = Certainty(" + ", ".join(f"{value:.3f}" for value in astuple(fitted)) + ")")
    elif given.what == "names":
        values = fit_names([read_rows(given.rows / f"{which}.jsonl") for which in ("dev", "dev-far")])
        print("_CERTAINTY = (" + ", ".join(f"{value:.3f}" for value in values) + ")")
    elif given.what == "odds":
        show_odds(read_rows(given.rows / "dev.jsonl"))
    elif given.what == "letters":
        show_letters([row for which in SIGNS for row in read_rows(given.rows / f"{which}.jsonl")])
    else:
        parts = [report(which, read_rows(given.rows / f"{which}.jsonl")) for which in SIGNS]
        if given.plot is not None:
            draw(given.plot, parts)


def words() -> list[str]:
    """What signs say: known names, and those of the mock malls, of Chinese and of the Latin script by turns."""
    known = sorted({each.painted for each in load_knowledge().known.values()})
    known += sorted({line for each in lexicon.EVERYTHING for line in (each.english, each.chinese) if line})
    known = [text for text in known if 2 <= len(text) <= 22]
    rng = np.random.default_rng(7)
    chinese = [text for text in known if any("\u4e00" <= ch <= "\u9fff" for ch in text)]
    latin = [text for text in known if text.isascii()]
    latin += [text.upper() for text in latin[::2]]
    count = min(len(chinese), len(latin))
    return [*rng.permutation(chinese)[:count].tolist(), *rng.permutation(latin)[:count].tolist()]


def fonts_of(which: str, folders: Sequence[Path]) -> list[Font]:
    """The fonts of a set: every third one, by its name's checksum, is held out."""
    paths = [font_path(name) for name in font_names()]
    paths += [
        path for folder in folders for path in sorted(folder.rglob("*")) if path.suffix in (".ttf", ".otf", ".ttc")
    ]
    by_name = {path.stem: path for path in paths}
    held = {name for name in by_name if zlib.crc32(name.encode()) % 3 == 0}
    return [Font.at(path) for name, path in sorted(by_name.items()) if (name in held) == which.startswith("held")]


def _read(which: str, folders: Sequence[Path]) -> Iterator[Row]:
    config = SpottingConfig()
    spotter = PaddleSpotter(config)
    seed, count, walk = SIGNS[which]
    fonts = [font for font in fonts_of(which, folders) if set("AZaz") <= font.letters]
    for image, lines in drawn(seed, count, words(), fonts, walk):
        boxes, _ = spotter.detect(image)
        boxes = boxes[~cut_by_border(image, boxes)]
        boxes = boxes[letter_heights(boxes) >= config.min_letter_height]
        if not len(boxes):
            continue
        for box, text in zip(boxes, accepted_texts(boxes, spotter.recognise(image, boxes), config), strict=True):
            line = next((each for each in lines if _covers(box, each)), None)
            if text is not None and line is not None:
                sharp = text.sharpness or 0.0
                yield Row(
                    line.sign, line.view, line.text, text.text, text.confidence,
                    text.letter_height, line.frontal, sharp, text.slots,
                )  # fmt: skip


def _covers(box: NDArray[np.float64], line: Seen) -> bool:
    area, _ = cv2.intersectConvexConvex(box.astype(np.float32), line.box.astype(np.float32))
    ink = cv2.contourArea(line.box.astype(np.float32))
    return bool(area >= COVERED * ink or area >= 0.8 * cv2.contourArea(box.astype(np.float32)))


def _write(path: Path, rows: Iterator[Row]) -> None:
    with path.open("w", encoding="utf-8") as file:
        for count, row in enumerate(rows):
            file.write(json.dumps(astuple(row), ensure_ascii=False) + "\n")
            if count % 500 == 0:
                print(f"{path.name}: {count}", flush=True)


def read_rows(path: Path) -> list[Row]:
    """The rows that `read` wrote."""
    rows = []
    for line in path.read_text(encoding="utf-8").splitlines():
        *own, slots = json.loads(line)
        rows.append(Row(*own, tuple(tuple((letter, sure) for letter, sure in slot) for slot in slots)))
    return rows


def fit(rows: Sequence[Row]) -> Certainty:
    """Coefficients of `text/reading/certainty.py`: whether a reading is right."""
    x = np.array([(1.0, *row.terms) for row in rows])
    return Certainty(*logistic(x, np.array([row.is_right for row in rows], np.float64)).tolist())


def logistic(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Coefficients of (n, m) terms that make (n,) zeros and ones most probable, by Newton's method."""
    beta = np.zeros(x.shape[1])
    for _ in range(FITTED):
        p = 1.0 / (1.0 + np.exp(-x @ beta))
        hessian = (x * (p * (1 - p))[:, None]).T @ x + RIDGE * len(y) * np.eye(len(beta))
        beta += np.linalg.solve(hessian, x.T @ (y - p) - RIDGE * len(y) * beta)
    return beta


def fit_names(sets: Sequence[Sequence[Row]]) -> list[float]:
    """Coefficients of `naming/namer.py`: whether a name is right, from its posterior."""
    x, y = [], []
    for rows in sets:
        for name, right in named(rows):
            x.append(name.terms)
            y.append(right)
    return logistic(np.array(x), np.array(y, np.float64)).tolist()


def named(rows: Sequence[Row]) -> Iterator[tuple[Certain, bool]]:
    """Each sign as it is named from its first view on, from two, from three and so on; and whether that is right."""
    namer = OfflineModel().namer
    memory = MemoryConfig()
    by_sign: dict[int, list[Row]] = {}
    for row in rows:
        by_sign.setdefault(row.sign, []).append(row)
    for own in by_sign.values():
        for last in sorted({row.view for row in own}):
            looks: list[Look] = []
            for row in own:
                if row.view <= last:
                    glance = Glance(row.height, row.frontal, READING.probability(row.terms), row.slots)
                    note(looks, row.text, row.confidence, 0, glance)
            best = namer.most_certain(readings_of(looks, memory))
            yield best, comparison_key(best.name) == comparison_key(clean_text(own[0].painted))


def show_odds(rows: Sequence[Row]) -> None:
    """How often a runner-up is what is painted, by the reader's own odds against it."""
    odds, right = [], []
    for row in rows:
        read, painted = paint_key(row.text), paint_key(clean_text(row.painted))
        (seen,) = evidence_of([Reading(row.text, 1, row.confidence, 0.5, 1.0, row.slots)]) or [None]
        if seen is None or not seen.letters or len(read) != len(painted) or Hamming.distance(read, painted) > 2:
            continue
        for taken, true, slot in zip(read, painted, seen.letters, strict=True):
            for letter, probability in slot.items():
                if letter and letter != taken and true in (taken, letter):
                    odds.append(np.log(slot[taken] / probability))
                    right.append(letter == true)
    own, is_right = np.array(odds), np.array(right)
    for low, high in ((0, 0.5), (0.5, 1), (1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 6)):
        of = (own >= low) & (own < high)
        share = is_right[of].mean()
        print(f"own odds {low} to {high}: {of.sum():5d}  measured {np.log((1 - share) / share):.2f}")


def show_letters(rows: Sequence[Row]) -> None:
    """How well the letters' own doubts tell which letters of wrong readings are wrong, beside an even share of all."""
    likely = []
    for row in rows:
        painted = paint_key(clean_text(row.painted))
        (seen,) = evidence_of(
            [Reading(row.text, 1, row.confidence, READING.probability(row.terms), 1.0, row.slots)]
        ) or [None]
        if row.is_right or seen is None or not seen.doubts:
            continue
        steps = steps_between(painted, seen.key)
        wrong = {step.dest_pos for step in steps if step.tag != "delete"}
        if not 0 < len(wrong) <= len(seen.key) / 2:
            continue
        even = [1.0 / len(seen.key)] * len(seen.key)
        likely.append([_log_likely(seen.right, shares, wrong) for shares in (even, seen.doubts)])
    evenly, by_letters = np.mean(likely, axis=0)
    print(
        f"{len(likely)} wrong readings: logarithmic score {evenly:.2f} evenly, {by_letters:.2f} by the letters' doubts"
    )


def _log_likely(right: float, shares: Sequence[float], wrong: set[int]) -> float:
    """Logarithm of the probability that just these letters are wrong, each being right to its share of a power."""
    odds = [right**share for share in shares]
    return float(sum(np.log(max(1.0 - each, 1e-9) if at in wrong else each) for at, each in enumerate(odds)))


def report(which: str, rows: Sequence[Row]) -> Part:
    """Stated against measured, for readings and names: in ten parts, the expected error, by size and script."""
    stated = np.array([READING.probability(row.terms) for row in rows])
    right = np.array([row.is_right for row in rows])
    print(f"{which}: {len(rows)} readings of {len({row.sign for row in rows})} signs, {right.mean():.1%} right")
    for name, of in (("all", np.ones(len(rows), bool)), *_kinds(rows)):
        if of.any():
            error = calibration_error(stated[of], right[of])
            print(f"  {name:16} {of.sum():6d}  right {right[of].mean():.3f}  stated {stated[of].mean():.3f}", end="")
            print(f"  ECE {error:.3f}")
    _show_parts(stated, right)
    names = [(best.certainty, is_right) for best, is_right in named(rows)]
    sure, exact = np.array([each for each, _ in names]), np.array([each for _, each in names])
    print(f"{which}: {len(names)} names, {exact.mean():.1%} right, ECE {calibration_error(sure, exact):.3f}")
    _show_parts(sure, exact)
    return Part(which, stated, right, sure, exact)


def _show_parts(stated: NDArray[np.float64], right: NDArray[np.bool_]) -> None:
    part = np.minimum((stated * 10).astype(int), 9)
    for k in sorted(set(part.tolist())):
        of = part == k
        print(f"  said {stated[of].mean():.3f}: {of.sum():5d}  right {right[of].mean():.3f}")


def draw(path: Path, parts: Sequence[Part]) -> None:
    """A picture of stated against measured."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 4.2), layout="constrained")
    for axes, title, which in zip(figure.subplots(1, 2), ("readings", "names"), (0, 1), strict=True):
        axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
        for part in parts:
            stated, right = ((part.stated, part.right), (part.sure, part.exact))[which]
            tenth = np.minimum((stated * 10).astype(int), 9)
            shown = [k for k in range(10) if (tenth == k).sum() >= 10]
            points = [(stated[tenth == k].mean(), right[tenth == k].mean()) for k in shown]
            error = calibration_error(stated, right)
            axes.plot(*np.array(points).T, "o-", label=f"{part.name}, error {error:.3f}")
        axes.set(title=title, xlabel="stated", ylabel="exactly right", xlim=(0, 1), ylim=(0, 1))
        axes.legend(loc="upper left")
    figure.savefig(path, dpi=90)


def draw_stated(path: Path, name: str, stated: Sequence[tuple[float, bool]]) -> None:
    """A picture of stated against measured for (how sure, whether exact): by tenths, and how many are in each."""
    from matplotlib.figure import Figure

    said, exact = np.array([each for each, _ in stated]), np.array([each for _, each in stated])
    tenth = np.minimum((said * 10).astype(int), 9)
    figure = Figure(figsize=(5, 4.2), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1)
    for k in sorted(set(tenth.tolist())):
        of = tenth == k
        axes.plot(said[of].mean(), exact[of].mean(), "o", color="C0", markersize=4 + 2 * np.log10(of.sum()) ** 2)
        axes.annotate(str(of.sum()), (said[of].mean(), exact[of].mean()), xytext=(6, -10), textcoords="offset points")
    title = f"{name}, error {calibration_error(said, exact):.3f}"
    axes.set(title=title, xlabel="stated", ylabel="exactly right", xlim=(0, 1.05), ylim=(0, 1.05))
    figure.savefig(path, dpi=90)


def _kinds(rows: Sequence[Row]) -> list[tuple[str, NDArray[np.bool_]]]:
    height = np.array([row.height for row in rows])
    han = np.array([any("\u4e00" <= ch <= "\u9fff" for ch in row.painted) for row in rows])
    frontal = np.array([row.frontal for row in rows])
    return [
        *((f"{low} to {high} px", (height >= low) & (height < high)) for low, high in SIZES),
        ("Latin", ~han), ("Chinese", han), ("frontal", frontal > 0.9), ("aslant", frontal < 0.6),
    ]  # fmt: skip


def calibration_error(stated: NDArray[np.float64], right: NDArray[np.bool_]) -> float:
    """Mean distance of stated and measured in ten parts of equal width, each weighed by its number."""
    part = np.minimum((stated * 10).astype(int), 9)
    return float(sum(abs(stated[part == k].sum() - right[part == k].sum()) for k in range(10)) / len(stated))


def error_by_chance(stated: NDArray[np.float64]) -> tuple[float, float]:
    """The calibration error of so many names if each were right as often as stated: mean, and what nine in ten keep.

    Few names have an error by chance alone; what is above it says that they are not as sure as stated.
    """
    draws = np.random.default_rng(0).random((DRAWS, len(stated)))
    errors = [calibration_error(stated, each < stated) for each in draws]
    return float(np.mean(errors)), float(np.quantile(errors, 0.9))


if __name__ == "__main__":
    main()
