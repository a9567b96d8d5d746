/* What was understood of a question, part by part: each can be taken out, and another place chosen. */
const wishText = stop => [stop.what, ...stop.kinds.filter(kind => !stop.what)].join(" ") || words.anyPlace;

/* The parts of a stop that can be taken out: how each is called, what it says, and the stop without it. `said` tells
   what kinds are called. */
function wishParts(stop, said) {
  const each = (name, tell) => stop[name].map((value, at) => ({ label: words.wish[name], text: tell(value), rest: { ...stop, [name]: stop[name].filter((_, other) => other !== at) } }));
  const one = (label, text, changed) => ({ label, text, rest: { ...stop, ...changed } });
  const parts = [...each("kinds", kind => said[kind] || kind), ...each("identity", known => [...known.of.slice(0, 1), known.value].join(" ")), ...each("refused", kind => said[kind] || kind), ...each("without", wishText)];
  if (stop.which !== "any" || stop.rank > 1) parts.push(one(words.wish.which, (words.wish.values[stop.which] || "") + (stop.rank > 1 ? ` ${stop.rank}.` : ""), { which: "any", rank: 1 }));
  if (stop.relation) parts.push(one(words.wish.values[stop.relation] || stop.relation, stop.anchor.map(wishText).join(" + "), { relation: null, anchor: [], same_side: false }));
  if (stop.start) parts.push(one(words.wish.start, wishText(stop.start), { start: null }));
  if (stop.floor) parts.push(one(words.wish.floor, `${stop.floor.number}`, { floor: null }));
  if (stop.at.length) parts.push(one(words.wish.at, stop.at.map(minutes => `${Math.floor(minutes / 60)}:${String(minutes % 60).padStart(2, "0")}`).join(", "), { at: [] }));
  return parts;
}

/* Opened below an answer: its parts, and the next best places. `askAgain` takes a changed wish, `takeInstead` a sign. */
function understoodOf(found, askAgain, takeInstead) {
  const { wish, alternative_ids: ids } = found.answer;
  const box = make("details", { className: "understood" }, make("summary", { textContent: words.understood }));
  wish.stops.forEach((stop, at) => {
    const parts = make("ul", {}, make("li", {}, make("q", { textContent: wishText(stop) })));
    for (const { label, text, rest } of wishParts(stop, found.kinds || {})) {
      const button = make("button", { type: "button", className: "small", textContent: "✕" });
      button.setAttribute("aria-label", filled(words.takeOut, { part: `${label} ${text}` }));
      button.addEventListener("click", () => askAgain({ ...wish, instead: null, stops: wish.stops.map((other, row) => row === at ? rest : other) }));
      parts.append(make("li", {}, make("span", { className: "soft", textContent: label }), make("span", { textContent: text }), button));
    }
    box.append(parts);
  });
  const others = ids.map(id => data.signs.find(sign => sign.id === id)).filter(Boolean);
  if (others.length) box.append(make("p", { className: "tools" }, make("span", { className: "soft", textContent: words.orElse }), ...others.map(sign => tool(sign.name, () => takeInstead(sign)))));
  box.addEventListener("toggle", () => { if (box.open) box.scrollIntoView({ block: "nearest" }); });
  // What is not sure is shown opened: it is for the visitor to say.
  box.open = found.answer.landmark === null && others.length > 0;
  return box;
}
