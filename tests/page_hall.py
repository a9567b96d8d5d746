"""A hall of points put into a page, and how fast it turns: for a test, and for a benchmark."""

import json
from typing import Any

_HALL = """([count, isRoofed]) => {
  const bytes = new ArrayBuffer(32 + 8 * count), rows = new Uint16Array(bytes, 32);
  new Float32Array(bytes, 0, 8).set([count, -20, -20, -1, 40, 40, 4, 0.04]);
  const chance = () => Math.floor(Math.random() * 65536);
  for (let at = 0; at < 4 * count; at += 4) {
    const wall = chance() % (isRoofed ? 6 : 5);
    rows[at] = wall === 1 ? 0 : wall === 2 ? 65535 : chance();
    rows[at + 1] = wall === 3 ? 0 : wall === 4 ? 65535 : chance();
    rows[at + 2] = wall === 5 ? 65535 : wall ? chance() : 0;
    rows[at + 3] = chance();
  }
  lpslamPage.take(bytes);
}"""

_SIGNS = """count => {
  const side = Math.ceil(Math.sqrt(count)), faces = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]];
  lpslamPage.takeSigns(Array.from({ length: count }, (_, at) => ({
    id: at * 1000, name: `SHOP ${at} 商店`,
    lines: [`SHOP ${at}`], variants: {}, normal: faces[at % 4], width: 1.2, height: 0.3,
    position: [(at % side / side - 0.5) * 38, (Math.floor(at / side) / side - 0.5) * 38, 1 + at % 3 / 2], spread: 0.05,
    observations: 1 + at % 40, confidence: at * 7919 % 100 / 100, corrections: [],
    is_landmark: [true, false, null][at % 3],
  })));
}"""

_TURNING = """seconds => new Promise(done => {
  const began = performance.now(), first = lpslamPage.pace().frames, map = document.getElementById("map");
  (function on() {
    map.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
    const passed = (performance.now() - began) / 1000, { frames, milliseconds, budget } = lpslamPage.pace();
    if (passed < seconds) return requestAnimationFrame(on);
    const rate = Math.round((frames - first) / passed * 10) / 10;
    done(JSON.stringify({ rate, milliseconds: Math.round(milliseconds), points: budget }));
  })();
})"""


def hall(page: Any, count: int, *, is_roofed: bool = False) -> None:
    """Put a hall of 40 m by 40 m and 4 m into a page: floor, walls and perhaps a ceiling 3 m over the camera.

    Its points are in an order that is a sample at every length.
    """
    page.evaluate(_HALL, [count, is_roofed])


def signs(page: Any, count: int) -> None:
    """Hang so many signs all over the hall."""
    page.evaluate(_SIGNS, count)


def turned(page: Any, seconds: float) -> dict[str, float]:
    """Turn the view for some seconds: frames a second, and milliseconds and points of the last frame."""
    told: dict[str, float] = json.loads(page.evaluate(_TURNING, seconds))
    return told
