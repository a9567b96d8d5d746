"""What the test pairs and the words of places are learned from: photographs, worlds, malls and generated pictures."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from lpslam.config import SimulationConfig
from lpslam.simulation import lexicon, textures
from lpslam.simulation.lettering import paint_board
from lpslam.simulation.source import MallSource
from lpslam.simulation.worlds.factors import draw_world
from lpslam.simulation.worlds.source import WorldSource

FIRST_SEED = 900
FIRST_WORLD = 9000  # neither of the worlds to develop with nor of those to test with
LEAST_SIDE, LEAST_BYTES = 320, 20_000  # pixels, and of a file; icons and thumbnails are no views
MOST_PIXELS = 2000  # across a picture that is read; larger ones are shrunk
MOST_VIEWS = 8  # of one picture
ALIKE = 6.0  # grey values between thumbnails, on average, below which two files of a package are one picture
LEAST_CORNERS = 300  # of a view
CORNERS = cv2.FastFeatureDetector.create(20)
SUFFIXES = {".jpg", ".jpeg", ".png", ".webp"}

Rgb = NDArray[np.uint8]


def photographed(folder: Path, count: int) -> Iterator[Rgb]:
    """Views (480, 640, 3) cut from the pictures below a folder, at several scales, every third of them dark.

    Its sub-folders, one for each package, take turns, and so do the pictures of each; none gives more than a few views.
    Views that show next to nothing are left out.
    """
    rng = np.random.default_rng([FIRST_SEED, 1])
    stock = [pictures for each in sorted(folder.iterdir()) if (pictures := _pictures_of(each))]
    turns = [[each[int(row)] for _ in range(MOST_VIEWS) for row in rng.permutation(len(each))] for each in stock]
    given = 0
    while given < count and (turns := [each for each in turns if each]):
        for turn in turns:
            view = _seen_aside(rng, _cut(rng, _read(turn.pop())))
            if given < count and len(CORNERS.detect(view)) >= LEAST_CORNERS:
                yield (view * 0.4).astype(np.uint8) if given % 3 == 2 else view
                given += 1


def _pictures_of(folder: Path) -> list[Path]:
    """The pictures below a folder that are large enough; of one picture in many sizes the first."""
    kept: list[Path] = []
    seen: list[NDArray[np.float64]] = []
    for path in sorted(each for each in folder.rglob("*") if each.suffix.lower() in SUFFIXES):
        if not path.is_file() or path.stat().st_size < LEAST_BYTES:
            continue
        small = cv2.imread(str(path), cv2.IMREAD_REDUCED_GRAYSCALE_4)
        if small is None or 4 * min(small.shape[:2]) < LEAST_SIDE:
            continue
        thumb = cv2.resize(small, (12, 12), interpolation=cv2.INTER_AREA).astype(float)
        if all(np.abs(thumb - other).mean() > ALIKE for other in seen):
            kept.append(path)
            seen.append(thumb)
    return kept


def _read(path: Path) -> Rgb:
    """A picture as RGB; what is transparent becomes grey."""
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise SystemExit(f"{path} cannot be read")
    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    if image.ndim == 2:
        image = cv2.cvtColor(image, cv2.COLOR_GRAY2BGR)
    elif image.shape[2] == 4:
        share = image[..., 3:] / 255.0
        image = (image[..., :3] * share + 128 * (1 - share)).astype(np.uint8)
    shrink = MOST_PIXELS / max(image.shape[:2])
    if shrink < 1:
        image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), np.uint8)


def _cut(rng: np.random.Generator, picture: Rgb) -> Rgb:
    """A part (480, 640, 3) of a picture: between half the size of a view and all that there is."""
    height, width = picture.shape[:2]
    largest = min(width / 640, height / 480)
    scale = float(np.exp(rng.uniform(np.log(min(0.5, largest)), np.log(largest))))
    across, down = int(640 * scale), int(480 * scale)
    left, top = int(rng.integers(width - across + 1)), int(rng.integers(height - down + 1))
    part = picture[top : top + down, left : left + across]
    way = cv2.INTER_AREA if scale > 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(part, (640, 480), interpolation=way), np.uint8)


def world_frames(worlds: int, frames: int) -> Iterator[Rgb]:
    """Frames spread over the ways through several worlds, each by a camera of its own."""
    for seed in range(FIRST_WORLD, FIRST_WORLD + worlds):
        source = WorldSource(draw_world(seed))
        for index in np.linspace(0, len(source) - 1, frames).astype(int):
            yield source.frame(int(index)).rgb


def mall_frames(malls: int, frames: int) -> Iterator[NDArray[np.uint8]]:
    """Frames (480, 640, 3) spread over the walks through several malls, every third of them dark."""
    for seed in range(FIRST_SEED, FIRST_SEED + malls):
        mall = MallSource(seed, options=SimulationConfig(light=0.4 if seed % 3 == 2 else 1.0))
        for index in np.linspace(0, len(mall) - 1, frames).astype(int):
            yield mall.frame(int(index)).rgb


def generated_pictures(count: int) -> Iterator[NDArray[np.uint8]]:
    """Pictures (480, 640, 3) of materials, posters, words and noise, each seen a little aside and unsharp."""
    painters: Sequence[Callable[[np.random.Generator], NDArray[np.uint8]]] = (_noise, _shelf, _material, _words)
    for index in range(count):
        rng = np.random.default_rng([FIRST_SEED, index])
        yield _seen_aside(rng, painters[index % len(painters)](rng))


def _noise(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Blobs of all sizes; thresholded in half of the pictures, which gives sharp edges of any shape."""
    field = textures.clouds(rng, 480, 640, rng.uniform(60, 200), rng.uniform(2, 6))
    if rng.random() < 0.5:
        field = np.tanh(field * rng.uniform(3, 12)) * rng.uniform(0.4, 0.9)
    return textures.to_image(np.repeat((128 + 110 * field)[..., None], 3, axis=2))


def _shelf(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Posters side by side, as goods on a shelf."""
    rows, columns = int(rng.integers(1, 5)), int(rng.integers(2, 8))
    height, width = 480 // rows, 640 // columns
    goods = [np.hstack([textures.poster(rng, height, width) for _ in range(columns)]) for _ in range(rows)]
    return np.asarray(cv2.resize(np.vstack(goods), (640, 480)), np.uint8)


def _material(rng: np.random.Generator) -> NDArray[np.uint8]:
    scale = float(rng.uniform(80, 240))
    if rng.random() < 0.5:
        return textures.floor(rng, 480, 640, scale)
    kind = str(rng.choice(["brick", "tiles", "panels", "paper", "stone"]))
    return textures.wall(rng, 480, 640, scale, kind, textures.wall_colour(rng, 0.4))


def _words(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Boards with words on a plain wall."""
    picture = np.full((480, 640, 3), textures.wall_colour(rng, 0.3), np.uint8)
    for _ in range(12):
        wording = lexicon.EVERYTHING[int(rng.integers(len(lexicon.EVERYTHING)))]
        style = str(rng.choice(["plain", "shop", "friendly"]))
        lines = wording.lines("mixed")
        board = paint_board(rng, lines, wording.kind, style, rng.uniform(0.08, 0.25), 1.2, 200.0).image[:400, :500]
        top, left = int(rng.integers(480 - board.shape[0])), int(rng.integers(640 - board.shape[1]))
        picture[top : top + board.shape[0], left : left + board.shape[1]] = board
    return picture


def _seen_aside(rng: np.random.Generator, picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    corners = np.array([[0, 0], [640, 0], [640, 480], [0, 480]], np.float32)
    aside = corners + rng.normal(0, 60, (4, 2)).astype(np.float32)
    turned = cv2.warpPerspective(
        picture, cv2.getPerspectiveTransform(corners, aside), (640, 480), borderMode=cv2.BORDER_REFLECT
    )
    unsharp = cv2.GaussianBlur(turned, (0, 0), float(rng.uniform(0.4, 1.6)))
    noisy = unsharp * rng.uniform(0.5, 1.1) + rng.normal(0, rng.uniform(1, 5), unsharp.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)
