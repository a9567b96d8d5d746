/* Signs in space: plates in the plane of their sign where they can be read, else labels, and one for many where these
   would lie on each other. */
const FONT = 'system-ui, "Noto Sans", "Noto Sans CJK SC", sans-serif';
let shownSigns = [];  // boxes of what was drawn last, with the signs that each stands for

const overlaps = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const shortened = name => name.length > 40 ? name.slice(0, 39) + "…" : name;

/* A sign's name, painted: white on the colour of its judgement. */
function platePicture(sign) {
  const own = document.createElement("canvas"), brush = own.getContext("2d"), name = shortened(sign.name);
  brush.font = `600 44px ${FONT}`;
  own.width = Math.min(Math.ceil(brush.measureText(name).width) + 44, 1600);
  own.height = 72;
  brush.font = `600 44px ${FONT}`;
  brush.fillStyle = style(plateColour(sign));
  brush.beginPath();
  brush.roundRect(0, 0, own.width, 72, 18);
  brush.fill();
  brush.fillStyle = "#ffffff";
  brush.textAlign = "center";
  brush.textBaseline = "middle";
  brush.fillText(name, own.width / 2, 38, own.width - 30);
  if (sign === state.chosen) {
    brush.lineWidth = 6;
    brush.strokeStyle = "#ffffff";
    brush.beginPath();
    brush.roundRect(5, 5, own.width - 10, 62, 14);
    brush.stroke();
  }
  return own;
}

const plateColour = sign => sign.is_landmark === true ? "--plate-shop" : sign.is_landmark === false ? "--plate-text" : "--plate-unjudged";

/* Where a sign's plate hangs: above it, in its plane, the surer the larger; its middle and two half sides. */
function plateOf(sign) {
  const out = Math.hypot(...sign.normal) > 0.5 ? unit(sign.normal) : [lens.eye[0] - sign.position[0], lens.eye[1] - sign.position[1], 0];
  let up = plus([0, 0, 1], out, -out[2]);
  if (Math.hypot(...up) < 0.3) up = plus([0, 1, 0], out, -out[1]);
  up = unit(up);
  const key = `${sign.id} ${sign.name} ${plateColour(sign)} ${sign === state.chosen} ${style("--paper")}`;
  const high = clamped(0.5 * (sign.height || 0.3), 0.13, 0.3) * (0.6 + 0.4 * sign.confidence);
  pen.font = `600 44px ${FONT}`;
  const wide = high * (Math.min(pen.measureText(shortened(sign.name)).width + 44, 1600) / 72), right = unit(cross(up, out));
  const middle = plus(plus(sign.position, up, (sign.height || 0.2) / 2 + high / 2 + 0.05), out, 0.04);
  return { sign, key, out, middle, high, right: right.map(value => value * wide / 2), up: up.map(value => value * high / 2) };
}

/* The box of a plate on the canvas; null where it cannot be read from here. */
function plateBox(plate) {
  const towards = plus(lens.eye, plate.middle, -1), away = Math.hypot(...towards);
  if (dot(towards, plate.out) < 0.35 * away * Math.hypot(...plate.out) || plate.high * lens.focal / away < 11) return null;
  const corners = [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(([x, y]) => projected(plus(plus(plate.middle, plate.right, x), plate.up, y)));
  if (corners.some(corner => !corner)) return null;
  const xs = corners.map(corner => corner[0]), ys = corners.map(corner => corner[1]);
  const box = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  return overlaps(box, [0, 0, lens.wide, lens.high]) ? box : null;
}

/* What of all signs is shown, and how: plates first, the largest on the canvas before the others. */
function arrangeSigns() {
  const found = data.signs.map(sign => { const plate = plateOf(sign); return { ...plate, box: plateBox(plate), away: Math.hypot(...plus(lens.eye, sign.position, -1)) }; });
  found.sort((a, b) => (b.sign === state.chosen) - (a.sign === state.chosen) || b.high / b.away - a.high / a.away);
  const plates = [], rest = [];
  for (const each of found) {
    if (each.box && !plates.some(other => overlaps(other.box, each.box))) plates.push(each);
    else rest.push(each);
  }
  return { plates, rest };
}

function drawPlates(plates) {
  for (const each of plates) surface(pictureTexture(each.key, () => platePicture(each.sign)), each.middle, each.right, each.up, 0.5, 0.15);
}

/* Labels of the signs whose plates are not shown: those that find no room join the nearest one that did. */
function arrangeLabels(plates, rest) {
  const taken = plates.map(each => ({ box: each.box, signs: [each.sign] })), labels = [], panel = panelBox();
  const ranked = [...rest].sort((a, b) => (b.sign === state.chosen) - (a.sign === state.chosen) || (b.sign.is_landmark === true) - (a.sign.is_landmark === true) || b.sign.confidence - a.sign.confidence || a.away - b.away);
  for (const { sign, out, away } of ranked) {
    // Through a camera's lens, backs of signs and far rooms are out of sight.
    if (lens.isFirstPerson && (away > 12 || dot(plus(lens.eye, sign.position, -1), out) < 0)) continue;
    const at = projected(sign.position);
    if (!at || !overlaps([at[0], at[1], at[0], at[1]], [-20, -20, lens.wide + 20, lens.high + 20])) continue;
    const size = 10.5 + 3.5 * sign.confidence, name = shortened(sign.name);
    pen.font = `600 ${size}px ${FONT}`;
    const wide = pen.measureText(name).width + 12, high = size + 9;
    const box = [[8, -high / 2], [-wide - 8, -high / 2], [-wide / 2, -high - 8], [-wide / 2, 8]].map(([x, y]) => [at[0] + x, at[1] + y, at[0] + x + wide, at[1] + y + high]).find(each => !overlaps(each, panel) && !taken.some(other => overlaps(each, other.box)));
    if (box) {
      const label = { box, at, name, size, signs: [sign] };
      taken.push(label);
      labels.push(label);
      continue;
    }
    // Behind the panel there is no label to join.
    if (overlaps([at[0], at[1], at[0], at[1]], panel) || !taken.length) continue;
    const apart = other => Math.hypot((other.box[0] + other.box[2]) / 2 - at[0], (other.box[1] + other.box[3]) / 2 - at[1]);
    taken.reduce((best, other) => apart(other) < apart(best) ? other : best).signs.push(sign);
  }
  return { taken, labels };
}

function drawLabels(labels) {
  for (const { box, at, name, size, signs: [sign] } of labels) {
    const isChosen = sign === state.chosen, tone = tint(sign), x = clamped(at[0], box[0], box[2]), y = clamped(at[1], box[1], box[3]);
    pen.strokeStyle = pen.fillStyle = tone;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(at[0], at[1]);
    pen.lineTo(x, y);
    pen.stroke();
    pen.beginPath();
    pen.arc(at[0], at[1], isChosen ? 5 : 3, 0, 7);
    pen.fill();
    pen.fillStyle = style("--glass");
    pen.beginPath();
    pen.roundRect(box[0], box[1], box[2] - box[0], box[3] - box[1], 6);
    pen.fill();
    if (isChosen) pen.stroke();
    pen.fillStyle = tone;
    pen.font = `600 ${size}px ${FONT}`;
    pen.textBaseline = "middle";
    pen.fillText(name, box[0] + 6, (box[1] + box[3]) / 2 + 0.5, box[2] - box[0] - 10);
  }
}

/* How many more signs a plate or a label stands for. */
function drawCounts(taken) {
  for (const { box, signs } of taken) {
    if (signs.length < 2) continue;
    const text = `+${signs.length - 1}`;
    pen.font = `600 10.5px ${FONT}`;
    const wide = Math.max(pen.measureText(text).width + 8, 18), x = box[2] - wide + 4, y = box[1] - 6;
    pen.fillStyle = style("--ink");
    pen.beginPath();
    pen.roundRect(x, y, wide, 15, 7.5);
    pen.fill();
    pen.fillStyle = style("--ground");
    pen.textBaseline = "middle";
    pen.fillText(text, x + (wide - pen.measureText(text).width) / 2, y + 8);
  }
}
