/* From where the map is seen in space: around a point, or through the camera's own lens. World: metres, z up. */
const NEAR = 0.05, FAR = 1500, FARTHEST = 600, FIELD = 0.9;  // metres, the third of the eye; radians from bottom to top
const FROM_ABOVE = 0.75;  // radians below the horizon
const around = { at: [0, 0, 0], yaw: -1.9, pitch: FROM_ABOVE, far: 12 };
let lens = null;  // of the view that is drawn: its eye, axes, matrix and pixels

const plus = (a, b, times = 1) => a.map((value, axis) => value + times * b[axis]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => { const long = Math.hypot(...a) || 1; return a.map(value => value / long); };

/* The axes of a camera (right, down, ahead) from a pose x, y, z and a quaternion x, y, z, w. */
function axesOf([, , , x, y, z, w]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
    [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
    [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
  ];
}

const headingOf = pose => { const [, , ahead] = axesOf(pose); return Math.atan2(ahead[1], ahead[0]); };

/* A pose between two, by a share from 0 to 1. */
function between(a, b, share) {
  const sign = a.slice(3, 7).reduce((sum, value, at) => sum + value * b[3 + at], 0) < 0 ? -1 : 1;
  const mixed = a.slice(0, 7).map((value, at) => value * (1 - share) + b[at] * share * (at < 3 ? 1 : sign));
  const long = Math.hypot(...mixed.slice(3));
  return [...mixed.slice(0, 3), ...mixed.slice(3).map(value => value / long)];
}

/* The height of the ground; where none was seen, somewhat below the lowest the camera went. */
function groundHeight() {
  if (data.ground) return data.ground.height;
  const heights = data.trajectory.map(pose => pose[2]).filter(Number.isFinite);
  return heights.length ? Math.min(...heights) - 1.2 : -1.2;
}

function aroundAxes() {
  const flat = Math.cos(around.pitch);
  const back = [flat * Math.cos(around.yaw), flat * Math.sin(around.yaw), Math.sin(around.pitch)];
  const right = unit(cross(back.map(value => -value), [0, 0, 1]));
  return { back, right, up: cross(back, right) };
}

/* The lens for a canvas of so many pixels: through the camera where a pose is given, else around a point. */
function lensFor(wide, high, pose) {
  const [left, bottom] = covered();
  let eye, right, up, ahead, focal;
  if (pose) {
    const [x, y, z] = axesOf(pose);
    [eye, right, up, ahead] = [pose.slice(0, 3), x, y.map(value => -value), z];
    // The whole picture of the camera fits into what the panel leaves free.
    const [across, down, fx] = data.lens || [4, 3, 3.5];
    focal = fx * Math.min((wide - left) / across, (high - bottom) / down);
  } else {
    const axes = aroundAxes();
    [eye, right, up, ahead] = [plus(around.at, axes.back, around.far), axes.right, axes.up, axes.back.map(value => -value)];
    focal = (high - bottom) / 2 / Math.tan(FIELD / 2);
  }
  const middle = [left / wide, bottom / high], far = FAR;
  const rows = [
    [...right.map((value, axis) => value * focal * 2 / wide + middle[0] * ahead[axis]), 0],
    [...up.map((value, axis) => value * focal * 2 / high + middle[1] * ahead[axis]), 0],
    [...ahead.map(value => value * (far + NEAR) / (far - NEAR)), -2 * far * NEAR / (far - NEAR)],
    [...ahead, 0],
  ];
  for (const row of rows) row[3] -= dot(row, eye);
  const matrix = new Float32Array(16);
  rows.forEach((row, down) => row.forEach((value, across) => { matrix[across * 4 + down] = value; }));
  return { eye, right, up, ahead, focal, matrix, rows, wide, high, isFirstPerson: Boolean(pose) };
}

/* Where a point is on the canvas, in pixels, and how far ahead, in metres; null behind the eye. */
function projected(point) {
  const [x, y, , w] = lens.rows.map(row => dot(row, point) + row[3]);
  return w < NEAR ? null : [(x / w + 1) / 2 * lens.wide, (1 - y / w) / 2 * lens.high, w];
}

/* Show a box of space whole. */
function aim(low, high) {
  const half = low.map((value, axis) => (high[axis] - value) / 2);
  around.at = low.map((value, axis) => value + half[axis]);
  const [left, bottom] = covered(), wide = canvas.clientWidth - left, tall = canvas.clientHeight - bottom;
  const { back, right, up } = aroundAxes(), slope = Math.tan(FIELD / 2) * 0.92;
  const corners = Array.from({ length: 8 }, (_, each) => half.map((value, axis) => each >> axis & 1 ? value : -value));
  const needed = corners.map(corner => dot(corner, back) + Math.max(Math.abs(dot(corner, up)) / slope, Math.abs(dot(corner, right)) / slope * tall / wide));
  around.far = clamped(Math.max(...needed), 1.5, FARTHEST);
}
