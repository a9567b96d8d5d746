/* The list of signs, and the card of the one that is chosen. */
const list = part("signs"), card = part("card"), field = part("question");

/* Chosen by hand: what was answered before is no longer the matter. */
function pick(sign, fly = true) {
  dropWay();
  choose(sign, fly);
}

function choose(sign, fly = true) {
  state.chosen = sign;
  for (const button of list.querySelectorAll("button")) button.setAttribute("aria-current", String(Number(button.dataset.id) === (sign && sign.id)));
  showCard();
  if (sign && data.memory && data.memory.histories.some(history => history.id === classOf(sign))) showClass(classOf(sign));
  if (!sign) return draw();
  if (fly) flyToSign(sign); else draw();
}

function showCard() {
  card.replaceChildren();
  const sign = state.chosen;
  if (!sign) return;
  const facts = make("dl");
  const rows = [
    [words.lines, sign.lines.filter(line => line !== sign.name).join(" · ")],
    [words.place, sign.position.map(value => value.toFixed(2)).join(", ") + ` m (±\u202f${sign.spread < 0.01 ? "<\u202f1" : Math.round(100 * sign.spread)} cm)`],
    [words.seen, `${sign.observations} ×`],
    [words.sure, `${Math.round(sign.confidence * 100)} %`],
    [words.read, Object.entries(sign.variants).map(([text, count]) => `${text} ×${count}`).join(", ")],
    [words.judged, sign.is_landmark === null ? "–" : sign.is_landmark ? words.yes : words.no],
  ];
  for (const [key, value] of rows) if (value) facts.append(make("dt", { textContent: key }), make("dd", { textContent: value }));
  part("panel").scrollTop = 0;
  const shut = tool("✕", () => pick(null));
  shut.setAttribute("aria-label", words.close);
  card.append(make("div", { className: "head" }, make("h2", { textContent: sign.name }), shut), ...pictureOf(sign), facts, ...correctingTools(sign));
}

/* How a sign was seen best, and from where else. A server gives the pictures once one is wanted. */
function pictureOf(sign) {
  if (!data.pictures && data.live && !data.grows) havePictures();
  const sources = (data.pictures && data.pictures[sign.id]) || [];
  const shown = sources.map((src, at) => make("img", { src, alt: `${words.sighting}: ${sign.name} (${at + 1}/${sources.length})` }));
  return shown.length ? [make("div", { className: "sightings" }, ...shown)] : [];
}

async function havePictures() {
  data.pictures = {};
  data.pictures = await givenLater("pictures", "json") || {};
  if (!card.contains(document.activeElement)) showCard();
}

function row(sign) {
  const dot = make("span", { className: "dot" + (sign.is_landmark === true ? " shop" : sign.is_landmark === false ? " text" : "") });
  const button = make("button", { type: "button" }, dot, make("span", { textContent: sign.name }));
  button.dataset.id = sign.id;
  button.setAttribute("aria-current", String(sign === state.chosen));
  button.addEventListener("click", () => pick(sign));
  return make("li", {}, button);
}

const LISTED = 500;  // signs at most: more are found by typing

/* The signs whose words hold what is typed; all where none does. */
function listSigns() {
  const text = fold(field.value.trim());
  const found = data.signs.filter(sign => fold([sign.name, ...sign.lines].join(" ")).includes(text));
  const listed = found.length ? found : data.signs;
  list.replaceChildren(...listed.slice(0, LISTED).map(row));
  if (listed.length > LISTED) list.append(make("li", { className: "soft", textContent: `… +${listed.length - LISTED}` }));
  part("count").textContent = filled(words.count, { count: data.signs.length });
}

/* Other signs than before: what was chosen stays chosen, and the list keeps its place. */
function takeSigns(signs, isForced = false) {
  const chosen = state.chosen && state.chosen.id, place = part("list").scrollTop;
  data.signs = signs;
  state.chosen = signs.find(sign => sign.id === chosen) || null;
  listSigns();
  part("list").scrollTop = place;
  // What somebody is writing on the card of a sign that is still there is left alone.
  if (!state.chosen || (!card.querySelector("form") && (isForced || !card.contains(document.activeElement)))) showCard();
}

field.addEventListener("input", listSigns);
