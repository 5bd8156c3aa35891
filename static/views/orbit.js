// The eye of the free view: where it stands, how it goes round a point, and what it sees. It is plain
// values, {azimuth, elevation, target, distance}: degrees, metres in the camera frame. An azimuth of
// 0 looks as the film's camera does, level; 90 from the right of its picture.

import { clamp } from '../controls/arithmetic.js';

/** Pixels of the free view's plane, as `FREE_FOCAL` of `app/posing/pointer_view.py`. */
export const FOCAL = 1000;
export const LOWEST_DEG = 2;
export const HIGHEST_DEG = 88;
const NEAREST_M = 0.2;
const FARTHEST_M = 200;
const NEAR_M = 0.02;
const FAR_M = 2000;
/** The eye stays so far above the floor. */
const CLEAR_M = 0.02;

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @type {(a: number[], b: number[], k?: number) => import('../store/shapes.js').Point} */
export const plus = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** Something of the level frame, whose rows are those of the front view, in the camera frame. */
const fromLevel = (level, v) => [0, 1, 2].map((k) => level[0][k] * v[0] + level[1][k] * v[1] + level[2][k] * v[2]);

/** R_eye_camera: right, down and away as rows. */
export function rowsOf({ azimuth, elevation }, level) {
  const [a, e] = [azimuth, elevation].map((degrees) => (degrees * Math.PI) / 180);
  const right = [Math.cos(a), 0, Math.sin(a)];
  const away = [-Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e)];
  return [right, cross(away, right), away].map((row) => fromLevel(level, row));
}

/** Where the eye stands. */
export function placeOf(state, level) {
  return plus(state.target, rowsOf(state, level)[2], -state.distance);
}

/** Turned by degrees about a pivot, which stays where it is seen. */
export function orbited(state, level, azimuth, elevation, pivot) {
  const turned = {
    ...state,
    azimuth: wrapped(state.azimuth + azimuth),
    elevation: clamp(state.elevation + elevation, LOWEST_DEG, HIGHEST_DEG),
  };
  const [before, after] = [rowsOf(state, level), rowsOf(turned, level)];
  const way = plus(pivot, placeOf(state, level), -1);
  const seen = before.map((row) => dot(row, way));
  const place = seen.reduce((at, value, k) => plus(at, after[k], -value), pivot);
  return { ...turned, target: plus(place, after[2], state.distance) };
}

/** Shifted across the line of sight by pixels of the plane, at the target's distance. */
export function panned(state, level, dx, dy) {
  const [right, down] = rowsOf(state, level);
  const k = state.distance / FOCAL;
  return { ...state, target: plus(plus(state.target, right, -dx * k), down, -dy * k) };
}

/**
 * Nearer by a factor: what is seen at this point of the plane stays there.
 * @param {any} state
 * @param {number[][]} level
 * @param {number} factor
 * @param {number[]} at
 */
export function dollied(state, level, factor, [a, b]) {
  const distance = clamp(state.distance / factor, NEAREST_M, FARTHEST_M);
  const [right, down] = rowsOf(state, level);
  const k = (state.distance - distance) / FOCAL;
  return { ...state, distance, target: plus(plus(state.target, right, a * k), down, b * k) };
}

/** Lifted, where the eye would be under the floor, which lies so far along up. */
export function aboveFloor(state, level, floor) {
  const lack = dot(level[1], placeOf(state, level)) + floor + CLEAR_M;
  return lack > 0 ? { ...state, target: plus(state.target, level[1], -lack) } : state;
}

/** Looking along an axis of the level world; along the same again from the other side. */
export function alongAxis(state, level, axis, middle) {
  const sides = { x: [90, -90], z: [0, 180] }[axis];
  const azimuth = sides && (isAt(state, sides[0]) ? sides[1] : sides[0]);
  const elevation = axis === 'y' ? HIGHEST_DEG : LOWEST_DEG;
  return { ...state, azimuth: azimuth ?? state.azimuth, elevation, target: middle };
}

const isAt = ({ azimuth, elevation }, side) => Math.abs(wrapped(azimuth - side)) < 0.5 && elevation < LOWEST_DEG + 0.5;

/**
 * As near as all points are seen, in a plane of this half width and height, around their middle.
 * @param {{ azimuth: number, elevation: number }} direction
 * @param {number[][]} level
 * @param {number[][]} points
 * @param {number[]} half
 */
export function framing(direction, level, points, [wide, high]) {
  const rows = rowsOf(direction, level);
  const seen = points.map((p) => rows.map((row) => dot(row, p)));
  const ends = [0, 1, 2].map((k) => [Math.min(...seen.map((p) => p[k])), Math.max(...seen.map((p) => p[k]))]);
  const middle = ends.map(([low, top]) => (low + top) / 2);
  const target = middle.reduce((at, value, k) => plus(at, rows[k], value), [0, 0, 0]);
  const needed = seen.map(([x, y, z]) => {
    const across = Math.max(Math.abs(x - middle[0]) / wide, Math.abs(y - middle[1]) / high) * FOCAL;
    return across - (z - middle[2]);
  });
  return { ...direction, target, distance: clamp(Math.max(...needed), 1, FARTHEST_M) };
}

/** From one eye as far toward another as its distance stays within the greatest. */
export function between(one, other, greatest) {
  const share = clamp((greatest - one.distance) / Math.max(other.distance - one.distance, 1e-9), 0, 1);
  const mixed = (a, b) => a + share * (b - a);
  const target = one.target.map((value, k) => mixed(value, other.target[k]));
  return { ...one, target, distance: mixed(one.distance, other.distance) };
}

/** The eye, as the other views have one. Its plane is pixels around its middle. */
export function freeEye(state, level) {
  const rows = rowsOf(state, level);
  const place = placeOf(state, level);
  const seen = (p) => {
    const way = plus(p, place, -1);
    return rows.map((row) => dot(row, way));
  };
  return {
    rows,
    place,
    project(p) {
      const [x, y, z] = seen(p);
      const depth = Math.max(z, NEAR_M);
      return [(FOCAL * x) / depth, (FOCAL * y) / depth, z];
    },
    unitsPerMetre: (p) => FOCAL / Math.max(seen(p)[2], NEAR_M),
    setProjection(matrix, edges, coordinates, reversed) {
      const k = NEAR_M / FOCAL;
      const sides = [edges[0] * k, edges[2] * k, -edges[1] * k, -edges[3] * k, NEAR_M, FAR_M];
      matrix.makePerspective(...sides, coordinates, reversed);
    },
  };
}

/** Whether what was kept is an eye. */
export function isEye(kept) {
  const numbers = [kept?.azimuth, kept?.elevation, kept?.distance, ...(kept?.target ?? [])];
  return numbers.length === 6 && numbers.every(Number.isFinite) && kept.distance > 0;
}

function wrapped(degrees) {
  return degrees - 360 * Math.round(degrees / 360);
}
