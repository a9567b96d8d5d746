/* How the memory scores of classes rose and faded: one class at a time is told from the others. */
const memory = { panel: part("memory"), canvas: part("memory-plot"), shown: null };
memory.pen = memory.canvas.getContext("2d");

const classOf = sign => Math.floor(sign.id / 1000);
const nameOf = history => { const sign = data.signs.find(each => classOf(each) === history.id); return sign ? sign.name : history.name; };

function memoryScale() {
  const wide = memory.canvas.clientWidth, high = memory.canvas.clientHeight, left = 40, bottom = 26, top = 10, right = 12;
  const all = data.memory.histories.flatMap(history => history.samples);
  const first = Math.min(...all.map(([at]) => at)), last = Math.max(...all.map(([at]) => at), first + 1);
  const most = Math.max(data.memory.promotion, ...all.map(([, score]) => score)) * 1.12;
  return {
    first, last, most, left, top, wide, high, right, bottom,
    x: at => left + (at - first) / (last - first) * (wide - left - right),
    y: score => high - bottom - score / most * (high - top - bottom),
  };
}

function drawMemory() {
  if (memory.panel.hidden) return;
  const ratio = window.devicePixelRatio || 1, pen = memory.pen;
  memory.canvas.width = memory.canvas.clientWidth * ratio;
  memory.canvas.height = memory.canvas.clientHeight * ratio;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  const scale = memoryScale();
  memoryAxes(pen, scale);
  pen.globalAlpha = 0.6;
  for (const history of data.memory.histories) if (history.id !== memory.shown) memoryLine(pen, scale, history, history.kept ? style("--soft") : style("--line"), 1);
  pen.globalAlpha = 1;
  memoryThreshold(pen, scale);
  const chosen = data.memory.histories.find(history => history.id === memory.shown);
  part("memory-name").textContent = chosen ? nameOf(chosen) : "";
  if (!chosen) return;
  memoryLine(pen, scale, chosen, style("--shop"), 2.5);
  const peak = chosen.samples.reduce((best, each) => each[1] > best[1] ? each : best);
  pen.fillStyle = style("--shop");
  pen.beginPath();
  pen.arc(scale.x(peak[0]), scale.y(peak[1]), 4, 0, 7);
  pen.fill();
  part("memory-name").textContent += ` – ${filled(words.peak, { score: peak[1].toFixed(1), seconds: peak[0].toFixed(1) })}, ${chosen.kept ? words.kept : words.forgotten}`;
}

function memoryAxes(pen, scale) {
  pen.clearRect(0, 0, scale.wide, scale.high);
  pen.font = "12px system-ui, sans-serif";
  pen.fillStyle = style("--soft");
  pen.strokeStyle = style("--line");
  pen.lineWidth = 1;
  const step = span => { const raw = span / 5, power = 10 ** Math.floor(Math.log10(raw)); return power * [1, 2, 5, 10].find(each => each * power >= raw); };
  pen.textAlign = "right";
  pen.textBaseline = "middle";
  for (let score = 0; score <= scale.most; score += step(scale.most)) {
    pen.beginPath();
    pen.moveTo(scale.left, scale.y(score));
    pen.lineTo(scale.wide - scale.right, scale.y(score));
    pen.stroke();
    pen.fillText(String(+score.toFixed(2)), scale.left - 6, scale.y(score));
  }
  pen.textAlign = "center";
  pen.textBaseline = "top";
  const each = step(scale.last - scale.first);
  for (let at = Math.ceil(scale.first / each) * each; at <= scale.last; at += each) pen.fillText(`${+at.toFixed(2)} s`, Math.min(scale.x(at), scale.wide - 24), scale.high - scale.bottom + 6);
  pen.strokeStyle = style("--text");
  pen.setLineDash([5, 4]);
  pen.beginPath();
  pen.moveTo(scale.left, scale.y(data.memory.promotion));
  pen.lineTo(scale.wide - scale.right, scale.y(data.memory.promotion));
  pen.stroke();
  pen.setLineDash([]);
}

/* Over the lines, so that it can be read. */
function memoryThreshold(pen, scale) {
  pen.textAlign = "left";
  pen.textBaseline = "bottom";
  const y = scale.y(data.memory.promotion), wide = pen.measureText(words.longTerm).width;
  pen.fillStyle = style("--glass");
  pen.fillRect(scale.left + 2, y - 18, wide + 6, 16);
  pen.fillStyle = style("--text");
  pen.fillText(words.longTerm, scale.left + 5, y - 3);
}

function memoryLine(pen, scale, history, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineJoin = "round";
  pen.beginPath();
  history.samples.forEach(([at, score], number) => pen[number ? "lineTo" : "moveTo"](scale.x(at), scale.y(score)));
  pen.stroke();
}

/* The class whose line passes nearest to a point of the plot. */
function nearestClass(u, v) {
  const scale = memoryScale();
  let best = null, least = Infinity;
  for (const history of data.memory.histories) {
    history.samples.forEach(([at, score], number) => {
      const [before, height] = history.samples[Math.max(number - 1, 0)];
      const x0 = scale.x(before), y0 = scale.y(height), dx = scale.x(at) - x0, dy = scale.y(score) - y0;
      const share = Math.min(Math.max(((u - x0) * dx + (v - y0) * dy) / (dx * dx + dy * dy || 1), 0), 1);
      const apart = Math.hypot(u - x0 - share * dx, v - y0 - share * dy);
      if (apart < least) [best, least] = [history.id, apart];
    });
  }
  return best;
}

function showClass(id) {
  memory.shown = id;
  drawMemory();
}

function chooseClass(id) {
  const sign = data.signs.find(each => classOf(each) === id);
  if (sign) pick(sign);
}

function toggleMemory(isShown) {
  memory.panel.hidden = !isShown;
  part("memory-open").setAttribute("aria-expanded", String(isShown));
  document.body.classList.toggle("with-memory", isShown);
  if (isShown && memory.shown === null && data.memory.histories.length) memory.shown = data.memory.histories[0].id;
  drawMemory();
  if (isWholeShown) fit(); else draw();
}

memory.canvas.addEventListener("pointermove", event => showClass(nearestClass(event.offsetX, event.offsetY)));
memory.canvas.addEventListener("click", event => {
  showClass(nearestClass(event.offsetX, event.offsetY));
  chooseClass(memory.shown);
});
memory.canvas.addEventListener("keydown", event => {
  const turn = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  const ids = data.memory.histories.map(history => history.id);
  if (turn) showClass(ids[(ids.indexOf(memory.shown) + turn + ids.length) % ids.length]);
  else if (event.key === "Enter") chooseClass(memory.shown);
  else if (event.key === "Escape") toggleMemory(false);
  else return;
  event.preventDefault();
});
part("memory-open").addEventListener("click", () => toggleMemory(memory.panel.hidden));
part("memory-close").addEventListener("click", () => toggleMemory(false));
window.addEventListener("resize", drawMemory);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawMemory);
