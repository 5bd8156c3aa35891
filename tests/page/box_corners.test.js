// The corners of a box that can be dragged are those of the sides that are seen.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { cornerBeside, seenCorners } from '../../static/handles/boxcorners.js';

const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => [i & 4 ? 1 : -1, i & 2 ? 1 : -1, i & 1 ? 1 : -1]);
const moved = (by) => CORNERS.map((p) => p.map((v, k) => v + by[k]));

test('from straight in front the four corners of the near side are seen', () => {
  const points = moved([0, 0, 5]);
  assert.deepEqual(seenCorners(points, points), [0, 2, 4, 6]);
});

test('from a corner all but the farthest are seen', () => {
  const points = moved([5, 5, 5]);
  assert.deepEqual(seenCorners(points, points), [0, 1, 2, 3, 4, 5, 6]);
});

test('parallel rays show the near side alone, however far aside the box is', () => {
  const points = moved([5, 5, 5]);
  assert.deepEqual(
    seenCorners(
      points,
      points.map(() => [0, 0, 1]),
    ),
    [0, 2, 4, 6],
  );
});

test('a press beside a corner means the nearest one, as far as that corner lets it', () => {
  const corners = [
    { key: 'one', at: [0, 0], beside: 24 },
    { key: 'other', at: [40, 0], beside: 24 },
    { key: 'small', at: [200, 0], beside: 5 },
  ];
  const meant = (x, y) => cornerBeside(corners, x, y).map(({ key }) => key);
  assert.deepEqual(meant(17, 5), ['one']);
  assert.deepEqual(meant(24, 0), ['other']);
  assert.deepEqual(meant(20, 30), []);
  assert.deepEqual(meant(208, 0), []);
});
