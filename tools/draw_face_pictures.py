"""Draw what a run is written down as, and what a robot is given, as the documents show them.

    python tools/draw_face_pictures.py run RUN.mcap docs/images/face-run.webp
    python tools/draw_face_pictures.py robot EXPORTED docs/images/face-robot.webp

RUN is written by `lpslam run … --mcap`, EXPORTED by `lpslam export … --nav2 --route QUESTION`.
"""

import argparse
import base64
import io
import json
import math
from pathlib import Path

import yaml
from mcap.reader import make_reader
from PIL import Image, ImageDraw, ImageFont

from lpslam.assets import font_path

QUALITY = 82
WIDE = 900  # pixels of the robot's picture
FREE, UNKNOWN, WALL = (255, 255, 255), (228, 230, 235), (31, 41, 55)
BLUE, ORANGE, BARRED = (31, 79, 216), (224, 98, 20), (190, 24, 93)


def draw_run(run: Path, out: Path) -> None:
    """The picture of a run with most boxes, with what became of each."""
    pictures, boxes = {}, {}
    with run.open("rb") as file:
        for _, _, message in make_reader(file).iter_messages(
            topics=["/camera/color/image/compressed", "/camera/color/boxes"]
        ):
            told = json.loads(message.data)
            if "data" in told:
                pictures[message.log_time] = told["data"]
            else:
                boxes[message.log_time] = told["points"]
    at = max((each for each in boxes if each in pictures), key=lambda each: len(boxes[each]))
    picture = Image.open(io.BytesIO(base64.b64decode(pictures[at]))).convert("RGB")
    pen = ImageDraw.Draw(picture)
    for box in boxes[at]:
        corners = [(point["x"], point["y"]) for point in box["points"]]
        colour = tuple(round(255 * box["outline_color"][each]) for each in "rgb")
        pen.line([*corners, corners[0]], fill=colour, width=3)
    picture.save(out, quality=QUALITY, method=6)


def draw_robot(folder: Path, out: Path) -> None:
    """The grid, where to stand before each sign, and the way to one."""
    facts = yaml.safe_load((folder / "map.yaml").read_text())
    grid = Image.open(folder / "map.pgm").convert("L")
    barred = Image.open(folder / "keepout.pgm").convert("L")
    scale = WIDE / grid.width
    coloured = Image.new("RGB", grid.size, UNKNOWN)
    coloured.paste(FREE, mask=grid.point(lambda value: 255 * (value > 250)))
    coloured.paste((246, 222, 232), mask=barred.point(lambda value: 255 * (value < 50)))
    coloured.paste(WALL, mask=grid.point(lambda value: 255 * (value < 50)))
    picture = coloured.resize((WIDE, round(grid.height * scale)), Image.Resampling.NEAREST)
    left, bottom = facts["origin"][:2]
    metres = scale / facts["resolution"]

    def pixel(x: float, y: float) -> tuple[float, float]:
        return (x - left) * metres, picture.height - (y - bottom) * metres

    pen, font = ImageDraw.Draw(picture), ImageFont.truetype(str(font_path("map")), 15)
    way = yaml.safe_load((folder / "route.yaml").read_text())["poses"]
    places = [pose["pose"]["position"] for pose in way]
    pen.line([pixel(place["x"], place["y"]) for place in places], fill=ORANGE, width=5, joint="curve")
    for point in yaml.safe_load((folder / "waypoints.yaml").read_text())["waypoints"]:
        u, v = pixel(point["x"], point["y"])
        pen.ellipse((u - 5, v - 5, u + 5, v + 5), fill=BLUE)
        pen.line((u, v, u + 16 * math.cos(point["yaw"]), v - 16 * math.sin(point["yaw"])), fill=BLUE, width=3)
        pen.text((u + 9, v + 4), point["name"], BLUE, font)
    picture.save(out, quality=QUALITY, method=6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("run", "robot"))
    parser.add_argument("shown", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    (draw_run if given.what == "run" else draw_robot)(given.shown, given.out)


if __name__ == "__main__":
    main()
