// The little vector algebra of the handles. Points are [x, y, z] in the camera frame, metres; a
// pose gives each part's T_camera_part as 12 numbers, the rows of a 3×4 matrix.

import { clamp } from '../controls/arithmetic.js';

export const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
export const times = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const size = (a) => Math.hypot(a[0], a[1], a[2]);
export const unit = (a) => times(a, 1 / (size(a) || 1));

/** The three axes of a part's frame, as the camera sees them. */
export function axesOf(T) {
  return [0, 1, 2].map((column) => [T[column], T[4 + column], T[8 + column]]);
}

/** The origin of a part's frame: its joint. */
export function originOf(T) {
  return [T[3], T[7], T[11]];
}

/** The axes of a view: the camera's own, or the rows of R_view_camera. */
export function axesOfView(R) {
  return (
    R ?? [
      [1, 0, 0],
      [0, 1, 0],
      [0, 0, 1],
    ]
  );
}

/** Distance of two points on the screen. */
export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** Distance of a point from a polyline on the screen, and where on it, in segments. */
export function nearestOnPath(path, x, y) {
  let best = { distance: Infinity, place: 0 };
  for (let i = 0; i + 1 < path.length; i++) {
    const [a, b] = [path[i], path[i + 1]];
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const along = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy || 1);
    const t = clamp(along, 0, 1);
    const away = Math.hypot(a[0] + t * dx - x, a[1] + t * dy - y);
    if (away < best.distance) best = { distance: away, place: i + t };
  }
  return best;
}

/** Whether a point lies inside a polygon on the screen. */
export function inside(polygon, x, y) {
  let within = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [a, b] = [polygon[i], polygon[j]];
    const crosses = a[1] > y !== b[1] > y;
    if (crosses && x < ((b[0] - a[0]) * (y - a[1])) / (b[1] - a[1]) + a[0]) within = !within;
  }
  return within;
}

/** An SVG path through points on the screen. */
export function pathOf(points, closed = false) {
  const steps = points.map((p) => `${p[0].toFixed(1)} ${p[1].toFixed(1)}`);
  return steps.length ? `M${steps.join('L')}${closed ? 'Z' : ''}` : '';
}
