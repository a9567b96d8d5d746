/* The map from above: a picture of the ground, the camera's way, and signs as labels that do not overlap. */
const picture = new Image();
const view = { x: 0, y: 0, scale: 60 };
let flight = 0, isWholeShown = true;

const tint = sign => style(sign.is_landmark === true ? "--shop" : sign.is_landmark === false ? "--text" : "--unjudged");
const toScreen = (x, y) => [canvas.clientWidth / 2 + (x - view.x) * view.scale, canvas.clientHeight / 2 - (y - view.y) * view.scale];

/* What the panel hides: at the left of a wide window, at the bottom of a narrow one. */
function covered() {
  if (canvas.clientWidth <= 640) return [0, canvas.clientHeight * 0.52];
  return [360, part("memory").hidden ? 0 : part("memory").offsetHeight + 16];
}

/* The same as a box of the canvas, where no label is to be read. */
function panelBox() {
  const [left, bottom] = covered(), wide = canvas.clientWidth, high = canvas.clientHeight;
  return wide <= 640 ? [0, high - bottom, wide, high] : [0, 0, left, high];
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

function drawPlan() {
  clearCanvas();
  pen.fillStyle = style("--paper");
  pen.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  pen.imageSmoothingEnabled = view.scale < 80;
  if (data.ground) spread(groundPicture, data.ground.extent);
  if (data.picture_extent) spread(picture, data.picture_extent);
  trace(data.trajectory, style("--way"), 1.5, .55);
  trace(state.way, style("--route"), 5, .9);
  if (state.goal) for (const line of goalLines(state.goal, 0)) trace(line, style("--route"), 3, .9);
  drawCamera();
  const taken = [panelBox()];
  const ordered = [...data.signs].sort((a, b) => (b === state.chosen) - (a === state.chosen) || (b.is_landmark === true) - (a.is_landmark === true) || b.observations - a.observations);
  for (const sign of ordered) label(sign, taken);
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

function label(sign, taken) {
  const [x, y] = toScreen(...sign.position), is = sign === state.chosen;
  if (x < -50 || y < -50 || x > canvas.clientWidth + 50 || y > canvas.clientHeight + 50) return;
  pen.fillStyle = tint(sign);
  pen.strokeStyle = style("--ground");
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.arc(x, y, is ? 7 : 4.5, 0, 7);
  pen.fill();
  pen.stroke();
  pen.strokeStyle = tint(sign);
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + sign.normal[0] * 14, y - sign.normal[1] * 14);
  pen.stroke();
  pen.font = `${is ? "600 15px" : "13px"} system-ui, "Noto Sans", "Noto Sans CJK SC", sans-serif`;
  const name = sign.name.length > 40 ? sign.name.slice(0, 39) + "…" : sign.name, width = pen.measureText(name).width + 10;
  for (const [dx, dy] of [[10, -11], [-width - 10, -11], [-width / 2, -32], [-width / 2, 12]]) {
    const box = [x + dx, y + dy, x + dx + width, y + dy + 22];
    if (!is && taken.some(other => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3])) continue;
    taken.push(box);
    pen.fillStyle = style("--glass");
    pen.fillRect(box[0], box[1], width, 22);
    pen.fillStyle = tint(sign);
    pen.textBaseline = "middle";
    pen.fillText(name, box[0] + 5, box[1] + 11.5);
    return;
  }
}

function scaleBar() {
  const metres = [0.5, 1, 2, 5, 10, 20, 50, 100].find(each => each * view.scale > 60) || 200, width = metres * view.scale;
  const x = canvas.clientWidth - width - 24, y = canvas.clientHeight - 24 - covered()[1];
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
