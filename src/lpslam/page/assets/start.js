/* Everything put in its place. */
document.documentElement.lang = words.language;
document.title = data.title;
part("title").textContent = data.title;
part("go").textContent = words.go;
canvas.setAttribute("aria-label", words.canvas);
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
} else if (data.live) hearOfChanges();
window.lpslamPage = {
  chosen: () => state.chosen && state.chosen.id,
  view: () => ({ ...view }),
  way: () => state.way.length,
  travelled: () => data.trajectory.length,
  remembered: () => memory.shown,
  drawn: () => Boolean(data.picture_extent && picture.complete && picture.naturalWidth),
};
