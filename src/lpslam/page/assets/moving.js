/* Hands and keys: drag, wheel, two fingers, arrows. */
let held = null;
const fingers = new Map();

function moved() {
  isWholeShown = false;
  draw();
}

canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  held = { moved: 0 };
  flight++;
});
canvas.addEventListener("pointermove", event => {
  if (!fingers.has(event.pointerId)) return;
  const [x, y] = fingers.get(event.pointerId);
  if (fingers.size === 2) {
    const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    view.scale *= Math.hypot(event.clientX - other[0], event.clientY - other[1]) / Math.max(Math.hypot(x - other[0], y - other[1]), 1);
  } else {
    view.x -= (event.clientX - x) / view.scale;
    view.y += (event.clientY - y) / view.scale;
  }
  if (held) held.moved += Math.abs(event.clientX - x) + Math.abs(event.clientY - y);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  moved();
});

function release(event) {
  fingers.delete(event.pointerId);
  const wasClick = held && held.moved <= 6 && event.type !== "pointercancel";
  held = null;
  if (!wasClick) return;
  const distance = sign => { const [x, y] = toScreen(...sign.position); return Math.hypot(x - event.clientX, y - event.clientY); };
  const near = [...data.signs].sort((a, b) => distance(a) - distance(b))[0];
  if (near && distance(near) < 24) pick(near, false);
}

canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  const factor = Math.exp(-event.deltaY / 500), dx = event.clientX - canvas.clientWidth / 2, dy = canvas.clientHeight / 2 - event.clientY;
  view.x += dx / view.scale * (1 - 1 / factor);
  view.y += dy / view.scale * (1 - 1 / factor);
  view.scale = Math.min(Math.max(view.scale * factor, 2), 2000);
  moved();
}, { passive: false });
canvas.addEventListener("keydown", event => {
  const step = 60 / view.scale, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
  if (moves[event.key]) { view.x += moves[event.key][0]; view.y += moves[event.key][1]; }
  else if (event.key === "+" || event.key === "=") view.scale *= 1.2;
  else if (event.key === "-") view.scale /= 1.2;
  else if (event.key === "0") return fit();
  else return;
  event.preventDefault();
  moved();
});
window.addEventListener("resize", () => isWholeShown ? fit() : draw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
