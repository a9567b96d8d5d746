/* The room's points: the first of them are a sample of all, so that as many are drawn as a frame has time for. */
const cloud = { count: 0, low: [0, 0, 0], size: [1, 1, 1], spacing: 0.02, ceiling: 1e6, buffer: null, isAskedFor: false };
const BUDGET = { least: 15000, first: 200000, slow: 90, quick: 45 };  // points a frame, and milliseconds of one
let budget = BUDGET.first, sharpness = 1;  // the second: of the canvas's pixels, the share to a side that are drawn in motion

/* Count, low, size and spacing in eight numbers of four bytes, then eight bytes a point. */
function takePoints(bytes) {
  if (!gl || bytes.byteLength < 32) return;
  const head = new Float32Array(bytes, 0, 8);
  Object.assign(cloud, { count: Math.min(head[0], (bytes.byteLength - 32) / 8), low: [...head.slice(1, 4)], size: [...head.slice(4, 7)], spacing: head[7] });
  findCeiling(bytes);
  const used = program("points");
  gl.bindVertexArray(used.array);
  cloud.buffer = cloud.buffer || gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, cloud.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Uint8Array(bytes, 32), gl.STATIC_DRAW);
  const where = used.attribute("row");
  gl.enableVertexAttribArray(where);
  gl.vertexAttribIPointer(where, 4, gl.UNSIGNED_SHORT, 8, 0);
}

/* Asked for when they are first to be seen: from the file itself, or from the server. */
async function havePoints(isNewer = false) {
  if (cloud.isAskedFor && !isNewer) return;
  cloud.isAskedFor = true;
  const text = part("map-points").textContent;
  if (text) takePoints(Uint8Array.from(atob(text), letter => letter.charCodeAt(0)).buffer);
  else if (data.live) {
    const bytes = await givenLater("points", "arrayBuffer");
    if (bytes) takePoints(bytes);
  }
  if (state.isSpatial) isWholeShown ? fit() : draw();
}

/* Seen from outside, a room is open above: its ceiling is a layer over the camera and all signs with far more points
   than the layers of walls below it. */
function findCeiling(bytes) {
  const rows = new Uint16Array(bytes, 32), heights = data.trajectory.map(pose => pose[2]).sort((a, b) => a - b), deep = 0.15;
  cloud.ceiling = 1e6;
  if (!heights.length) return;
  const base = heights[heights.length >> 1], sample = Math.min(cloud.count, 60000);
  const above = data.signs.reduce((most, sign) => Math.max(most, sign.position[2] + (sign.height || 0) / 2), base + 0.4);
  const layers = new Array(Math.max(1, Math.ceil((cloud.low[2] + cloud.size[2] - base) / deep) + 1)).fill(0);
  for (let each = 0; each < sample; each++) {
    const layer = Math.floor((cloud.low[2] + cloud.size[2] * rows[each * 4 + 2] / 65535 - base) / deep);
    if (layer >= 0) layers[layer]++;
  }
  const first = Math.ceil((above - base) / deep), most = Math.max(0, ...layers.slice(first));
  const lowest = layers.findIndex((count, layer) => layer >= first && count > 0.6 * most);
  const usual = layers.slice(0, lowest).sort((a, b) => a - b)[lowest >> 1];
  if (lowest > 0 && most > 3 * usual && most > 0.02 * sample) cloud.ceiling = base + (lowest - 0.5) * deep;
}

/* Draw some of the points, the first of them sparse and large. */
function drawPoints(from, count, drawn) {
  if (!cloud.count || !count) return;
  const used = use("points");
  // Each point is as wide as they lie apart, on surfaces: half as many lie 1.4 times as far.
  const apart = cloud.spacing * Math.sqrt(cloud.count / Math.max(drawn, 1));
  gl.uniform3fv(used.uniforms.low, cloud.low);
  gl.uniform3fv(used.uniforms.size, cloud.size);
  gl.uniform1f(used.uniforms.spread, 1.4 * apart * lens.focal * paint.target.wide / lens.wide);
  gl.uniform1f(used.uniforms.most, 14 * paint.target.wide / lens.wide);
  gl.uniform1f(used.uniforms.highest, lens.isFirstPerson ? 1e6 : cloud.ceiling);
  gl.drawArrays(gl.POINTS, from, count);
}

/* After a frame of so many milliseconds: fewer pixels in the next while the view moves, then fewer points; or more. */
function adapt(milliseconds) {
  if (milliseconds > BUDGET.slow) {
    // What is far too slow is mended at once.
    if (sharpness === 0.5 || milliseconds > 2 * BUDGET.slow) budget = Math.max(BUDGET.least, Math.round(budget * Math.max(0.25, BUDGET.slow / milliseconds)));
    sharpness = Math.max(0.5, sharpness * 0.7);
  } else if (milliseconds < BUDGET.quick) {
    if (budget < Math.min(cloud.count, BUDGET.first)) budget = Math.round(budget * 1.25);
    else if (sharpness < 1) sharpness = Math.min(1, sharpness * 1.15);
    else budget = Math.min(Math.max(cloud.count, BUDGET.first), Math.round(budget * 1.25));
  }
}
