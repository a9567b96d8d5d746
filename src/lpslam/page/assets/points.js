/* The room's points: the first of them are a sample of all, so that as many are drawn as a frame has time for. */
const cloud = { count: 0, parts: new Map(), spacing: 0.02, ceiling: 1e6, version: 0, isAskedFor: false };
const BUDGET = { least: 15000, first: 200000, slow: 90, quick: 45 };  // points a frame, and milliseconds of one
const LEAST_SHARP = 0.5;
let budget = BUDGET.first, sharpness = 1;  // the second: of the canvas's pixels, the share to a side that are drawn in motion

/* One part, in its order: count, low, size and spacing in eight numbers of four bytes, then eight bytes a point. */
function takePoints(bytes) {
  if (!gl || bytes.byteLength < 32) return;
  const [count, x, y, z, wide, deep, high, spacing] = new Float32Array(bytes, 0, 8);
  const rows = new Uint16Array(bytes, 32, 4 * Math.floor(Math.min(count, (bytes.byteLength - 32) / 8)));
  cloud.parts.clear();
  cloud.parts.set(0, { rows, place: [wide, 0, 0, x, 0, deep, 0, y, 0, 0, high, z] });
  cloud.spacing = spacing;
  mergeParts();
}

/* What is new of a room that grows (`GrowingPoints.since`): parts that were seen, moved or are gone. */
function takeParts(bytes) {
  if (!gl || bytes.byteLength < 16) return;
  const [version, isWhole, records] = new Uint32Array(bytes, 0, 3), words = new Uint32Array(bytes, 16, records * 16), numbers = new Float32Array(bytes, 16, records * 16);
  // Two answers may come in the wrong order.
  if (!isWhole && version < cloud.version) return;
  let from = 16 + records * 64, isSeen = isWhole > 0;
  if (isWhole) cloud.parts.clear();
  cloud.version = version;
  cloud.spacing = new Float32Array(bytes, 12, 1)[0];
  for (let at = 0; at < words.length; at += 16) {
    const [id, kind, count] = words.subarray(at, at + 3), place = [...numbers.subarray(at + 4, at + 16)];
    if (kind === 0 && cloud.parts.has(id)) cloud.parts.get(id).place = place;
    if (kind === 1) cloud.parts.set(id, { rows: new Uint16Array(bytes, from, count * 4), place });
    if (kind === 2) cloud.parts.delete(id);
    from += count * 8;
    isSeen = isSeen || kind > 0;
  }
  if (isSeen) mergeParts(); else placeParts();
}

/* All parts in one order, of which every beginning has the same share of each. */
function mergeParts() {
  const parts = [...cloud.parts.values()];
  cloud.count = parts.reduce((sum, { rows }) => sum + rows.length / 4, 0);
  let merged = parts.length ? parts[0].rows : new Uint16Array(0), owners = null;
  if (parts.length > 1) {
    const LEVELS = 4096, firsts = new Uint32Array(LEVELS + 1);
    for (const { rows } of parts) for (let at = 0, count = rows.length / 4; at < count; at++) firsts[Math.floor(at * LEVELS / count) + 1]++;
    for (let level = 0; level < LEVELS; level++) firsts[level + 1] += firsts[level];
    merged = new Uint16Array(cloud.count * 4);
    owners = new Uint16Array(cloud.count);
    parts.forEach(({ rows }, owner) => {
      for (let at = 0, count = rows.length / 4; at < count; at++) {
        const to = firsts[Math.floor(at * LEVELS / count)]++;
        for (let each = 0; each < 4; each++) merged[to * 4 + each] = rows[at * 4 + each];
        owners[to] = owner;
      }
    });
  }
  cloud.rows = merged;
  cloud.owners = owners;
  bufferPoints(merged, owners);
  placeParts();
}

function bufferPoints(rows, owners) {
  const used = program("points");
  gl.bindVertexArray(used.array);
  for (const [name, content, wide] of [["row", rows, 4], ["owner", owners, 1]]) {
    const where = used.attribute(name);
    if (!content) {
      gl.disableVertexAttribArray(where);
      gl.vertexAttribI4ui(where, 0, 0, 0, 0);
      continue;
    }
    cloud[name] = cloud[name] || gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, cloud[name]);
    gl.bufferData(gl.ARRAY_BUFFER, content, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(where);
    gl.vertexAttribIPointer(where, wide, gl.UNSIGNED_SHORT, 2 * wide, 0);
  }
}

/* Where parts are, for the graphics side: three texels a part, 256 parts a line. */
function placeParts() {
  const places = [...cloud.parts.values()].map(({ place }) => place), high = Math.max(1, Math.ceil(places.length / 256));
  const texels = new Float32Array(high * 256 * 12);
  places.forEach((place, at) => texels.set(place, at * 12));
  cloud.places = cloud.places || gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, cloud.places);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, 768, high, 0, gl.RGBA, gl.FLOAT, texels);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  cloud.placed = places;
  findCeiling();
}

/* A point of the merged order in the map frame, metres. */
function pointAt(each) {
  const place = cloud.placed[cloud.owners ? cloud.owners[each] : 0], at = each * 4;
  return [0, 4, 8].map(row => (place[row] * cloud.rows[at] + place[row + 1] * cloud.rows[at + 1] + place[row + 2] * cloud.rows[at + 2]) / 65535 + place[row + 3]);
}

/* Asked for when they are first to be seen: from the file itself, or from the server. */
async function havePoints() {
  if (cloud.isAskedFor) return;
  cloud.isAskedFor = true;
  if (data.grows) return growPoints();
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
function findCeiling() {
  const heights = data.trajectory.map(pose => pose[2]).sort((a, b) => a - b), deep = 0.15;
  cloud.ceiling = 1e6;
  if (!heights.length) return;
  const base = heights[heights.length >> 1], sample = Math.min(cloud.count, 60000);
  const above = data.signs.reduce((most, sign) => Math.max(most, sign.position[2] + (sign.height || 0) / 2), base + 0.4);
  const layers = new Array(Math.ceil(FAR / deep)).fill(0);
  for (let each = 0; each < sample; each++) {
    const layer = Math.floor((pointAt(each)[2] - base) / deep);
    if (layer >= 0 && layer < layers.length) layers[layer]++;
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
  gl.bindTexture(gl.TEXTURE_2D, cloud.places);
  gl.uniform1i(used.uniforms.places, 0);
  gl.uniform1f(used.uniforms.spread, 1.4 * apart * lens.focal * paint.target.wide / lens.wide);
  gl.uniform1f(used.uniforms.most, 14 * paint.target.wide / lens.wide);
  gl.uniform1f(used.uniforms.highest, lens.isFirstPerson ? 1e6 : cloud.ceiling);
  gl.drawArrays(gl.POINTS, from, count);
}

/* After a frame of so many milliseconds: fewer pixels in the next while the view moves, then fewer points; or more. */
function adapt(milliseconds) {
  if (milliseconds > BUDGET.slow) {
    // What is far too slow is mended at once.
    if (sharpness === LEAST_SHARP || milliseconds > 2 * BUDGET.slow) budget = Math.max(BUDGET.least, Math.round(budget * Math.max(0.25, BUDGET.slow / milliseconds)));
    sharpness = Math.max(LEAST_SHARP, sharpness * 0.7);
  } else if (milliseconds < BUDGET.quick) {
    if (budget < Math.min(cloud.count, BUDGET.first)) budget = Math.round(budget * 1.25);
    else if (sharpness < 1) sharpness = Math.min(1, sharpness * 1.15);
    else budget = Math.min(Math.max(cloud.count, BUDGET.first), Math.round(budget * 1.25));
  }
}
