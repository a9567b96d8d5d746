/* The walk once more: a moment of it is chosen or played, from above, from outside, or through the camera's own lens. */
const replay = { at: null, isPlaying: false, last: 0 };

const seconds = () => data.trajectory.length ? data.trajectory[data.trajectory.length - 1][7] : 0;

/* The pose at the moment that is chosen. */
function replayPose() {
  const way = data.trajectory;
  if (!way.length) return null;
  const at = replay.at ?? 0;
  let low = 0, high = way.length - 1;
  while (low < high) { const middle = (low + high) >> 1; if (way[middle][7] < at) low = middle + 1; else high = middle; }
  const after = way[low], before = way[Math.max(low - 1, 0)], gap = after[7] - before[7];
  return gap > 0 ? between(before, after, clamped((at - before[7]) / gap, 0, 1)) : after.slice(0, 7);
}

/* Where the camera is, or was at that moment. */
const shownPose = () => state.camera || (replay.at === null ? null : replayPose());

function showMoment(at) {
  replay.at = clamped(at, 0, seconds());
  part("moment").max = String(seconds());
  part("moment").value = String(replay.at);
  part("moment").setAttribute("aria-valuetext", `${replay.at.toFixed(1)} s`);
  part("clock").textContent = `${replay.at.toFixed(1)} s`;
  draw();
}

function play(isPlaying) {
  replay.isPlaying = isPlaying;
  part("play").textContent = isPlaying ? "❚❚" : "▶";
  part("play").setAttribute("aria-label", isPlaying ? words.pause : words.play);
  if (!isPlaying) return;
  if (replay.at === null || replay.at >= seconds()) replay.at = 0;
  replay.last = performance.now();
  requestAnimationFrame(playOn);
}

function playOn(now) {
  if (!replay.isPlaying) return;
  const passed = Math.max(now - replay.last, 0) / 1000;
  replay.last = now;
  showMoment(replay.at + passed);
  if (replay.at >= seconds()) play(false); else requestAnimationFrame(playOn);
}

/* Through whose lens the map is seen: of a map that grows, where the camera is now. */
const lensPose = () => state.camera || replayPose();

function lookThrough(isFirstPerson) {
  state.isFirstPerson = isFirstPerson && state.isSpatial && Boolean(lensPose());
  part("lens").setAttribute("aria-pressed", String(state.isFirstPerson));
  if (!state.isFirstPerson) return draw();
  flight++;
  isWholeShown = false;
  return data.grows ? draw() : showMoment(replay.at ?? 0);
}

/* Whoever moves the view goes out of the camera, and stands where it was. */
function leaveLens() {
  if (!state.isFirstPerson) return;
  const pose = lensPose(), [, , ahead] = axesOf(pose);
  around.far = 2.5;
  around.at = plus(pose.slice(0, 3), ahead, 2);
  around.yaw = Math.atan2(-ahead[1], -ahead[0]);
  around.pitch = clamped(Math.asin(clamped(-ahead[2], -1, 1)), 0.1, 1.2);
  play(false);
  lookThrough(false);
}

/* Of a map that grows there is no moment to choose, only the camera to look through. */
function showReplay() {
  part("replay").hidden = data.grows ? !state.isSpatial : data.trajectory.length < 2;
  for (const name of ["play", "moment", "clock"]) part(name).hidden = data.grows;
  part("moment").max = String(seconds());
}

part("play").addEventListener("click", () => play(!replay.isPlaying));
part("moment").addEventListener("input", event => { play(false); showMoment(Number(event.target.value)); });
part("lens").addEventListener("click", () => lookThrough(!state.isFirstPerson));
