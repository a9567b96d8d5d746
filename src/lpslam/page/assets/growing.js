/* A map that is being made: the server tells how far it is, and what was missed meanwhile is told at once. */
const status = part("status"), counts = part("counts"), happened = part("happened");
let source = null, isPictureOld = true;

/* A screen reader says what stands here: it is set when it changes, not with every frame. */
function show(text, kind) {
  if (status.textContent !== text) status.textContent = text;
  status.className = kind;
}

const tones = { initialised: "good", tracking: "good", relocalised: "good", loop: "good", merge: "good", weak: "weak", "new sub-map": "weak", lost: "bad" };

function eventRow(event) {
  const when = make("time", { textContent: `${event.seconds.toFixed(1)} s`, title: filled(words.frame, event) });
  const row = make("li", { className: tones[event.kind] || "" }, when, make("span", { textContent: words.events[event.kind] || event.kind }));
  // Reasons are the program's own words, with figures.
  if (event.reason) row.append(make("span", { className: "soft", lang: "en", textContent: event.reason }));
  return row;
}

const news = {
  state(told) {
    state.camera = told.at;
    if (told.at && (!data.trajectory.length || Math.hypot(...data.trajectory[data.trajectory.length - 1].slice(0, 3).map((value, axis) => value - told.at[axis])) > 0.02)) {
      data.trajectory.push(told.at);
    }
    const isElsewhere = !told.at && told.tracking !== "lost" && told.tracking !== "initialising";
    show(isElsewhere ? words.elsewhere : words.states[told.tracking] || told.tracking, told.tracking === "lost" ? "trouble" : told.tracking === "tracking" && told.at ? "growing" : "weak");
    status.title = told.reason;
    const more = [told.submaps > 1 && words.submaps, told.dropped && words.dropped].filter(Boolean);
    counts.textContent = [words.growing, ...more].map(each => filled(each, told)).join(" · ");
  },
  events(told) {
    happened.hidden = !told.count;
    happened.querySelector("summary").textContent = `${words.happened} (${told.count})`;
    happened.querySelector("ul").replaceChildren(...told.events.map(eventRow).reverse());
  },
  signs(told) {
    takeEdits(told.edits);
    takeSigns(told.signs);
  },
  way(told) {
    data.trajectory = told.way;
    data.lens = told.lens;
  },
  picture() { if (state.isSpatial) isPictureOld = true; else growPicture(); },
  points() { if (state.isSpatial) growPoints(); else cloud.isAskedFor = false; },
  end(told) {
    source.close();
    // The last of the room is asked for while somebody still answers.
    growPoints().then(() => growPicture("picture?last=true"));
    // Nobody answers any more: names are still found.
    data.live = data.grows = false;
    state.camera = null;
    if (state.isFirstPerson) lookThrough(false);
    showReplay();
    show(told.map ? filled(words.ended, told) : words.stopped, "ended");
    nameField();
    listEdits();
    showCard();
  },
};

/* The room from above and in space: asked for by who sees it, when the server has told that there is a newer one. */
async function growPicture(name = "picture") {
  isPictureOld = false;
  const told = await askedOf(name, "json");
  if (!told) return;
  data.picture_extent = told.extent;
  picture.src = told.picture;
}

async function growPoints() {
  cloud.isAskedFor = true;
  const bytes = await askedOf(`points?since=${cloud.version}`, "arrayBuffer");
  if (!bytes) return;
  takeParts(bytes);
  if (state.isSpatial) isWholeShown ? fit() : draw();
}

function nameField() {
  field.placeholder = data.live ? words.ask : words.search;
  field.setAttribute("aria-label", field.placeholder);
}

function watch() {
  if (!state.isSpatial) growPicture();
  source = new EventSource("/watch");
  for (const [name, take] of Object.entries(news)) {
    source.addEventListener(name, event => {
      take(JSON.parse(event.data));
      if (isWholeShown) fit(); else draw();
    });
  }
  source.addEventListener("error", () => {
    if (source.readyState === EventSource.CLOSED) setTimeout(watch, 2000);
    show(words.reconnecting, "trouble");
  });
}
