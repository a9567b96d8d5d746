"use strict";
/* The map from above: a picture of the ground, the camera's way, and signs as labels that do not overlap. Whatever a sign
   says is only ever text: it is drawn on the canvas or set as textContent. */
(() => {
  const data = JSON.parse(document.getElementById("map-data").textContent);
  const words = data.words[(navigator.language || "en").slice(0, 2)] || data.words.en;
  const canvas = document.getElementById("map"), pen = canvas.getContext("2d");
  const ask = document.getElementById("ask"), field = document.getElementById("question");
  const answer = document.getElementById("answer"), card = document.getElementById("card"), list = document.getElementById("signs");
  const picture = new Image();
  const view = { x: 0, y: 0, scale: 60 };
  let chosen = null, way = [], flight = 0, before = null;

  const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const tint = sign => style(sign.is_landmark === true ? "--shop" : sign.is_landmark === false ? "--text" : "--unjudged");
  const toScreen = (x, y) => [canvas.clientWidth / 2 + (x - view.x) * view.scale, canvas.clientHeight / 2 - (y - view.y) * view.scale];
  const fold = text => text.normalize("NFKD").replace(/\p{M}/gu, "").toLowerCase();

  /* What the panel hides: at the left of a wide window, at the bottom of a narrow one. */
  const covered = () => canvas.clientWidth > 640 ? [360, 0] : [0, canvas.clientHeight * 0.4];

  function fit() {
    const [left, bottom, right, top] = data.extent, [wide, high] = covered();
    view.scale = Math.min((canvas.clientWidth - wide) / (right - left || 1), (canvas.clientHeight - high) / (top - bottom || 1)) * 0.94;
    view.x = (left + right) / 2 - wide / 2 / view.scale;
    view.y = (bottom + top) / 2 - high / 2 / view.scale;
    draw();
  }

  function draw() {
    const ratio = window.devicePixelRatio || 1;
    canvas.width = canvas.clientWidth * ratio;
    canvas.height = canvas.clientHeight * ratio;
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.fillStyle = style("--paper");
    pen.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    if (picture.complete && picture.naturalWidth) {
      const [left, bottom, right, top] = data.picture_extent, [x, y] = toScreen(left, top);
      pen.imageSmoothingEnabled = view.scale < 80;
      pen.drawImage(picture, x, y, (right - left) * view.scale, (top - bottom) * view.scale);
    }
    trace(data.trajectory, style("--way"), 1.5, .55);
    trace(way, style("--way"), 5, .9);
    const taken = [];
    const ordered = [...data.signs].sort((a, b) => (b === chosen) - (a === chosen) || (b.is_landmark === true) - (a.is_landmark === true) || b.observations - a.observations);
    for (const sign of ordered) label(sign, taken);
    scaleBar();
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

  function label(sign, taken) {
    const [x, y] = toScreen(...sign.position), is = sign === chosen;
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
    (function step(now) {
      if (mine !== flight) return;
      const part = Math.min((now - began) / long, 1), eased = part * part * (3 - 2 * part);
      view.x = from.x + (x - wide - from.x) * eased;
      view.y = from.y + (y - high - from.y) * eased;
      view.scale = from.scale * Math.pow(scale / from.scale, eased);
      draw();
      if (part < 1) requestAnimationFrame(step);
    })(began);
  }

  function choose(sign, fly = true) {
    chosen = sign;
    for (const button of list.querySelectorAll("button")) button.setAttribute("aria-current", String(Number(button.dataset.id) === (sign && sign.id)));
    card.replaceChildren();
    if (!sign) return draw();
    const title = document.createElement("h2"), facts = document.createElement("dl");
    title.textContent = sign.name;
    const rows = [
      [words.lines, sign.lines.filter(line => line !== sign.name).join(" · ")],
      [words.place, sign.position.map(value => value.toFixed(2)).join(", ") + ` m (± ${sign.spread.toFixed(2)})`],
      [words.seen, `${sign.observations} ×`],
      [words.sure, `${Math.round(sign.confidence * 100)} %`],
      [words.read, Object.entries(sign.variants).map(([text, count]) => `${text} ×${count}`).join(", ")],
      [words.judged, sign.is_landmark === null ? "–" : sign.is_landmark ? words.yes : words.no],
    ];
    for (const [key, value] of rows) {
      if (!value) continue;
      facts.append(Object.assign(document.createElement("dt"), { textContent: key }), Object.assign(document.createElement("dd"), { textContent: value }));
    }
    card.append(title, facts);
    if (fly) flyTo(sign.position[0], sign.position[1], Math.max(view.scale, 90)); else draw();
  }

  function fill(shown) {
    list.replaceChildren(...shown.map(sign => {
      const row = document.createElement("li"), button = document.createElement("button"), dot = document.createElement("span"), name = document.createElement("span");
      dot.className = "dot" + (sign.is_landmark === true ? " shop" : sign.is_landmark === false ? " text" : "");
      name.textContent = sign.name;
      button.type = "button";
      button.dataset.id = sign.id;
      button.append(dot, name);
      button.addEventListener("click", () => { way = []; answer.textContent = ""; choose(sign); });
      row.append(button);
      return row;
    }));
  }

  /* Without a server a name is looked for in the signs' own words. */
  function byName(question) {
    const asked = fold(question).replace(/[?？!！.。]/g, " ").split(/\s+/).filter(Boolean);
    const scored = data.signs.map(sign => {
      const all = fold([sign.name, ...sign.lines, ...Object.keys(sign.variants)].join(" "));
      return [asked.filter(word => all.includes(word)).reduce((sum, word) => sum + word.length, 0) + (all.includes(fold(question.trim())) ? 100 : 0), sign];
    }).filter(([score]) => score > 0).sort((a, b) => b[0] - a[0]);
    return scored.map(([, sign]) => sign);
  }

  async function askServer(question) {
    const body = { question, map: data.name };
    if (before) body.before = before;
    const sent = url => fetch(url, { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(url === "/ask" ? body : { question, map: data.name }) });
    const response = await sent("/ask");
    const found = await response.json();
    if (!response.ok) throw new Error(found.detail || response.statusText);
    before = question;
    answer.textContent = found.text;
    const id = found.answer.landmark && found.answer.landmark.id;
    choose(data.signs.find(sign => sign.id === id) || null);
    const path = await sent("/path");
    if (path.ok) {
      const told = await path.json();
      way = told.points;
      answer.textContent = found.text + "\n\n" + told.steps.map((step, at) => `${at + 1}. ${step}`).join("\n");
      draw();
    }
  }

  ask.addEventListener("submit", async event => {
    event.preventDefault();
    const question = field.value.slice(0, 400);
    if (!question.trim()) return;
    way = [];
    if (!data.live) {
      const found = byName(question);
      answer.textContent = found.length ? "" : words.nothing;
      choose(found[0] || null);
      return;
    }
    answer.textContent = "…";
    try { await askServer(question); } catch (error) { answer.textContent = `${words.trouble} ${error.message}`; }
  });
  field.addEventListener("input", () => {
    const text = fold(field.value.trim());
    const found = data.signs.filter(sign => fold([sign.name, ...sign.lines].join(" ")).includes(text));
    fill(found.length ? found : data.signs);
  });

  let held = null;
  const pinch = new Map();
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    pinch.set(event.pointerId, [event.clientX, event.clientY]);
    held = { x: event.clientX, y: event.clientY, moved: 0 };
    flight++;
  });
  canvas.addEventListener("pointermove", event => {
    if (!pinch.has(event.pointerId)) return;
    const [x, y] = pinch.get(event.pointerId);
    if (pinch.size === 2) {
      const [other] = [...pinch].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      view.scale *= Math.hypot(event.clientX - other[0], event.clientY - other[1]) / Math.max(Math.hypot(x - other[0], y - other[1]), 1);
    } else {
      view.x -= (event.clientX - x) / view.scale;
      view.y += (event.clientY - y) / view.scale;
    }
    if (held) held.moved += Math.abs(event.clientX - x) + Math.abs(event.clientY - y);
    pinch.set(event.pointerId, [event.clientX, event.clientY]);
    draw();
  });
  const release = event => {
    pinch.delete(event.pointerId);
    if (!held || held.moved > 6 || event.type === "pointercancel") return void (held = null);
    held = null;
    const near = data.signs.map(sign => [Math.hypot(...toScreen(...sign.position).map((value, axis) => value - [event.clientX, event.clientY][axis])), sign]).sort((a, b) => a[0] - b[0])[0];
    if (near && near[0] < 24) { way = []; answer.textContent = ""; choose(near[1], false); }
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    const factor = Math.exp(-event.deltaY / 500), dx = event.clientX - canvas.clientWidth / 2, dy = canvas.clientHeight / 2 - event.clientY;
    view.x += dx / view.scale * (1 - 1 / factor);
    view.y += dy / view.scale * (1 - 1 / factor);
    view.scale = Math.min(Math.max(view.scale * factor, 2), 2000);
    draw();
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const step = 60 / view.scale, moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, step], ArrowDown: [0, -step] };
    if (moves[event.key]) { view.x += moves[event.key][0]; view.y += moves[event.key][1]; }
    else if (event.key === "+" || event.key === "=") view.scale *= 1.2;
    else if (event.key === "-") view.scale /= 1.2;
    else if (event.key === "0") return fit();
    else return;
    event.preventDefault();
    draw();
  });
  window.addEventListener("resize", draw);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

  document.documentElement.lang = words.language;
  document.title = data.title;
  document.getElementById("title").textContent = data.title;
  field.placeholder = data.live ? words.ask : words.search;
  field.setAttribute("aria-label", field.placeholder);
  document.getElementById("go").textContent = words.go;
  document.getElementById("count").textContent = words.count.replace("{count}", data.signs.length);
  canvas.setAttribute("aria-label", words.canvas);
  fill(data.signs);
  picture.addEventListener("load", draw);
  if (data.picture) picture.src = data.picture;
  fit();
  window.lpslamPage = { chosen: () => chosen && chosen.id, view: () => ({ ...view }), way: () => way.length };
})();
