"""Draw the pictures of maps and the animation of the demonstration that the documents show.

    python tools/draw_readme_pictures.py map MAP.lpmap docs/images/NAME.webp
    python tools/draw_readme_pictures.py demo docs/images/demo.webp [--frames N]

The animation renders the mock mall and maps it: on the left what the camera sees with the texts that are known, on the
right the map as it is at that moment; at its end a question is answered. It takes some minutes.
"""

import argparse
import tempfile
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from lpslam import pipeline
from lpslam.assets import font_path
from lpslam.camera import PinholeCamera
from lpslam.config import Config, SimulationConfig
from lpslam.demo import PAPER_SIGNS
from lpslam.frames import RgbdFrame
from lpslam.ground.raster import room_image
from lpslam.ground.scans import room_from_above
from lpslam.mapfile.language_map import LanguageMap
from lpslam.session.growth import Growth
from lpslam.session.session import Session
from lpslam.session.step import Step
from lpslam.simulation.source import MallSource
from lpslam.text.types import Landmark
from lpslam.views.answers import answer_text
from lpslam.views.drawable import printable
from lpslam.views.labels import place_labels
from lpslam.views.pictures import draw_language_map
from lpslam.views.run_progress import prepare

SECONDS, A_SECOND, LAST_SECONDS = 16.5, 8, 3.5  # of the walk, pictures a second, of the answer
WIDTH, HEIGHT = 960, 480
QUALITY, MAP_QUALITY = 45, 82
BLUE, PINK, GREY, GREEN, INK = (31, 79, 216), (190, 24, 93), (107, 114, 128), (21, 128, 61), (31, 41, 55)
QUESTION = "Where can I eat pizza?"


def draw_small(map_file: Path, out: Path) -> None:
    """The picture of a map, no larger than a document shows it."""
    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / "map.png"
        draw_language_map(LanguageMap.load(map_file), drawn)
        picture = Image.open(drawn).convert("RGB")
    picture.thumbnail((1000, 1000), Image.Resampling.LANCZOS)
    picture.save(out, quality=MAP_QUALITY, method=6)


@dataclass(frozen=True)
class Look:
    """How things stood after a frame."""

    rgb: NDArray[np.uint8]
    grown: Growth
    marks: list[Landmark]
    said: str


class Film:
    """A mall that is rendered once, and looks at the map that is made of it."""

    def __init__(self, mall: MallSource, count: int) -> None:
        self.looks: list[Look] = []
        self._mall, self._every = mall, max(1, round(len(mall) / count))
        self._seen: dict[int, NDArray[np.uint8]] = {}
        self.name, self.camera, self.faults = mall.name, mall.camera, mall.faults

    def __len__(self) -> int:
        return len(self._mall)

    def __iter__(self) -> Iterator[RgbdFrame]:
        for frame in self._mall:
            if frame.index % self._every == 0:
                self._seen[frame.index] = frame.rgb
            yield frame

    def on_step(self, frame: RgbdFrame, step: Step, session: Session) -> None:
        """Note how things stand, now and then."""
        rgb = self._seen.pop(step.index, None)
        if rgb is not None:
            said = f"frame {session.frames}   keyframes {session.keyframes}   texts {session.texts}"
            self.looks.append(Look(rgb, session.growth((), 0), session.landmarks(), said))


class Plan:
    """The room from above, drawn as far as it was seen.

    Args:
        world: the finished map, whose extent all pictures have.
    """

    def __init__(self, world: LanguageMap, width: int, height: int) -> None:
        assert world.scans is not None
        self._scans, self._size = world.scans, (width, height)
        room = world.frame_poses().positions[:, :2]
        places = np.array([mark.position[:2] for mark in world.landmarks()])
        low, high = np.concatenate([room, places]).min(axis=0) - 1.2, np.concatenate([room, places]).max(axis=0) + 1.2
        self._scale = float(min(np.array([width, height]) / (high - low)))
        self._middle = (low + high) / 2

    def pixels(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 2) metres to pixels."""
        return np.array(self._size) / 2 + (places[:, :2] - self._middle) * self._scale * [1, -1]

    def picture(self, grown: Growth, marks: list[Landmark], chosen: int | None = None) -> Image.Image:
        """The map at one moment."""
        canvas = Image.new("RGB", self._size, "white")
        walked = grown.poses[:, :3, 3]
        cloud, colours = self._scans.cloud(grown.keyframes.get)
        image = room_image(*room_from_above(cloud, colours, walked), None)
        if image is not None:
            left, right, bottom, top = image.extent
            (x, y), (x1, y1) = self.pixels(np.array([[left, top], [right, bottom]])).round().astype(int)
            room = Image.fromarray(image.rgba).resize((max(1, x1 - x), max(1, y1 - y)), Image.Resampling.BILINEAR)
            canvas.paste(room, (int(x), int(y)), room)
        pen = ImageDraw.Draw(canvas)
        way = self.pixels(walked)
        if len(way) > 1:
            pen.line([tuple(at) for at in way], fill=GREEN, width=2, joint="curve")
        if len(way):
            u, v = way[-1]
            pen.ellipse((u - 5, v - 5, u + 5, v + 5), fill=GREEN, outline="white")
        self._label(pen, marks, chosen)
        return canvas

    def _label(self, pen: ImageDraw.ImageDraw, marks: list[Landmark], chosen: int | None) -> None:
        if not marks:
            return
        font, names = text_font(12), [printable(mark.name, longest=24) for mark in marks]
        boxes = [pen.textbbox((0, 0), name, font=font) for name in names]
        sizes = np.array([(right - left + 6, bottom - top + 6) for left, top, right, bottom in boxes])
        at = self.pixels(np.array([mark.position for mark in marks]))
        for mark, name, box, size, (u, v), (x, y) in zip(
            marks, names, boxes, sizes, at, place_labels(at, sizes, self._size), strict=True
        ):
            is_chosen = mark.id == chosen
            colour = GREEN if is_chosen else {True: BLUE, False: PINK, None: INK}[mark.is_landmark]
            pen.ellipse((u - 3, v - 3, u + 3, v + 3), fill=colour, outline="white")
            corner = (x - size[0] / 2, y - size[1] / 2, x + size[0] / 2, y + size[1] / 2)
            pen.rectangle(corner, fill=colour if is_chosen else "white", outline=colour if is_chosen else None)
            pen.text((corner[0] + 3 - box[0], corner[1] + 3 - box[1]), name, "white" if is_chosen else colour, font)


def animate(out: Path, frames: int | None) -> None:
    """Run the demonstration's mall and draw it as it is mapped."""
    prepare()
    film = Film(MallSource(0, frames, options=SimulationConfig(featured=PAPER_SIGNS)), round(SECONDS * A_SECOND))
    world = pipeline.run(film, Config(), on_step=film.on_step)
    pipeline.distill(world)
    half = WIDTH // 2
    plan = Plan(world, half, HEIGHT)
    pictures = [
        _beside(look.rgb, plan.picture(look.grown, look.marks), look.said, look.marks, film.camera, look.grown)
        for look in film.looks
    ]
    pictures += _answered(world, plan, film.looks[-1])
    shown = [round(1000 / A_SECOND)] * len(film.looks) + [round(1000 * LAST_SECONDS)]
    pictures[0].save(
        out, save_all=True, append_images=pictures[1:], duration=shown, loop=0, quality=QUALITY, method=6
    )  # fmt: skip
    print(f"{out}: {len(pictures)} pictures, {sum(shown) / 1000:.1f} s, {out.stat().st_size / 1e6:.2f} MB")


def _answered(world: LanguageMap, plan: Plan, last: Look) -> list[Image.Image]:
    """The end: names judged, and a question answered."""
    answer = pipeline.ask(world, QUESTION)
    poses = world.frame_poses().world_from_camera
    keyframes = {
        k: p for k in world.slam.living_keyframes().tolist() if (p := world.world_from_keyframe(k)) is not None
    }
    chosen = answer.landmark.id if answer.landmark is not None else None
    picture = plan.picture(Growth(poses, keyframes, {}), world.landmarks(), chosen)
    whole = Image.new("RGB", (WIDTH, HEIGHT), "white")
    whole.paste(picture, (WIDTH // 2, 0))
    pen = ImageDraw.Draw(whole)
    pen.text((24, 150), QUESTION, INK, text_font(24))
    # The carried font has no curly quotes.
    lines = answer_text(answer).translate({0x201C: '"', 0x201D: '"'}).splitlines()
    for number, line in enumerate(textwrap.wrap(" ".join(lines[:1]), 40) + textwrap.wrap(" ".join(lines[1:2]), 52)):
        pen.text((24, 200 + 26 * number), printable(line, longest=80), GREEN, text_font(17))
    return [whole]


def _beside(
    rgb: NDArray[np.uint8],
    plan: Image.Image,
    said: str,
    marks: list[Landmark],
    camera: PinholeCamera,
    grown: Growth,
) -> Image.Image:
    """What the camera sees, with the landmarks that are known, beside the map."""
    whole = Image.new("RGB", (WIDTH, HEIGHT), "white")
    view = Image.fromarray(rgb)
    pen = ImageDraw.Draw(view)
    for mark in marks if len(grown.poses) else []:
        seen = np.linalg.inv(grown.poses[-1]) @ [*mark.position, 1.0]
        faces = float((grown.poses[-1][:3, 3] - mark.position) @ mark.normal)
        if not 0.3 < seen[2] < 6.0 or faces < 0:
            continue
        u, v = camera.fx * seen[0] / seen[2] + camera.cx, camera.fy * seen[1] / seen[2] + camera.cy
        wide, high = camera.fx * mark.width / seen[2] / 2 + 4, camera.fy * mark.height / seen[2] / 2 + 4
        pen.rectangle((u - wide, v - high, u + wide, v + high), outline=(40, 200, 80), width=3)
        name = printable(mark.name, longest=24)
        left, top, right, bottom = pen.textbbox((u - wide, v - high - 26), name, font=text_font(18))
        pen.rectangle((left - 3, top - 3, right + 3, bottom + 3), fill=(40, 200, 80))
        pen.text((u - wide, v - high - 26), name, (0, 0, 0), text_font(18))
    half = WIDTH // 2
    high = half * 3 // 4
    whole.paste(view.resize((half, high), Image.Resampling.LANCZOS), (0, (HEIGHT - high) // 2))
    whole.paste(plan, (half, 0))
    ImageDraw.Draw(whole).text((12, HEIGHT - 40), said, GREY, text_font(15))
    return whole


def text_font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(str(font_path("map")), size)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("map", "demo"))
    parser.add_argument("paths", type=Path, nargs="+")
    parser.add_argument("--frames", type=int)
    given = parser.parse_args()
    if given.what == "map":
        draw_small(*given.paths)
    else:
        animate(given.paths[0], given.frames)


if __name__ == "__main__":
    main()
