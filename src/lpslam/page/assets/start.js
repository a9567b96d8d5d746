/* Everything put in its place. */
document.documentElement.lang = words.language;
document.title = data.title;
part("title").textContent = data.title;
part("go").textContent = words.go;
canvas.setAttribute("aria-label", words.canvas);
part("as-plan").textContent = words.plan;
part("in-space").textContent = words.space;
part("whole").textContent = words.whole;
part("modes").setAttribute("aria-label", words.view);
part("replay").setAttribute("aria-label", words.replay);
part("moment").setAttribute("aria-label", words.moment);
part("lens").textContent = words.lens;
play(false);
showReplay();
log.setAttribute("aria-label", words.dialogue);
happened.querySelector("ul").setAttribute("aria-label", words.happened);
part("memory-open").textContent = words.memory;
part("memory-open").hidden = !data.memory || !data.memory.histories.length;
part("memory-close").textContent = words.close;
memory.canvas.setAttribute("aria-label", words.memoryPlot);
nameField();
listSigns();
listEdits();
picture.addEventListener("load", draw);
if (data.picture) picture.src = data.picture;
fit();
if (data.grows) {
  show(words.waiting, "growing");
  watch();
} else if (data.live) {
  hearOfChanges();
  haveGround();
} else if (data.ground) groundPicture.src = data.ground.picture;
window.lpslamPage = {
  chosen: () => state.chosen && state.chosen.id,
  view: () => ({ ...view }),
  way: () => state.way.length,
  around: () => ({ ...around }),
  points: () => cloud.count,
  ceiling: () => cloud.ceiling,
  take(bytes) { takePoints(bytes); fit(); },
  takeSigns(signs) { takeSigns(signs); fit(); },
  hidden: () => drawing.signs.rest.filter(each => each.isHidden).map(each => each.sign.name),
  drawnPoints: () => drawing.drawn,
  pace: () => ({ milliseconds: drawing.pace, frames: drawing.frames, budget, isMoving: drawing.isMoving }),
  shownSigns: () => shownSigns.map(({ box, signs }) => ({ box, names: signs.map(sign => sign.name) })),
  moment: () => replay.at,
  goal: () => state.legs.length ? state.legs[state.legs.length - 1].position : null,
  stops: () => state.stops,
  travelled: () => data.trajectory.length,
  remembered: () => memory.shown,
  drawn: () => Boolean(data.picture_extent && picture.complete && picture.naturalWidth),
};
