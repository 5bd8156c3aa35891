// The floor and what stands on it, as lines and areas on the screen: its grid, shadows, outlines of
// solids. A view's `project` takes points of the camera frame, metres; `level` are the rows of the
// front view, of which the second points down; `floor` is how far along up the floor lies.

import { dot, plus } from './orbit.js';

export const CELL_M = 0.25;
const STRONG_EVERY = 4;
const PIECES = 2;
const BANDS = 8;
const NEAR_M = 0.05;
const FARTHEST_PX = 20000;

/** The point of the floor straight below. */
export function dropped(p, level, floor) {
  return plus(p, level[1], -floor - dot(level[1], p));
}

/**
 * The grid around a point, its lines at multiples of a cell, fading until `reach`: paths with the
 * share of their strength, 0 to 1, and whether they are those of every fourth line.
 * @returns {{ d: string, share: number, isStrong: boolean }[]}
 */
export function gridPaths(project, { level, floor, centre, reach, cell = CELL_M }) {
  const [x, z] = [dot(level[0], centre), dot(level[2], centre)];
  const paths = new Map();
  const at = (a, b) => project(plus(plus(plus([0, 0, 0], level[0], a), level[2], b), level[1], -floor));
  const lines = (middle, other, point) => {
    const count = Math.floor(reach / cell);
    for (let k = Math.ceil(middle / cell) - count; k <= middle / cell + count; k++) {
      const half = Math.sqrt(Math.max(reach * reach - (k * cell - middle) ** 2, 0));
      drawLine(paths, k % STRONG_EVERY === 0, k * cell - middle, other, half, cell * PIECES, reach, (b) =>
        point(k * cell, b),
      );
    }
  };
  lines(x, z, (a, b) => at(a, b));
  lines(z, x, (b, a) => at(a, b));
  return [...paths.values()];
}

/** One line in pieces, each as strong as it is near. */
function drawLine(paths, isStrong, aside, middle, half, step, reach, point) {
  const count = Math.max(1, Math.ceil((2 * half) / step));
  let before = null;
  for (let i = 0; i <= count; i++) {
    const along = -half + (2 * half * i) / count;
    const now = point(middle + along);
    if (before && isSeen(before) && isSeen(now)) {
      const far = Math.hypot(aside, along - half / count) / reach;
      addPiece(paths, isStrong, Math.ceil((1 - far) * BANDS), before, now);
    }
    before = now;
  }
}

function addPiece(paths, isStrong, band, a, b) {
  if (band <= 0) return;
  const key = isStrong ? band : -band;
  const path = paths.get(key) ?? { d: '', share: band / BANDS, isStrong };
  path.d += `M${a[0].toFixed(1)} ${a[1].toFixed(1)}L${b[0].toFixed(1)} ${b[1].toFixed(1)}`;
  paths.set(key, path);
}

const isSeen = ([x, y, depth]) => depth > NEAR_M && Math.abs(x) < FARTHEST_PX && Math.abs(y) < FARTHEST_PX;

/** Points of a part, given in its frame, in the camera's; T has three rows of four. */
export function placed(points, T) {
  return points.map(([x, y, z]) => [
    T[0] * x + T[1] * y + T[2] * z + T[3],
    T[4] * x + T[5] * y + T[6] * z + T[7],
    T[8] * x + T[9] * y + T[10] * z + T[11],
  ]);
}

/** The outline of a convex solid, as corners on the screen; none where it is not all before the eye. */
export function outlineOf(points, project) {
  const seen = points.map(project);
  return seen.every(isSeen) ? hull(seen) : [];
}

/** The convex hull of points on the screen. */
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const kept = [];
    for (const p of list) {
      while (kept.length > 1 && turn(kept.at(-2), kept.at(-1), p) <= 0) kept.pop();
      kept.push(p);
    }
    kept.pop();
    return kept;
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const turn = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

/**
 * The transform of style that lays a picture of this size onto four corners on the screen, from the
 * upper left clockwise.
 * @param {number[][]} corners
 * @param {number} width
 * @param {number} height
 */
export function onto([[x0, y0], [x1, y1], [x2, y2], [x3, y3]], width, height) {
  const [dx1, dx2, dx3] = [x1 - x2, x3 - x2, x0 - x1 + x2 - x3];
  const [dy1, dy2, dy3] = [y1 - y2, y3 - y2, y0 - y1 + y2 - y3];
  const size = dx1 * dy2 - dx2 * dy1;
  const g = (dx3 * dy2 - dx2 * dy3) / size;
  const h = (dx1 * dy3 - dx3 * dy1) / size;
  const across = [x1 - x0 + g * x1, y1 - y0 + g * y1, 0, g].map((v) => v / width);
  const down = [x3 - x0 + h * x3, y3 - y0 + h * y3, 0, h].map((v) => v / height);
  return `matrix3d(${[...across, ...down, 0, 0, 1, 0, x0, y0, 0, 1].map((v) => v.toFixed(9)).join()})`;
}
