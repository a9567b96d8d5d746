"""Read rendered signs with the package's recogniser, and keep what it made of each: groups for scoring names.

    python tools/read_rendered_signs.py benchmarks/language/readings.json

Every sign is painted on a board and photographed a few times: askance, small, blurred, in the dark, its end cut off.
"""

import json
import sys
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from rapidfuzz.distance import Levenshtein

from lpslam.config import SpottingConfig
from lpslam.simulation.lettering import Board, paint_board
from lpslam.text.reading.networks import load_network
from lpslam.text.reading.recognition import TextRecogniser

SIGNS = {
    "brand": "Dunkin' Donuts|SUBWAY|Taco Bell|IKEA|Levi's|BOSS|LUSH|Clarks|New Balance|CONVERSE|Skechers|Primark"
    "|PULL & BEAR|Stradivarius|Bershka|Media Markt|GameStop|Pandora|Fielmann|ROSSMANN|Tim Hortons|Domino's Pizza"
    "|WENDY'S",
    "independent": "The Paper Lantern|OAKLEAF DENTAL|Mirabel|Tofino Surf Shop|HARBOUR OPTICIANS|Casa Lucia|Lotte & Finn"
    "|BLACKBIRD RECORDS|Juniper Florist|Kettering Watches|Sole Revival|PAWS AND CLAWS|Brava Pizza|Willow Yoga|Nightjar"
    "|Dr. Feld Dentist|Pomelo|Thornbury Cycles",
    "warning": "WET PAINT|Watch Your Step|DO NOT ENTER|No Photography|DANGER OF DEATH|Keep Clear|NO DOGS ALLOWED"
    "|Do Not Block Door|CAUTION HOT WATER|Mind Your Head",
    "facility": "Information|FIRST AID|Lost and Found|ELEVATOR|Cloakroom|Meeting Point|PARKING LEVEL 2|Taxi Rank"
    "|Left Luggage|Reception",
    "chinese": "中国银行|图书馆|停车场|出租车|美容美发|超市|服务中心|东北饺子|重庆火锅|儿童乐园|请勿拍照|小心碰头|药店"
    "|眼镜店|面包房|水果店|电影院|会议室|休息区|禁止停车|川菜馆|手机维修|鲜花店|足疗|茶叶店",
    "mixed": "书店 BOOKS|咖啡 Coffee|停车场 P2|问讯处 Information|星巴克 Starbucks|请勿触摸 Do Not Touch",
    "digits": "Gate A7|ROOM 318|Platform 4|24H Open|Level B2|Exit 6|30% Off|Studio 9",
}
SEED, VIEWS, LEAST, SURE = 7, (4, 10), 3, 0.6
FOCAL, LETTER_PIXELS = 520.0, (8.0, 15.0)


def photograph(rng: np.random.Generator, board: Board) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """A board as a camera far off sees it, and the corners of its first line as a detector might find them."""
    line = board.lines[0]
    turn, roll = np.radians(rng.uniform(-60, 60)), np.radians(rng.uniform(-5, 5))
    scale = rng.uniform(*LETTER_PIXELS) / line.letter_height
    shear = np.array([[np.cos(turn), 0.0], [np.sin(turn) * 0.15, 1.0]]) * scale
    rotated = np.array([[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]]) @ shear
    outer = np.array([[0, 0], [board.width, 0], [board.width, board.height], [0, board.height]]) @ rotated.T
    shift = 12 - outer.min(axis=0)
    # Perspective: the far end is the smaller one.
    nearness = 1.0 + 0.15 * np.sin(turn)
    outer[[1, 2], 1] = outer[[1, 2], 1].mean() + (outer[[1, 2], 1] - outer[[1, 2], 1].mean()) * nearness
    rows, columns = board.image.shape[:2]
    source = np.array([[0, 0], [columns, 0], [columns, rows], [0, rows]], np.float32)
    warp = cv2.getPerspectiveTransform(source, (3 * (outer + shift)).astype(np.float32))
    size = np.ceil(np.ptp(outer, axis=0) + 24).astype(int)
    ground = rng.uniform(60, 200, 3)
    large = cv2.warpPerspective(
        cv2.GaussianBlur(board.image, (0, 0), max(0.4 * columns / (3 * size[0]), 0.3)),
        warp,
        (3 * int(size[0]), 3 * int(size[1])),
        borderValue=ground.tolist(),
    )
    picture = cv2.resize(large, (int(size[0]), int(size[1])), interpolation=cv2.INTER_AREA).astype(np.float64)
    if rng.random() < 0.6:
        length = int(rng.choice([3, 5]))
        picture = cv2.filter2D(picture, -1, np.full((1, length), 1.0 / length))
    if rng.random() < 0.7:
        picture = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.4, 1.3))
    if rng.random() < 0.4:
        picture *= rng.uniform(0.12, 0.5)
    picture += rng.normal(0, rng.uniform(1, 9), picture.shape)
    coded = cv2.imencode(".jpg", np.clip(picture, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 60])[1]
    inner = np.array(
        [[line.left, line.top], [line.right, line.top], [line.right, line.bottom], [line.left, line.bottom]]
    )
    pixels = np.column_stack([inner * columns / board.width, np.ones(4)]) @ warp.T
    box = pixels[:, :2] / pixels[:, 2:] / 3
    along = (box[1] - box[0]) / np.linalg.norm(box[1] - box[0])
    down = box[3] - box[0]
    grown = [rng.uniform(0.08, 0.25)] * 2
    if rng.random() < 0.18:
        grown[int(rng.integers(2))] = -rng.uniform(0.1, 0.7)
    height = np.linalg.norm(down)
    left, right = along * height * grown[0], along * height * grown[1]
    down = 0.15 * down
    box = np.array([box[0] - left - down, box[1] + right - down, box[2] + right + down, box[3] - left + down])
    return cv2.imdecode(coded, cv2.IMREAD_COLOR), box + rng.normal(0, 0.04 * height, (4, 2))


def accepted(painted: str) -> list[str]:
    """Every form of a name that counts as right: case apart, and a gap between scripts or around a mark."""
    forms = [painted, painted.upper(), painted.title() if painted.isupper() else painted]
    forms += [form.replace(mark, mark.strip()) for form in forms for mark in (" & ", ". ")]
    if not painted.isascii():
        forms.append(painted.replace(" ", ""))
    return list(dict.fromkeys(forms))


def main() -> None:
    """Write one group a line."""
    recogniser = TextRecogniser(load_network("rec", "auto", 1), SpottingConfig())
    groups = []
    for kind, names in SIGNS.items():
        for at, painted in enumerate(names.split("|")):
            rng = np.random.default_rng([SEED, *kind.encode(), at])
            style = (
                "plain" if kind in ("warning", "facility", "digits") else str(rng.choice(["plain", "shop", "friendly"]))
            )
            board = paint_board(rng, (painted,), "warning" if kind == "warning" else "shop", style, 0.12, 6.0, 400)
            found: dict[str, list[float]] = {}
            for _ in range(int(rng.integers(*VIEWS))):
                picture, box = photograph(rng, board)
                text, sure, *_ = recogniser.recognise(np.ascontiguousarray(picture), box[None])[0]
                text = text.strip()
                if len(text) > 1 and sure >= SURE and Levenshtein.normalized_similarity(text, painted) >= 0.4:
                    found.setdefault(text, []).append(sure)
            readings = [[text, len(each), round(float(np.mean(each)), 2)] for text, each in found.items()]
            if sum(count for _, count, _ in readings) >= LEAST:
                readings.sort(key=lambda reading: (-reading[1], -reading[2]))
                groups.append({"readings": readings, "expected": accepted(painted), "category": kind})
    lines = ",\n".join("  " + json.dumps(group, ensure_ascii=False) for group in groups)
    Path(sys.argv[1]).write_text(f'{{\n "naming": [\n{lines}\n ]\n}}\n', encoding="utf-8")
    print(f"{len(groups)} groups")


if __name__ == "__main__":
    main()
