/* A map that is being made: the server tells how far it is, and what was missed meanwhile is told at once. */
const status = part("status");
let source = null;

function show(text, kind) {
  status.textContent = text;
  status.className = kind;
}

const news = {
  state(told) {
    state.camera = told.at;
    if (told.at && (!data.trajectory.length || Math.hypot(...data.trajectory[data.trajectory.length - 1].map((value, axis) => value - told.at[axis])) > 0.02)) {
      data.trajectory.push(told.at.slice(0, 2));
    }
    show(filled(words.growing, told) + (told.at ? "" : ` – ${words.lost}`), told.at ? "growing" : "trouble");
  },
  signs(told) {
    takeEdits(told.edits);
    takeSigns(told.signs);
  },
  way(told) { data.trajectory = told.way; },
  picture(told) {
    data.picture_extent = told.extent;
    picture.src = told.picture;
  },
  end(told) {
    source.close();
    // Nobody answers any more: names are still found.
    data.live = false;
    state.camera = null;
    show(told.map ? filled(words.ended, told) : words.stopped, "ended");
    nameField();
    listEdits();
    showCard();
  },
};

function nameField() {
  field.placeholder = data.live ? words.ask : words.search;
  field.setAttribute("aria-label", field.placeholder);
}

function watch() {
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
