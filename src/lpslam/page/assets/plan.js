/* The map from above: a picture of the ground, the camera's way, and signs as labels that do not overlap. */
const picture = new Image();
const view = { x: 0, y: 0, scale: 60 };
let flight = 0, isWholeShown = true, isPrinted = false;

const tint = sign => style(sign.is_landmark === true ? "--shop" : sign.is_landmark === false ? "--text" : "--unjudged");
const toScreen = (x, y) => [canvas.clientWidth / 2 + (x - view.x) * view.scale, canvas.clientHeight / 2 - (y - view.y) * view.scale];

/* As the style has it, pixels. */
const panelWidth = () => canvas.clientWidth <= 900 ? 264 : 340;

const plotHeight = () => part("memory").hidden ? 0 : part("memory").offsetHeight + 16;

/* What the panel and the bars hide at the left and at the bottom: of a narrow window the panel is at its bottom. */
function covered() {
  if (isPrinted) return [0, 0];
  const walk = part("replay").offsetHeight, bar = walk && walk + 16;
  if (canvas.clientWidth <= 640) return [0, canvas.clientHeight * 0.5 + bar];
  return [panelWidth() + 20, plotHeight() + bar];
}

/* The same as a box of the canvas, where no label is to be read. */
function panelBox() {
  const [left, bottom] = covered(), wide = canvas.clientWidth, high = canvas.clientHeight;
  if (isPrinted) return [0, 0, 0, 0];
  return wide <= 640 ? [0, high - bottom, wide, high] : [0, 0, left, high];
}

/* All that lies over the canvas, where no label is to be read. */
function coveredBoxes() {
  const bars = isPrinted ? [] : [part("replay"), part("modes")].map(bar => bar.getBoundingClientRect());
  return [panelBox(), ...bars.map(({ left, top, right, bottom }) => [left, top, right, bottom])];
}

function extent() {
  const xs = [], ys = [];
  const take = (x, y) => { xs.push(x); ys.push(y); };
  if (data.picture_extent) {
    take(data.picture_extent[0], data.picture_extent[1]);
    take(data.picture_extent[2], data.picture_extent[3]);
  }
  for (const [x, y] of data.trajectory) take(x, y);
  for (const sign of data.signs) take(sign.position[0], sign.position[1]);
  if (!xs.length) take(0, 0);
  const least = values => values.reduce((a, b) => Math.min(a, b)), most = values => values.reduce((a, b) => Math.max(a, b));
  return [least(xs) - 1, least(ys) - 1, most(xs) + 1, most(ys) + 1];
}

function fitPlan() {
  const [left, bottom, right, top] = extent(), [wide, high] = covered();
  view.scale = Math.min((canvas.clientWidth - wide) / (right - left || 1), (canvas.clientHeight - high) / (top - bottom || 1)) * 0.94;
  view.x = (left + right) / 2 - wide / 2 / view.scale;
  view.y = (bottom + top) / 2 - high / 2 / view.scale;
  isWholeShown = true;
  drawPlan();
}

/* The canvas cleared, to be drawn on in pixels of the style. */
function clearCanvas() {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = canvas.clientWidth * ratio;
  canvas.height = canvas.clientHeight * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
}

const IN_MOTION = 1500, REST = 200;  // marks that a processor alone paints ten times a second; milliseconds
let resting = 0;

/* While the view moves, the first of many signs; all of them once it rests. */
function drawPlan() {
  clearTimeout(resting);
  if (data.signs.length > IN_MOTION) resting = setTimeout(() => { if (!state.isSpatial) paintPlan(Infinity); }, REST);
  paintPlan(IN_MOTION);
}

function paintPlan(most) {
  clearCanvas();
  pen.fillStyle = style("--paper");
  pen.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  pen.imageSmoothingEnabled = view.scale < 80;
  if (data.ground) spread(groundPicture, data.ground.extent);
  if (data.picture_extent) spread(picture, data.picture_extent);
  trace(data.trajectory, style("--way"), 1.5, .55);
  trace(state.way, style("--route"), 5, .9);
  for (const leg of state.legs) for (const line of goalLines(leg, 0)) trace(line, style("--route"), 3, .9);
  drawCamera();
  const taken = new Boxes();
  for (const box of [...coveredBoxes(), scaleBox()]) taken.add({ box });
  const marked = marks(most), badges = stopBadges(([x, y]) => toScreen(x, y));
  badges.forEach(badge => taken.add(badge));
  for (const { sign, at } of marked) label(sign, at, taken);
  drawBadges(badges);
  scaleBar();
}

function spread(image, [left, bottom, right, top]) {
  if (!image.complete || !image.naturalWidth) return;
  pen.drawImage(image, ...toScreen(left, top), (right - left) * view.scale, (top - bottom) * view.scale);
}

function trace(points, colour, width, strength) {
  if (points.length < 2) return;
  pen.globalAlpha = strength;
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineJoin = "round";
  pen.beginPath();
  points.forEach(([x, y], at) => pen[at ? "lineTo" : "moveTo"](...toScreen(x, y)));
  pen.stroke();
  pen.globalAlpha = 1;
}

/* Where the camera is, and which way it looks: of a map that grows now, of another at the moment that is chosen. */
function drawCamera() {
  const pose = shownPose();
  if (!pose) return;
  const [x, y] = pose, heading = headingOf(pose), [u, v] = toScreen(x, y), half = 0.55, long = 34;
  pen.fillStyle = style("--way");
  pen.globalAlpha = .28;
  pen.beginPath();
  pen.moveTo(u, v);
  pen.lineTo(u + Math.cos(heading + half) * long, v - Math.sin(heading + half) * long);
  pen.lineTo(u + Math.cos(heading - half) * long, v - Math.sin(heading - half) * long);
  pen.fill();
  pen.globalAlpha = 1;
  pen.strokeStyle = style("--ground");
  pen.lineWidth = 2;
  pen.beginPath();
  pen.arc(u, v, 6, 0, 7);
  pen.fill();
  pen.stroke();
}

/* All signs, those whose labels come first before the others; sorted once for the signs there are. */
const ordered = { of: null, signs: [] };

function inOrder() {
  if (ordered.of !== data.signs) Object.assign(ordered, { of: data.signs, signs: [...data.signs].sort((a, b) => (b.is_landmark === true) - (a.is_landmark === true) || b.observations - a.observations) });
  return ordered.signs;
}

/* A mark for each of the first signs on the canvas, the chosen one over the others; where they are, the chosen one first. */
function marks(most) {
  const wide = canvas.clientWidth, high = canvas.clientHeight, found = [];
  for (const sign of state.chosen ? [state.chosen, ...inOrder()] : inOrder()) {
    const at = toScreen(...sign.position), [x, y] = at;
    if (x < -50 || y < -50 || x > wide + 50 || y > high + 50 || (sign === state.chosen && found.length)) continue;
    found.push({ sign, at });
    if (found.length >= most) break;
  }
  for (const { sign, at: [x, y] } of [...found].reverse()) pen.drawImage(markPicture(sign), x - MARK, y - MARK, 2 * MARK, 2 * MARK);
  return found;
}

const MARK = 16, TURNS = 64;  // pixels around a mark, and directions that are told apart
const painted = new Map();

/* A sign's mark, painted once for each colour, size and direction: ten thousand lines in a frame are too slow. */
function markPicture(sign) {
  const [x, y] = sign.normal, isChosen = sign === state.chosen, ratio = window.devicePixelRatio || 1;
  const turn = Math.hypot(x, y) > 0.3 ? Math.round(Math.atan2(y, x) / 2 / Math.PI * TURNS) : null;
  const key = `${tint(sign)} ${isChosen} ${turn} ${ratio} ${style("--ground")}`;
  if (painted.has(key)) return painted.get(key);
  const own = document.createElement("canvas"), brush = own.getContext("2d"), angle = turn * 2 * Math.PI / TURNS;
  own.width = own.height = Math.ceil(2 * MARK * ratio);
  brush.scale(own.width / 2 / MARK, own.width / 2 / MARK);
  brush.translate(MARK, MARK);
  Object.assign(brush, { fillStyle: tint(sign), strokeStyle: style("--ground"), lineWidth: 1.5 });
  brush.beginPath();
  brush.arc(0, 0, isChosen ? 7 : 4.5, 0, 7);
  brush.fill();
  brush.stroke();
  if (turn !== null) {
    Object.assign(brush, { strokeStyle: tint(sign), lineWidth: 2 });
    brush.beginPath();
    brush.moveTo(0, 0);
    brush.lineTo(Math.cos(angle) * 14, -Math.sin(angle) * 14);
    brush.stroke();
  }
  painted.set(key, own);
  return own;
}

function label(sign, [x, y], taken) {
  const is = sign === state.chosen;
  pen.font = `${is ? "600 15px" : "13px"} system-ui, "Noto Sans", "Noto Sans CJK SC", sans-serif`;
  const name = shortened(sign.name), width = letters(sign, is) + 10;
  const box = roomBeside(x, y, width, taken) || (is && [x + 10, y - 11, x + 10 + width, y + 11]);
  if (!box) return;
  taken.add({ box });
  pen.fillStyle = style("--glass");
  pen.fillRect(box[0], box[1], width, 22);
  pen.fillStyle = tint(sign);
  pen.textBaseline = "middle";
  pen.fillText(name, box[0] + 5, box[1] + 11.5);
}

/* Where a label so wide lies beside a mark and on nothing else. */
function roomBeside(x, y, width, taken) {
  for (const [dx, dy] of [[10, -11], [-width - 10, -11], [-width / 2, -32], [-width / 2, 12]]) {
    const box = [x + dx, y + dy, x + dx + width, y + dy + 22];
    if (box[0] >= 0 && box[2] <= canvas.clientWidth && !taken.meets(box)) return box;
  }
  return null;
}

/* How wide a sign's name is on the plan, in pixels: measured once. */
const measured = new WeakMap();

function letters(sign, isChosen) {
  if (isChosen) return pen.measureText(shortened(sign.name)).width;
  if (!measured.has(sign)) measured.set(sign, pen.measureText(shortened(sign.name)).width);
  return measured.get(sign);
}

/* How long the scale is, in metres and in pixels, and where it begins. */
function scaleAt() {
  const metres = [0.5, 1, 2, 5, 10, 20, 50, 100].find(each => each * view.scale > 60) || 200, width = metres * view.scale;
  // On a telephone it is above the walk.
  const y = canvas.clientHeight - 24 - (canvas.clientWidth <= 640 ? covered()[1] : plotHeight());
  return { metres, width, x: canvas.clientWidth - width - 24, y };
}

function scaleBox() {
  const { width, x, y } = scaleAt();
  return [x - 4, y - 20, x + width + 4, y + 6];
}

function scaleBar() {
  const { metres, width, x, y } = scaleAt();
  pen.fillStyle = style("--ink");
  pen.fillRect(x, y, width, 3);
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "bottom";
  pen.fillText(`${metres} m`, x, y - 4);
}

function flyTo(x, y, scale) {
  const from = { ...view }, began = performance.now(), mine = ++flight;
  const [wide, high] = covered().map(each => each / 2 / scale), long = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1 : 600;
  isWholeShown = false;
  (function step(now) {
    if (mine !== flight) return;
    const share = Math.min(Math.max(now - began, 0) / long, 1), eased = share * share * (3 - 2 * share);
    view.x = from.x + (x - wide - from.x) * eased;
    view.y = from.y + (y - high - from.y) * eased;
    view.scale = from.scale * Math.pow(scale / from.scale, eased);
    draw();
    if (share < 1) requestAnimationFrame(step);
  })(began);
}
