/* WebGL2: points, ribbons and pictures on surfaces are drawn into one image, whose edges in depth are then shaded. */
const scene = part("scene");
const gl = scene.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" });
const paint = { programs: {}, target: null, textures: new Map() };

const HEAD = "#version 300 es\nprecision highp float;\nprecision highp int;\n";
const SHADERS = {
  points: [`uniform mat4 view; uniform sampler2D places; uniform float spread, most, highest; in uvec4 row; in uint owner; out vec3 shade;
    void main() {
      ivec2 part = ivec2(int(owner & 255u) * 3, int(owner >> 8));
      vec4 share = vec4(vec3(row.xyz) / 65535.0, 1.0);
      vec3 at = vec3(dot(texelFetch(places, part, 0), share), dot(texelFetch(places, part + ivec2(1, 0), 0), share), dot(texelFetch(places, part + ivec2(2, 0), 0), share));
      gl_Position = at.z > highest ? vec4(2.0, 2.0, 2.0, 1.0) : view * vec4(at, 1.0);
      gl_PointSize = clamp(spread / gl_Position.w, 1.0, most);
      shade = vec3(float(row.w >> 11) / 31.0, float((row.w >> 5) & 63u) / 63.0, float(row.w & 31u) / 31.0);
    }`, `in vec3 shade; out vec4 colour;
    void main() { colour = vec4(shade, 1.0); }`],
  ribbons: [`uniform mat4 view; uniform vec2 pixels; uniform float width; in vec3 from, to;
    void main() {
      vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
      if (a.w < ${NEAR} && b.w < ${NEAR}) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
      if (a.w < ${NEAR}) a = mix(a, b, (${NEAR} - a.w) / (b.w - a.w));
      if (b.w < ${NEAR}) b = mix(b, a, (${NEAR} - b.w) / (a.w - b.w));
      vec2 along = (b.xy / b.w - a.xy / a.w) * pixels;
      along = length(along) > 1e-5 ? normalize(along) : vec2(1.0, 0.0);
      bool isEnd = gl_VertexID > 1;
      vec4 at = isEnd ? b : a;
      float side = float(gl_VertexID & 1) * 2.0 - 1.0;
      vec2 shift = (vec2(-along.y, along.x) * side + along * (isEnd ? 0.5 : -0.5)) * width / pixels;
      gl_Position = vec4(at.xy + shift * at.w, at.zw);
    }`, `uniform vec4 tint; out vec4 colour;
    void main() { colour = tint; }`],
  surfaces: [`uniform mat4 view; uniform vec3 middle, right, up, eye; uniform float lift; out vec2 at;
    void main() {
      vec2 corner = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
      at = vec2(corner.x, -corner.y) * 0.5 + 0.5;
      vec3 place = middle + right * corner.x + up * corner.y, towards = eye - place;
      gl_Position = view * vec4(place, 1.0);
      // Points are drawn as wide as they lie apart: some of those around stand out of their surface.
      vec4 nearer = view * vec4(place + towards * min(0.4, lift / length(towards)), 1.0);
      gl_Position.z = nearer.z / nearer.w * gl_Position.w;
    }`, `uniform sampler2D picture; uniform float least; in vec2 at; out vec4 colour;
    void main() { colour = texture(picture, at); if (colour.a <= least) discard; }`],
  // Depth edges darkened as by Boucheny's eye-dome lighting: what lies behind its neighbours is in their shade.
  shading: [`void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`,
    `uniform sampler2D picture, depths; uniform float near, far; out vec4 colour;
    float depthAt(int x, int y) { return texelFetch(depths, ivec2(x, y), 0).r; }
    void main() {
      ivec2 at = ivec2(gl_FragCoord.xy), low = max(at - 2, 0), high = min(at + 2, textureSize(depths, 0) - 1);
      float z = texelFetch(depths, at, 0).r;
      // By how much of its distance it lies behind its neighbours, in powers of two: with z, distances are near / (1 - z) or so.
      vec4 behind = (z - vec4(depthAt(high.x, at.y), depthAt(low.x, at.y), depthAt(at.x, high.y), depthAt(at.x, low.y))) * 1.4427 / (far / (far - near) - z);
      float shade = z < 1.0 ? dot(clamp(behind - 0.012, 0.0, 0.06), vec4(1.0)) : 0.0;
      colour = vec4(texelFetch(picture, at, 0).rgb * exp(-shade * 6.0), 1.0);
    }`],
  // Of each cell the depth in the middle of nine, in three bytes: single points before it, or gaps, tell nothing.
  depths: [`void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`,
    `uniform sampler2D depths; out vec4 colour;
    void main() {
      ivec2 size = textureSize(depths, 0);
      vec2 cell = vec2(size) / vec2(${HIDING.wide}, ${HIDING.high}), corner = floor(gl_FragCoord.xy) * cell;
      float found[9];
      for (int each = 0; each < 9; each++) {
        float depth = texelFetch(depths, min(ivec2(corner + cell * (vec2(each % 3, each / 3) + 0.5) / 3.0), size - 1), 0).r;
        int at = each;
        for (; at > 0 && found[at - 1] > depth; at--) found[at] = found[at - 1];
        found[at] = depth;
      }
      uint middle = uint(found[4] * 16777215.0);
      colour = vec4(float(middle >> 16), float((middle >> 8) & 255u), float(middle & 255u), 255.0) / 255.0;
    }`],
};

function program(name) {
  if (paint.programs[name]) return paint.programs[name];
  const made = gl.createProgram();
  for (const [at, kind] of [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].entries()) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, HEAD + SHADERS[name][at]);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(`${name}: ${gl.getShaderInfoLog(shader)}`);
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(`${name}: ${gl.getProgramInfoLog(made)}`);
  const uniforms = {};
  for (let each = 0; each < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); each++) {
    const { name: known } = gl.getActiveUniform(made, each);
    uniforms[known] = gl.getUniformLocation(made, known);
  }
  const attribute = known => gl.getAttribLocation(made, known);
  paint.programs[name] = { made, uniforms, array: gl.createVertexArray(), buffer: gl.createBuffer(), attribute };
  return paint.programs[name];
}

function use(name) {
  const used = program(name);
  gl.useProgram(used.made);
  gl.bindVertexArray(used.array);
  if (used.uniforms.view) gl.uniformMatrix4fv(used.uniforms.view, false, lens.matrix);
  return used;
}

function textureOf(kind, wide, high) {
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texStorage2D(gl.TEXTURE_2D, 1, kind, wide, high);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  return texture;
}

/* The image that is drawn into, as large as the canvas. */
function prepareTarget(wide, high) {
  const old = paint.target;
  if (old && old.wide === wide && old.high === high) return gl.bindFramebuffer(gl.FRAMEBUFFER, old.frame);
  if (old) {
    gl.deleteTexture(old.colour);
    gl.deleteTexture(old.depth);
    gl.deleteFramebuffer(old.frame);
  }
  const target = { wide, high, frame: gl.createFramebuffer(), colour: textureOf(gl.RGBA8, wide, high), depth: textureOf(gl.DEPTH_COMPONENT24, wide, high) };
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.frame);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.colour, 0);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, target.depth, 0);
  paint.target = target;
}

/* Colours as the style has them, "#rrggbb". */
const rgb = name => [1, 3, 5].map(at => parseInt(style(name).slice(at, at + 2), 16) / 255);

function begin(wide, high, isFresh) {
  prepareTarget(wide, high);
  gl.viewport(0, 0, wide, high);
  gl.enable(gl.DEPTH_TEST);
  gl.depthFunc(gl.LEQUAL);
  gl.disable(gl.BLEND);
  if (!isFresh) return;
  gl.clearColor(...rgb("--paper"), 1);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
}

function finish(wide, high) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.DEPTH_TEST);
  const used = use("shading");
  for (const [at, texture] of [paint.target.colour, paint.target.depth].entries()) {
    gl.activeTexture(gl.TEXTURE0 + at);
    gl.bindTexture(gl.TEXTURE_2D, texture);
  }
  gl.activeTexture(gl.TEXTURE0);
  gl.uniform1i(used.uniforms.picture, 0);
  gl.uniform1i(used.uniforms.depths, 1);
  gl.uniform1f(used.uniforms.near, NEAR);
  gl.uniform1f(used.uniforms.far, FAR);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

/* The image as it is, without shades. */
function showPlain(wide, high) {
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, paint.target.frame);
  gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
  gl.blitFramebuffer(0, 0, wide, high, 0, 0, wide, high, gl.COLOR_BUFFER_BIT, gl.NEAREST);
}

/* A line through points, so many pixels wide. */
function ribbon(points, tint, width) {
  if (points.length < 2) return;
  const used = use("ribbons"), flat = new Float32Array(points.flatMap(([x, y, z]) => [x, y, z]));
  gl.bindBuffer(gl.ARRAY_BUFFER, used.buffer);
  gl.bufferData(gl.ARRAY_BUFFER, flat, gl.STREAM_DRAW);
  for (const [at, name] of ["from", "to"].entries()) {
    const where = used.attribute(name);
    gl.enableVertexAttribArray(where);
    gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 12, at * 12);
    gl.vertexAttribDivisor(where, 1);
  }
  gl.uniform2f(used.uniforms.pixels, paint.target.wide, paint.target.high);
  gl.uniform1f(used.uniforms.width, width * paint.target.wide / lens.wide);
  gl.uniform4f(used.uniforms.tint, ...tint, 1);
  gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, points.length - 1);
}

/* A picture, once it is kept on the graphics side under a key. */
function pictureTexture(key, source) {
  if (paint.textures.has(key)) return paint.textures.get(key);
  // A map of a thousand signs needs no thousand pictures at once.
  if (paint.textures.size >= 160) {
    const [oldest, texture] = paint.textures.entries().next().value;
    gl.deleteTexture(texture);
    paint.textures.delete(oldest);
  }
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, source());
  gl.generateMipmap(gl.TEXTURE_2D);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  paint.textures.set(key, texture);
  return texture;
}

/* A picture on a surface with this middle, half as wide as `right` is long. What is less opaque is left out. */
function surface(texture, middle, right, up, least, lift = 0) {
  const used = use("surfaces");
  gl.bindTexture(gl.TEXTURE_2D, texture);
  gl.uniform1i(used.uniforms.picture, 0);
  gl.uniform3fv(used.uniforms.middle, middle);
  gl.uniform3fv(used.uniforms.right, right);
  gl.uniform3fv(used.uniforms.up, up);
  gl.uniform3fv(used.uniforms.eye, lens.eye);
  gl.uniform1f(used.uniforms.lift, lift);
  gl.uniform1f(used.uniforms.least, least);
  gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
}
