// The world beside the camera of the present frame: points go over and come back.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { moved, movedBack } from '../../static/views/world.js';

const near = (actual, expected) =>
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-12, `${actual} ≠ ${expected}`));

/** A quarter turn about y, and a step. */
const T = [0, 0, 1, 0.5, 0, 1, 0, -2, -1, 0, 0, 3];

test('a point is turned and moved, and comes back to where it was', () => {
  near(moved([1, 2, 4], T), [4.5, 0, 2]);
  near(movedBack([4.5, 0, 2], T), [1, 2, 4]);
  for (const p of [
    [0, 0, 0],
    [0.3, -1.2, 7],
  ]) {
    near(movedBack(moved(p, T), T), p);
  }
});

test('a camera that stands still is the world', () => {
  assert.deepEqual(moved([1, 2, 3], null), [1, 2, 3]);
  assert.deepEqual(movedBack([1, 2, 3], null), [1, 2, 3]);
});
