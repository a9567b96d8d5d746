/* Hands and keys: drag, wheel, two fingers, arrows. */
let held = null;
const fingers = new Map();

function moved() {
  isWholeShown = false;
  leaveLens();
  draw();
}

canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.clientX, event.clientY]);
  held = { moved: 0, isPanning: event.shiftKey || event.button === 2 };
  flight++;
});
/* In space: turn around what is looked at, or slide along. */
function turnBy(yaw, pitch) {
  leaveLens();
  around.yaw += yaw;
  around.pitch = clamped(around.pitch + pitch, -0.5, 1.5);
}

function slide(x, y) {
  leaveLens();
  const { right } = aroundAxes(), metres = around.far * Math.tan(FIELD / 2) * 2 / canvas.clientHeight;
  const ahead = [-Math.cos(around.yaw), -Math.sin(around.yaw), 0];
  around.at = plus(plus(around.at, right, -x * metres), ahead, y * metres);
}

canvas.addEventListener("contextmenu", event => { if (state.isSpatial) event.preventDefault(); });
canvas.addEventListener("pointermove", event => {
  if (!fingers.has(event.pointerId)) return;
  const [x, y] = fingers.get(event.pointerId);
  if (fingers.size === 2) {
    const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const nearer = Math.hypot(event.clientX - other[0], event.clientY - other[1]) / Math.max(Math.hypot(x - other[0], y - other[1]), 1);
    if (state.isSpatial) {
      around.far = clamped(around.far / nearer, 0.4, FARTHEST);
      slide((event.clientX - x) / 2, (event.clientY - y) / 2);
    } else view.scale *= nearer;
  } else if (state.isSpatial) {
    if (held && held.isPanning) slide(event.clientX - x, event.clientY - y);
    else turnBy(-(event.clientX - x) / 180, (event.clientY - y) / 180);
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
  if (state.isSpatial) return pickInSpace(event.clientX, event.clientY);
  const distance = sign => { const [x, y] = toScreen(...sign.position); return Math.hypot(x - event.clientX, y - event.clientY); };
  const near = [...data.signs].sort((a, b) => distance(a) - distance(b))[0];
  if (near && distance(near) < 24) pick(near, false);
}

function pickInSpace(x, y) {
  const hit = shownSigns.find(({ box }) => x >= box[0] - 4 && x <= box[2] + 4 && y >= box[1] - 6 && y <= box[3] + 4);
  if (!hit) return;
  pick(hit.signs[0], false);
  if (hit.signs.length > 1) flyToAll(hit.signs);
}

canvas.addEventListener("pointerup", release);
canvas.addEventListener("pointercancel", release);
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  if (state.isSpatial) {
    leaveLens();
    around.far = clamped(around.far * Math.exp(event.deltaY / 700), 0.4, FARTHEST);
    return moved();
  }
  const factor = Math.exp(-event.deltaY / 500), dx = event.clientX - canvas.clientWidth / 2, dy = canvas.clientHeight / 2 - event.clientY;
  view.x += dx / view.scale * (1 - 1 / factor);
  view.y += dy / view.scale * (1 - 1 / factor);
  view.scale = Math.min(Math.max(view.scale * factor, 2), 2000);
  moved();
}, { passive: false });
/* What keys do in space: true where one does something. */
function keyInSpace(event) {
  const [x, y] = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key] || [0, 0];
  if (x || y) event.shiftKey ? slide(x * 60, y * 60) : turnBy(x * 0.12, y * 0.08);
  else if (event.key === "+" || event.key === "=") around.far = Math.max(around.far / 1.2, 0.4);
  else if (event.key === "-") around.far = Math.min(around.far * 1.2, FARTHEST);
  else return false;
  return true;
}

canvas.addEventListener("keydown", event => {
  flight++;
  if (event.key === "0") return showAll();
  if (state.isSpatial) {
    if (!keyInSpace(event)) return;
    event.preventDefault();
    return moved();
  }
  const step = 60 / view.scale, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
  if (moves[event.key]) { view.x += moves[event.key][0]; view.y += moves[event.key][1]; }
  else if (event.key === "+" || event.key === "=") view.scale *= 1.2;
  else if (event.key === "-") view.scale /= 1.2;
  else return;
  event.preventDefault();
  moved();
});
/* All of it, in space from high enough to see the ground. */
function showAll() {
  flight++;
  leaveLens();
  around.pitch = FROM_ABOVE;
  fit();
}

part("whole").addEventListener("click", showAll);
/* On paper the panel is below the map, and hides nothing. */
for (const [name, printed] of [["beforeprint", true], ["afterprint", false]]) window.addEventListener(name, () => {
  isPrinted = printed;
  if (!state.isSpatial) isWholeShown ? fitPlan() : paintPlan(Infinity);
});
window.addEventListener("resize", () => isWholeShown ? fit() : draw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
