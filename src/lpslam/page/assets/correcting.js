/* What a person says of a sign: it wins over what was read. The server keeps it in the map, and says what there is now
   when somebody else was first. */
const byHand = part("by-hand");

const canCorrect = () => data.live && data.edits;

async function send(method, url, body) {
  const options = { method };
  if (body) Object.assign(options, { headers: { "content-type": "application/json" }, body: JSON.stringify(body) });
  try {
    const response = await fetch(url, options), told = await response.json();
    if (response.status === 409) takeEdits(told);
    if (!response.ok) return complain(response.status === 409 ? words.conflict : told.detail || response.statusText);
    takeEdits(told);
    complain("");
  } catch (error) {
    complain(`${words.trouble} ${error.message}`);
  }
  await refresh();
}

/* One after the other: who is quicker than the server is no second editor. */
let sent = Promise.resolve();
const inTurn = act => { sent = sent.then(act, act); };

const named = () => data.name ? { map: data.name } : {};
const correct = change => inTurn(() => send("POST", "/corrections", { ...named(), revision: data.edits.revision, ...change }));
const takeBack = number => inTurn(() => send("DELETE", `/corrections/${number}?` + new URLSearchParams({ ...named(), revision: data.edits.revision })));

function complain(text) {
  part("complaint").textContent = text;
  if (text) refresh();
}

/* The map as the server has it now; one that grows tells by itself. */
async function refresh() {
  if (data.grows || !data.live) return;
  const response = await fetch(`/page/${encodeURIComponent(data.name)}/signs`);
  if (!response.ok) return;
  const told = await response.json();
  data.trajectory = told.trajectory;
  data.question = told.question;
  takeEdits(told.edits);
  takeSigns(told.signs, true);
  if (isWholeShown) fit(); else draw();
}

function takeEdits(edits) {
  data.edits = { revision: edits.revision, corrections: edits.corrections };
  listEdits();
}

function saidOf(edit) {
  if (edit.kind === "rename") return `${edit.read} → ${edit.name}`;
  if (edit.kind === "merge") return `${edit.read} = ${edit.into_name}`;
  if (edit.kind === "judge") return `${edit.read}: ${edit.question} ${edit.answer ? words.yes : words.no}`;
  return `${edit.read}: ${words.hidden}`;
}

function undoRow(edit) {
  const button = make("button", { type: "button", textContent: words.undo, className: "small" });
  button.setAttribute("aria-label", `${words.undo}: ${saidOf(edit)}`);
  button.addEventListener("click", () => takeBack(edit.number));
  return make("li", { className: "edit" }, make("span", { textContent: saidOf(edit) }), button);
}

function listEdits() {
  const edits = canCorrect() ? data.edits.corrections : [];
  byHand.hidden = !edits.length;
  byHand.querySelector("summary").textContent = `${words.byHand} (${edits.length})`;
  byHand.querySelector("ul").replaceChildren(...edits.map(undoRow));
}

function tool(text, act) {
  const button = make("button", { type: "button", textContent: text, className: "small" });
  button.addEventListener("click", act);
  return button;
}

/* A field of the card, put in the place of its buttons. */
function askFor(tools, input, act) {
  const form = make("form", { className: "tools" }, input, make("button", { textContent: words.save, className: "small" }), tool(words.cancel, showCard));
  form.addEventListener("submit", event => {
    event.preventDefault();
    showCard();
    act(input.value);
  });
  tools.replaceWith(form);
  input.focus();
  if (input.select) input.select();
}

function correctingTools(sign) {
  if (!canCorrect()) return [];
  const tools = make("div", { className: "tools" });
  const others = data.signs.filter(other => other !== sign).sort((a, b) => Math.hypot(a.position[0] - sign.position[0], a.position[1] - sign.position[1]) - Math.hypot(b.position[0] - sign.position[0], b.position[1] - sign.position[1]));
  tools.append(tool(words.rename, () => {
    const input = make("input", { value: sign.name, maxLength: 120 });
    input.setAttribute("aria-label", words.rename);
    askFor(tools, input, name => correct({ kind: "rename", landmark: sign.id, name }));
  }));
  if (others.length) tools.append(tool(words.merge, () => {
    const select = make("select", {}, ...others.slice(0, 200).map(other => make("option", { value: other.id, textContent: other.name })));
    select.setAttribute("aria-label", words.merge);
    askFor(tools, select, into => {
      const other = data.signs.find(each => each.id === Number(into));
      choose(other || null, false);
      correct({ kind: "merge", landmark: sign.id, into: Number(into) });
    });
  }));
  tools.append(tool(words.hide, () => correct({ kind: "hide", landmark: sign.id })));
  const judged = make("span", { className: "tools" }, make("span", { className: "soft", textContent: data.question || words.isLandmark }));
  for (const [text, answer] of [[words.yes, true], [words.no, false]]) {
    const button = tool(text, () => correct({ kind: "judge", landmark: sign.id, answer }));
    button.setAttribute("aria-pressed", String(sign.is_landmark === answer));
    judged.append(button);
  }
  const edits = data.edits.corrections.filter(edit => sign.corrections.includes(edit.number)).map(undoRow);
  return [tools, judged, make("ul", {}, ...edits)];
}

/* Others may correct the same map, or put another one in its place. */
function hearOfChanges() {
  const events = new EventSource("/events");
  events.addEventListener("map", event => { if (JSON.parse(event.data).name === data.name) refresh(); });
}
