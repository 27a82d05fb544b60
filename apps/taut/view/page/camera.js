// A camera about the point it looks at. World space, z up unless the scene says otherwise.

const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const times = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.sqrt(dot(a, a));
const unit = (a) => times(a, 1 / length(a));

// Rodrigues' rotation of v about a unit axis.
function turned(v, axis, angle) {
  const c = Math.cos(angle), s = Math.sin(angle);
  return add(add(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
}

const kSteepest = Math.cos((1 * Math.PI) / 180);

// Turns by angles in radians: `right` moves the eye to the right of what it sees, `up` above it. Poles are not crossed.
export function orbit(camera, right, up) {
  const axis = unit(camera.up);
  let arm = turned(sub(camera.position, camera.look_at), axis, right);
  const side = unit(cross(axis, arm));
  const steeper = turned(arm, side, -up);
  if (Math.abs(dot(unit(steeper), axis)) < kSteepest) arm = steeper;
  return { ...camera, position: add(camera.look_at, arm) };
}

// Moves in the picture's plane by shares of its height, at the distance of what is looked at.
export function pan(camera, right, up) {
  const arm = sub(camera.position, camera.look_at);
  const side = unit(cross(camera.up, arm));
  const above = unit(cross(arm, side));
  const height = camera.ortho_height ?? 2 * length(arm) * Math.tan((camera.fov_deg * Math.PI) / 360);
  const step = add(times(side, right * height), times(above, up * height));
  return { ...camera, position: add(camera.position, step), look_at: add(camera.look_at, step) };
}

// Nearer by a factor below 1.
export function dolly(camera, factor) {
  const next = { ...camera, position: add(camera.look_at, times(sub(camera.position, camera.look_at), factor)) };
  if (camera.ortho_height) next.ortho_height = camera.ortho_height * factor;
  return next;
}
