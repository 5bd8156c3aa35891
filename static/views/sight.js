// The line of sight to a joint that is being dragged: where it would lie, nearer or farther, without
// leaving its place in the picture it is dragged in.

import { server, ui } from '../store/state.js';
import { plus } from './orbit.js';

/** Of the joint's distance: the line is drawn from the first on to the last. */
const SHARES = [0.25, 0.5, 1, 2, 4];
const NEAR_M = 0.05;

/**
 * Points of the line in the first camera's frame, the nearest first; none where nothing is dragged in a film.
 * @returns {number[][]}
 */
export function sightLine() {
  const { sight } = ui;
  const joint = sight && server.pose?.points[sight.anchor];
  if (!joint) return [];
  const way = plus(joint, sight.place, -1);
  return SHARES.map((share) => plus(sight.place, way, share));
}

/**
 * The same as it is seen by a camera, pixels; none where all of it lies behind.
 * @param {(p: number[]) => number[]} project  To pixels, and the depth.
 */
export function sightSeen(project) {
  const seen = sightLine()
    .map(project)
    .filter(([, , depth]) => depth > NEAR_M);
  return seen.length > 1 ? seen : [];
}
