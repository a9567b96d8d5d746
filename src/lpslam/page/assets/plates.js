/* Signs in space: plates in the plane of their sign where they can be read, else labels, and one for many where these
   would lie on each other. */
const FONT = 'system-ui, "Noto Sans", "Noto Sans CJK SC", sans-serif';
let shownSigns = [];  // boxes of what was drawn last, with the signs that each stands for

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

/* What of signs does not change with the view: made once for the signs there are, the most important first. */
const shapes = { of: null, all: [] };

function signShapes() {
  if (shapes.of === data.signs) return shapes.all;
  pen.font = `600 44px ${FONT}`;
  shapes.of = data.signs;
  shapes.all = data.signs.map(sign => {
    const name = shortened(sign.name), shape = { sign, name, letters: pen.measureText(name).width, high: clamped(0.5 * (sign.height || 0.3), 0.13, 0.3) * (0.6 + 0.4 * sign.confidence) };
    return { ...shape, plate: Math.hypot(...sign.normal) > 0.5 ? plateOf(shape, unit(sign.normal)) : null };
  });
  shapes.all.sort((a, b) => (b.sign.is_landmark === true) - (a.sign.is_landmark === true) || b.sign.confidence - a.sign.confidence);
  return shapes.all;
}

/* Where a sign's plate hangs: above it, in its plane, the surer the larger; its middle and two half sides. */
function plateOf({ sign, letters, high }, out) {
  let up = plus([0, 0, 1], out, -out[2]);
  if (Math.hypot(...up) < 0.3) up = plus([0, 1, 0], out, -out[1]);
  up = unit(up);
  const wide = high * (Math.min(letters + 44, 1600) / 72), right = unit(cross(up, out));
  const middle = plus(plus(sign.position, up, (sign.height || 0.2) / 2 + high / 2 + 0.05), out, 0.04);
  return { out, middle, right: right.map(value => value * wide / 2), up: up.map(value => value * high / 2) };
}

/* The box of a plate on the canvas; null where it cannot be read from here. */
function plateBox({ out, middle, right, up }, high) {
  const towards = plus(lens.eye, middle, -1), away = Math.hypot(...towards);
  if (dot(towards, out) < 0.35 * away * Math.hypot(...out) || high * lens.focal / away < 11) return null;
  const corners = [[1, 1], [1, -1], [-1, 1], [-1, -1]].map(([x, y]) => projected(plus(plus(middle, right, x), up, y)));
  if (corners.some(corner => !corner)) return null;
  const xs = corners.map(corner => corner[0]), ys = corners.map(corner => corner[1]);
  const box = [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
  return overlaps(box, [0, 0, lens.wide, lens.high]) ? box : null;
}

/* The signs that are on the canvas or about to be, at most so many, the most important first: each with where it is
   there, how far, and whether something hides it. */
function signsInView(most) {
  const [across, down, , ahead] = lens.rows, [ex, ey, ez] = lens.eye, wide = lens.wide, high = lens.high, found = [];
  for (const shape of signShapes()) {
    const { sign } = shape, [x, y, z] = sign.position, w = ahead[0] * x + ahead[1] * y + ahead[2] * z + ahead[3];
    // A plate that begins behind the eye is none that can be read.
    if (w < NEAR) continue;
    const u = ((across[0] * x + across[1] * y + across[2] * z + across[3]) / w + 1) / 2 * wide, v = (1 - (down[0] * x + down[1] * y + down[2] * z + down[3]) / w) / 2 * high;
    const reach = 40 + 3 * lens.focal * shape.high / w * shape.letters / 72;
    if (u < -reach || v < -reach || u > wide + reach || v > high + reach) continue;
    if (found.length >= most && sign !== state.chosen) continue;
    const isChosen = sign === state.chosen, away = Math.hypot(ex - x, ey - y, ez - z);
    found.push({ ...shape, at: [u, v], away, isChosen, isHidden: !isChosen && isBehind(sign.position) });
  }
  return found;
}

/* What of all signs is shown, and how: plates first, the largest on the canvas before the others. */
function arrangeSigns(most) {
  const plates = [], rest = [], boxes = new Boxes();
  for (const each of signsInView(most)) {
    const { sign, high, away } = each;
    const plate = high * lens.focal / away < 11 || each.isHidden ? null : each.plate || plateOf(each, [lens.eye[0] - sign.position[0], lens.eye[1] - sign.position[1], 0]);
    each.box = plate && plateBox(plate, high);
    if (each.box) plates.push(Object.assign(each, plate)); else rest.push(each);
  }
  plates.sort((a, b) => b.isChosen - a.isChosen || b.high / b.away - a.high / a.away);
  const shown = [];
  for (const each of plates) {
    if (boxes.meets(each.box)) rest.push(each);
    else {
      boxes.add({ box: each.box, signs: [each.sign] });
      shown.push(each);
    }
  }
  return { plates: shown, rest };
}

const plateKey = ({ sign }) => `${sign.id} ${sign.name} ${plateColour(sign)} ${sign === state.chosen} ${style("--paper")}`;

function drawPlates(plates) {
  for (const each of plates) surface(pictureTexture(plateKey(each), () => platePicture(each.sign)), each.middle, each.right, each.up, 0.5, 0.15);
}

/* Labels of the signs whose plates are not shown, those in sight first: what finds no room joins the nearest one that did. */
function arrangeLabels(plates, rest) {
  const boxes = new Boxes(), labels = [], panel = panelBox(), isPlaced = item => !item.isPanel;
  for (const box of coveredBoxes()) boxes.add({ box, isPanel: true });
  for (const each of plates) boxes.add({ box: each.box, signs: [each.sign] });
  const inTurn = [...rest.filter(each => each.isChosen), ...rest.filter(each => !each.isChosen && !each.isHidden), ...rest.filter(each => each.isHidden)];
  for (const { sign, name, letters, at, away, isHidden } of inTurn) {
    // Through a camera's lens, backs of signs, far rooms and what is behind a wall are out of sight.
    if (lens.isFirstPerson && sign !== state.chosen && (isHidden || away > 12 || dot(plus(lens.eye, sign.position, -1), sign.normal) < 0)) continue;
    const [x, y] = at;
    if (x < -20 || y < -20 || x > lens.wide + 20 || y > lens.high + 20) continue;
    const size = 10.5 + 3.5 * sign.confidence, wide = letters * size / 44 + 12, high = size + 9;
    const box = [[8, -high / 2], [-wide - 8, -high / 2], [-wide / 2, -high - 8], [-wide / 2, 8]].map(([dx, dy]) => [x + dx, y + dy, x + dx + wide, y + dy + high]).find(each => each[0] >= 0 && each[2] <= lens.wide && !boxes.meets(each));
    if (box) {
      const label = { box, at, name, size, isHidden, signs: [sign] };
      boxes.add(label);
      labels.push(label);
      continue;
    }
    // Behind the panel there is no label to join.
    if (overlaps([x, y, x, y], panel)) continue;
    const joined = boxes.nearest(x, y, isPlaced);
    if (joined) joined.signs.push(sign);
  }
  return { taken: boxes.all.filter(isPlaced), labels };
}

function drawLabels(labels) {
  for (const { box, at, name, size, isHidden, signs: [sign] } of labels) {
    const isChosen = sign === state.chosen, tone = tint(sign), x = clamped(at[0], box[0], box[2]), y = clamped(at[1], box[1], box[3]);
    pen.globalAlpha = isHidden ? 0.3 : 1;
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
  pen.globalAlpha = 1;
}

/* How many more signs a plate or a label stands for. */
function drawCounts(taken) {
  for (const { box, signs } of taken) {
    if (signs.length < 2) continue;
    const text = `+${signs.length - 1}`;
    pen.font = `600 10.5px ${FONT}`;
    const wide = Math.max(pen.measureText(text).width + 8, 18), x = box[2] - wide + 8, y = box[1] - 9;
    pen.fillStyle = style("--ink");
    pen.beginPath();
    pen.roundRect(x, y, wide, 15, 7.5);
    pen.fill();
    pen.fillStyle = style("--ground");
    pen.textBaseline = "middle";
    pen.fillText(text, x + (wide - pen.measureText(text).width) / 2, y + 8);
  }
}
