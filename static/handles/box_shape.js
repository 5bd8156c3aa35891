// The box around a person, [left, top, right, bottom] in pixels of the video: drawn, pulled at one of
// its eight grips, moved, and always within the picture.

import { clamp } from '../controls/arithmetic.js';

/** @typedef {[number, number, number, number]} Box */
/** @typedef {import('../store/shapes.js').Spot} Spot */

/**
 * The grips, clockwise from the upper left: where across the box and where down it each is.
 * @type {Spot[]}
 */
export const GRIPS = [
  [0, 0],
  [0.5, 0],
  [1, 0],
  [1, 0.5],
  [1, 1],
  [0.5, 1],
  [0, 1],
  [0, 0.5],
];

/** The pointer over each of them. */
export const CURSORS = ['nwse', 'ns', 'nesw', 'ew', 'nwse', 'ns', 'nesw', 'ew'].map((way) => `${way}-resize`);

/**
 * Where the grips of a box are.
 * @param {Box} box
 * @returns {Spot[]}
 */
export function gripsOf([left, top, right, bottom]) {
  return GRIPS.map(([u, v]) => [left + u * (right - left), top + v * (bottom - top)]);
}

/**
 * The box between two opposite corners, whichever comes first.
 * @param {Spot} a
 * @param {Spot} b
 * @returns {Box}
 */
export const between = ([x0, y0], [x1, y1]) => [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)];

/**
 * A box of which one grip was pulled so far; past the opposite side it turns over.
 * @param {Box} box
 * @param {number} grip
 * @param {Spot} by
 * @returns {Box}
 */
export function pulled([left, top, right, bottom], grip, [dx, dy]) {
  const [u, v] = GRIPS[grip];
  return between(
    [left + (u === 0 ? dx : 0), top + (v === 0 ? dy : 0)],
    [right + (u === 1 ? dx : 0), bottom + (v === 1 ? dy : 0)],
  );
}

/**
 * A box moved so far, as a whole within the bounds.
 * @param {Box} box
 * @param {Spot} by
 * @param {Box} bounds
 * @returns {Box}
 */
export function moved([left, top, right, bottom], [dx, dy], [x0, y0, x1, y1]) {
  const x = clamp(dx, x0 - left, x1 - right);
  const y = clamp(dy, y0 - top, y1 - bottom);
  return [left + x, top + y, right + x, bottom + y];
}

/**
 * What of a box lies within the bounds.
 * @param {Box} box
 * @param {Box} bounds
 * @returns {Box}
 */
export function clipped([left, top, right, bottom], [x0, y0, x1, y1]) {
  return [clamp(left, x0, x1), clamp(top, y0, y1), clamp(right, x0, x1), clamp(bottom, y0, y1)];
}

/**
 * Width and height.
 * @param {Box} box
 * @returns {Spot}
 */
export const sizeOf = ([left, top, right, bottom]) => [right - left, bottom - top];

/** @param {Box} box @param {Spot} at */
export const holds = ([left, top, right, bottom], [x, y]) => left <= x && x <= right && top <= y && y <= bottom;
