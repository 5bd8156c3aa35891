// The eye of the free view: it goes round a point that stays in place, within its limits.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import {
  aboveFloor,
  alongAxis,
  between,
  dollied,
  dot,
  FOCAL,
  framing,
  freeEye,
  HIGHEST_DEG,
  LOWEST_DEG,
  orbited,
  panned,
  placeOf,
} from '../../static/views/orbit.js';

const LEVEL = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
/** A camera that looks down a little and leans. */
const LEANING = turned();
const STATE = { azimuth: 40, elevation: 20, target: [0.2, 0.3, 4], distance: 5 };

const near = (actual, expected, within = 1e-9) =>
  expected.forEach((value, i) => assert.ok(Math.abs(actual[i] - value) < within, `${actual} ≠ ${expected}`));

test('at azimuth 0 it looks as the camera does, at 90 from the right of its picture', () => {
  const ahead = { azimuth: 0, elevation: 0, target: [0, 0, 4], distance: 4 };
  near(placeOf(ahead, LEVEL), [0, 0, 0]);
  near(freeEye(ahead, LEVEL).project([1, 0, 4]), [FOCAL / 4, 0, 4]);
  near(placeOf({ ...ahead, azimuth: 90 }, LEVEL), [4, 0, 4]);
});

test('what one orbits about stays where it is seen, as far away', () => {
  for (const level of [LEVEL, LEANING]) {
    const pivot = [0.6, -0.1, 3.2];
    const before = freeEye(STATE, level).project(pivot);
    const round = orbited(STATE, level, 35, 12, pivot);
    near(freeEye(round, level).project(pivot), before, 1e-6);
    assert.notEqual(round.azimuth, STATE.azimuth);
  }
});

test('it goes neither under the floor nor over the zenith', () => {
  assert.equal(orbited(STATE, LEVEL, 0, -500, STATE.target).elevation, LOWEST_DEG);
  assert.equal(orbited(STATE, LEVEL, 0, 500, STATE.target).elevation, HIGHEST_DEG);
  const low = { ...STATE, elevation: LOWEST_DEG, target: [0, 2, 4] };
  assert.ok(-dot(LEVEL[1], placeOf(aboveFloor(low, LEVEL, -1), LEVEL)) > -1);
  assert.equal(aboveFloor(STATE, LEVEL, -1), STATE);
});

test('what lies under the pointer stays there while one comes nearer', () => {
  const at = [120, -80];
  const eye = freeEye(STATE, LEVEL);
  const [right, down] = eye.rows;
  const point = [0, 1, 2].map((k) => STATE.target[k] + (STATE.distance / FOCAL) * (at[0] * right[k] + at[1] * down[k]));
  near(eye.project(point), [...at, STATE.distance], 1e-6);
  near(
    freeEye(dollied(STATE, LEVEL, 1.6, at), LEVEL)
      .project(point)
      .slice(0, 2),
    at,
    1e-6,
  );
});

test('what is dragged across follows the pointer', () => {
  const moved = freeEye(panned(STATE, LEVEL, 30, -12), LEVEL).project(STATE.target);
  near(moved.slice(0, 2), [30, -12], 1e-6);
});

test('a reset shows all there is, and no more than the body from too far', () => {
  const points = [
    [-1, -1, 2],
    [1, 0.9, 5],
    [0.3, 0.2, 3],
  ];
  const half = [600, 400];
  const all = framing({ azimuth: 52, elevation: 20 }, LEVEL, points, half);
  for (const [x, y] of points.map(freeEye(all, LEVEL).project)) {
    assert.ok(Math.abs(x) <= half[0] + 1e-6 && Math.abs(y) <= half[1] + 1e-6);
  }
  const nearer = { ...all, distance: all.distance / 4 };
  assert.equal(between(nearer, all, 2 * nearer.distance).distance, 2 * nearer.distance);
});

test('looking along an axis twice looks from its other side', () => {
  const once = alongAxis(STATE, LEVEL, 'x', [0, 0, 3]);
  assert.deepEqual([once.azimuth, once.elevation], [90, LOWEST_DEG]);
  assert.equal(alongAxis(once, LEVEL, 'x', [0, 0, 3]).azimuth, -90);
  assert.equal(alongAxis(STATE, LEVEL, 'y', [0, 0, 3]).elevation, HIGHEST_DEG);
});

function turned() {
  const [a, b] = [0.2, 0.35];
  const [c, s, d, t] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
  return [
    [c, s, 0],
    [-s * d, c * d, t],
    [s * t, -c * t, d],
  ];
}
