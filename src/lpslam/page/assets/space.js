/* The map in space, and which of the two views is shown. Points come over several frames once nothing moves. */
const drawing = { movedAt: 0, isMoving: false, share: 1, isWanted: false, isFresh: false, drawn: 0, fence: null, began: 0, pace: 0, frames: 0 };
const groundPicture = new Image();

function draw() {
  if (!state.isSpatial) return drawPlan();
  drawing.isFresh = true;
  drawing.movedAt = performance.now();
  wantFrame();
}

function wantFrame() {
  if (drawing.isWanted) return;
  drawing.isWanted = true;
  requestAnimationFrame(frame);
}

/* One frame, once the one before is done: a slow machine is asked for less, never for more at once. */
function frame() {
  drawing.isWanted = false;
  if (!state.isSpatial) return;
  if (drawing.fence) {
    if (gl.getSyncParameter(drawing.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return wantFrame();
    gl.deleteSync(drawing.fence);
    drawing.fence = null;
    takeDepths();
    drawing.pace = performance.now() - drawing.began;
    drawing.frames++;
    // The first frame makes what the others use.
    if (cloud.count && drawing.frames > 1 && drawing.isMoving) adapt(drawing.pace);
  }
  // A view that waits to be drawn is in motion, however long the frame before it took.
  const isAtRest = !drawing.isFresh && performance.now() - drawing.movedAt > 200;
  // What was drawn with fewer pixels in motion is drawn with all of them at rest.
  if (isAtRest && drawing.share < 1) drawing.isFresh = true;
  if (drawing.isFresh || drawing.drawn < cloud.count) drawSpace(isAtRest);
  else if (drawing.share < 1) wantFrame();
  else if (drawing.seen !== hiding.lens) lookAgain();
}

/* All is drawn and nothing moves: signs are arranged once more by what is in sight. */
function lookAgain() {
  drawing.seen = hiding.lens;
  drawing.signs = arrangeSigns(Infinity);
  begin(scene.width, scene.height, false);
  drawPlates(drawing.signs.plates);
  finish(scene.width, scene.height);
  drawOverlay();
}

function drawSpace(isAtRest) {
  const isFresh = drawing.isFresh, wide = canvas.clientWidth, high = canvas.clientHeight;
  drawing.began = performance.now();
  if (isFresh) {
    drawing.isMoving = !isAtRest;
    drawing.share = isAtRest ? 1 : sharpness;
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * drawing.share;
    lens = lensFor(wide, high, state.isFirstPerson ? lensPose() : null);
    if (scene.width !== Math.round(wide * ratio) || scene.height !== Math.round(high * ratio)) [scene.width, scene.height] = [Math.round(wide * ratio), Math.round(high * ratio)];
    drawing.drawn = 0;
    drawing.signs = arrangeSigns(isAtRest ? Infinity : IN_MOTION);
  }
  drawing.isFresh = false;
  begin(scene.width, scene.height, isFresh);
  if (isFresh) drawGround();
  const count = Math.min(budget, cloud.count - drawing.drawn);
  drawPoints(drawing.drawn, count, drawing.drawn + count);
  drawing.drawn += count;
  if (isFresh || drawing.drawn === cloud.count) {
    askDepths();
    begin(scene.width, scene.height, false);
  }
  drawWays();
  drawPlates(drawing.signs.plates);
  // Half of a slow machine's frame is shading.
  if (drawing.share === LEAST_SHARP) showPlain(scene.width, scene.height); else finish(scene.width, scene.height);
  if (isFresh) drawOverlay();
  drawing.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  gl.flush();
  wantFrame();
}

function drawGround() {
  if (!data.ground || !groundPicture.complete || !groundPicture.naturalWidth) return;
  const [left, bottom, right, top] = data.ground.extent;
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.depthMask(false);
  const middle = [(left + right) / 2, (bottom + top) / 2, data.ground.height - 0.02];
  surface(pictureTexture(`ground ${data.ground.extent}`, () => groundPicture), middle, [(right - left) / 2, 0, 0], [0, (top - bottom) / 2, 0], 0);
  gl.depthMask(true);
  gl.disable(gl.BLEND);
}

/* The camera's way and where it is on it; the way to a place, and how to stand before it. */
function drawWays() {
  const green = rgb("--way"), floor = groundHeight() + 0.06, pose = shownPose();
  if (!state.isFirstPerson) ribbon(data.trajectory, green, 2);
  if (pose && !state.isFirstPerson) for (const line of frustumOf(pose)) ribbon(line, green, 2);
  ribbon(state.way.map(([x, y]) => [x, y, floor]), rgb("--route"), 7);
  for (const leg of state.legs) for (const line of goalLines(leg, floor)) ribbon(line, rgb("--route"), 4);
}

/* The four sides of what a camera sees, and which side is up. */
function frustumOf(pose) {
  const [wide, high, fx, fy, cx, cy] = data.lens || [640, 480, 525, 525, 320, 240], deep = 0.45, [right, down, ahead] = axesOf(pose), eye = pose.slice(0, 3);
  const at = (u, v) => plus(plus(plus(eye, ahead, deep), right, (u - cx) / fx * deep), down, (v - cy) / fy * deep);
  const corners = [at(0, 0), at(wide, 0), at(wide, high), at(0, high)];
  return [[...corners, corners[0]], ...corners.map(corner => [eye, corner]), [at(wide * 0.35, 0), at(wide / 2, -high * 0.2), at(wide * 0.65, 0)]];
}

function goalLines({ position: [x, y], heading }, floor) {
  const turn = heading * Math.PI / 180, at = (far, angle) => [x + far * Math.cos(turn + angle), y + far * Math.sin(turn + angle), floor];
  return [Array.from({ length: 25 }, (_, each) => at(0.28, each * Math.PI / 12)), [at(0.18, 2.5), at(0.5, 0), at(0.18, -2.5)]];
}

/* Text over the scene: the canvas of the plan, through which the scene is seen. */
function drawOverlay() {
  clearCanvas();
  const { plates, rest } = drawing.signs, { taken, labels } = arrangeLabels(plates, rest);
  drawLabels(labels);
  drawCounts(taken);
  drawBadges(stopBadges(([x, y]) => projected([x, y, groundHeight()])));
  shownSigns = taken;
}

function fit() {
  if (!state.isSpatial) return fitPlan();
  const [left, bottom, right, top] = extent(), floor = groundHeight();
  aim([left + 0.8, bottom + 0.8, floor], [right - 0.8, top - 0.8, floor + 2]);
  isWholeShown = true;
  draw();
}

/* Fly to a sign: to see it from where it is read. */
function flyToSign(sign) {
  if (!state.isSpatial) return flyTo(sign.position[0], sign.position[1], Math.max(view.scale, 90));
  leaveLens();
  const level = Math.hypot(sign.normal[0], sign.normal[1]) > 0.3;
  const yaw = level ? Math.atan2(sign.normal[1], sign.normal[0]) : around.yaw;
  return flyAround({ at: sign.position, yaw, pitch: 0.32, far: clamped(3 * Math.max(sign.width || 0, sign.height || 0), 2.6, 7) });
}

function flyAround(to) {
  const from = { ...around, at: [...around.at] }, began = performance.now(), mine = ++flight;
  const long = matchMedia("(prefers-reduced-motion: reduce)").matches ? 1 : 900;
  const turn = Math.atan2(Math.sin(to.yaw - from.yaw), Math.cos(to.yaw - from.yaw));
  isWholeShown = false;
  (function step(now) {
    if (mine !== flight) return;
    const share = clamped((now - began) / long, 0, 1), eased = share * share * (3 - 2 * share);
    around.at = from.at.map((value, axis) => value + (to.at[axis] - value) * eased);
    around.yaw = from.yaw + turn * eased;
    around.pitch = from.pitch + (to.pitch - from.pitch) * eased;
    around.far = from.far * Math.pow(to.far / from.far, eased);
    draw();
    if (share < 1) requestAnimationFrame(step);
  })(began);
}

/* Signs that one label stands for, seen apart. */
function flyToAll(signs) {
  const ends = [Math.min, Math.max].map(end => [0, 1, 2].map(axis => end(...signs.map(sign => sign.position[axis]))));
  flyToBox(plus(ends[0], [0.5, 0.5, 0.5], -1), plus(ends[1], [0.5, 0.5, 0.5]), around.far * 0.6);
}

/* A box of space, seen whole from no farther than so many metres. */
function flyToBox(low, high, farthest = FARTHEST) {
  const old = { ...around };
  aim(low, high);
  const to = { ...around };
  Object.assign(around, old);
  flyAround({ ...to, far: Math.min(to.far, farthest) });
}

function showSpace(isSpatial) {
  state.isSpatial = isSpatial && Boolean(gl);
  part("as-plan").setAttribute("aria-pressed", String(!state.isSpatial));
  part("in-space").setAttribute("aria-pressed", String(state.isSpatial));
  scene.hidden = part("lens").hidden = !state.isSpatial;
  canvas.setAttribute("aria-label", state.isSpatial ? words.canvasInSpace : words.canvas);
  leaveLens();
  flight++;
  showReplay();
  if (state.isSpatial) havePoints(); else if (data.grows && isPictureOld) growPicture();
  fit();
  if (state.chosen) flyToSign(state.chosen);
}

if (gl) {
  scene.addEventListener("webglcontextlost", () => {
    showSpace(false);
    part("as-plan").hidden = part("in-space").hidden = true;
  });
  part("as-plan").addEventListener("click", () => showSpace(false));
  part("in-space").addEventListener("click", () => showSpace(true));
} else part("as-plan").hidden = part("in-space").hidden = true;
groundPicture.addEventListener("load", draw);

/* The ground comes after the page: it takes longer than the rest. */
async function haveGround() {
  data.ground = await givenLater("ground", "json");
  if (data.ground) groundPicture.src = data.ground.picture; else state.isGroundless = true;
}
