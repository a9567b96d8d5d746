/* What hides signs: of the last frame, how far away what was drawn is, in a coarse grid. It is read once the frame is done,
   so nothing waits for it, and looked up by the lens of that frame. */
const HIDING = { wide: 128, high: 80, room: 0.35, slope: 0.03 };  // cells; metres, and share of the distance, that a sign may lie behind
const hiding = { frame: null, bytes: new Uint8Array(HIDING.wide * HIDING.high * 4), lens: null, asked: null };

/* Have the depths of what was drawn so far gathered. */
function askDepths() {
  if (!hiding.frame) {
    hiding.frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, hiding.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, textureOf(gl.RGBA8, HIDING.wide, HIDING.high), 0);
  }
  gl.bindFramebuffer(gl.FRAMEBUFFER, hiding.frame);
  gl.viewport(0, 0, HIDING.wide, HIDING.high);
  gl.disable(gl.DEPTH_TEST);
  const used = use("depths");
  gl.bindTexture(gl.TEXTURE_2D, paint.target.depth);
  gl.uniform1i(used.uniforms.depths, 0);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  hiding.asked = lens;
}

/* Take them, once the frame is done. */
function takeDepths() {
  if (!hiding.asked) return;
  gl.bindFramebuffer(gl.FRAMEBUFFER, hiding.frame);
  gl.readPixels(0, 0, HIDING.wide, HIDING.high, gl.RGBA, gl.UNSIGNED_BYTE, hiding.bytes);
  hiding.lens = hiding.asked;
  hiding.asked = null;
}

/* Whether most of what was drawn around a point lies before it. */
function isBehind(point) {
  if (!hiding.lens) return false;
  const [x, y, , w] = hiding.lens.rows.map(row => dot(row, point) + row[3]);
  if (w < NEAR) return false;
  const column = Math.floor((x / w + 1) / 2 * HIDING.wide), row = Math.floor((y / w + 1) / 2 * HIDING.high);
  if (column < 0 || row < 0 || column >= HIDING.wide || row >= HIDING.high) return false;
  const at = (row * HIDING.wide + column) * 4, share = (hiding.bytes[at] * 65536 + hiding.bytes[at + 1] * 256 + hiding.bytes[at + 2]) / 16777215;
  const away = 2 * FAR * NEAR / (FAR + NEAR - (2 * share - 1) * (FAR - NEAR));
  return away < w * (1 - HIDING.slope) - HIDING.room;
}
