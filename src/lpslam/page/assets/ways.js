/* The way to a place, or through the stops of a plan: asked for, shown whole, and told. */
const BADGE = 11;  // pixels from the middle of a stop's number to its rim

function dropWay() {
  state.way = [];
  state.legs = [];
  state.stops = [];
}

/* Draw the way through places, or the places alone where the map knows none; its steps as text, in a language. */
async function leadTo(ids, language) {
  const last = ids[ids.length - 1], mine = flight, way = await wayThrough(ids, language);
  if (!state.chosen || state.chosen.id !== last) return "";
  state.way = way ? way.points : [];
  state.legs = way ? way.legs : [];
  state.stops = way ? way.legs.map(leg => leg.position) : ids.map(id => data.signs.find(sign => sign.id === id)).filter(Boolean).map(sign => sign.position);
  // Whoever has moved the view meanwhile looks at something else.
  if (mine === flight && (ids.length > 1 || (way && !state.isSpatial))) flyToWay(ids); else draw();
  return way ? toldWay(way) : "";
}

async function wayThrough(ids, language) {
  if (data.grows || state.isGroundless) return null;
  const [reached, way] = await post("/path", { landmark: ids[ids.length - 1], via: ids.slice(0, -1), ...(language ? { language } : {}), ...named() });
  return reached.ok ? way : null;
}

const toldWay = ({ steps, legs }) => legs.length === 1 ? steps.map((step, at) => `${at + 1}. ${step}`).join("\n") : legs.map((leg, at) => `${at + 1}. ${leg.name}: ${leg.steps.join(" · ")}`).join("\n");

/* All of the way, and the signs to which it leads. */
function flyToWay(ids) {
  const signs = data.signs.filter(sign => ids.includes(sign.id));
  const places = [...state.way, ...signs.map(sign => sign.position)];
  const [left, bottom] = [0, 1].map(axis => places.reduce((least, place) => Math.min(least, place[axis]), Infinity) - 0.7);
  const [right, top] = [0, 1].map(axis => places.reduce((most, place) => Math.max(most, place[axis]), -Infinity) + 0.7);
  const floor = groundHeight();
  if (state.isSpatial) return flyToBox([left, bottom, floor], [right, top, floor + 2]);
  const [wide, high] = covered(), scale = Math.min((canvas.clientWidth - wide) / (right - left), (canvas.clientHeight - high) / (top - bottom)) * 0.8;
  return flyTo((left + right) / 2, (bottom + top) / 2, Math.min(scale, Math.max(view.scale, 90)));
}

/* The numbers of a plan's stops and where they are on the canvas; `place` says where a point of the ground is. */
function stopBadges(place) {
  const found = [];
  if (state.stops.length < 2) return found;
  state.stops.forEach((stop, at) => {
    const here = place(stop);
    if (!here) return;
    // Two stops at one place are told apart.
    const beside = found.filter(({ from }) => Math.hypot(from[0] - here[0], from[1] - here[1]) < 2 * BADGE).length;
    const x = here[0] - 16 + 2.2 * BADGE * beside, y = here[1] - 16;
    found.push({ number: at + 1, from: here, x, y, box: [x - BADGE, y - BADGE, x + BADGE, y + BADGE] });
  });
  return found;
}

function drawBadges(badges) {
  for (const { number, x, y } of badges) {
    pen.fillStyle = style("--route");
    pen.strokeStyle = style("--ground");
    pen.lineWidth = 2;
    pen.beginPath();
    pen.arc(x, y, BADGE, 0, 7);
    pen.fill();
    pen.stroke();
    pen.fillStyle = style("--ground");
    pen.font = `700 13px ${FONT}`;
    pen.textBaseline = "middle";
    pen.fillText(`${number}`, x - pen.measureText(`${number}`).width / 2, y + 0.5);
  }
}
