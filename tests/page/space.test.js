// The little vector algebra of the handles.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as space from '../../static/handles/space.js';

const T = [1, 2, 3, 10, 4, 5, 6, 11, 7, 8, 9, 12]; // the rows of a 3×4 matrix

test('a transform has its axes in its columns and its joint in the last one', () => {
  assert.deepEqual(space.axesOf(T), [
    [1, 4, 7],
    [2, 5, 8],
    [3, 6, 9],
  ]);
  assert.deepEqual(space.originOf(T), [10, 11, 12]);
});

test('a unit vector has length one, and nothing stays nothing', () => {
  assert.equal(space.size(space.unit([3, 4, 12])), 1);
  assert.deepEqual(space.unit([0, 0, 0]), [0, 0, 0]);
  assert.deepEqual(space.add([1, 2, 3], [1, 1, 1], -2), [-1, 0, 1]);
  assert.equal(space.dot([1, 2, 3], [4, 5, 6]), 32);
});

test('the nearest place on a path is on a segment or at its end', () => {
  const path = [
    [0, 0],
    [10, 0],
    [10, 10],
  ];
  assert.deepEqual(space.nearestOnPath(path, 5, 3), { distance: 3, place: 0.5 });
  assert.deepEqual(space.nearestOnPath(path, 12, 5), { distance: 2, place: 1.5 });
  assert.deepEqual(space.nearestOnPath(path, -3, -4), { distance: 5, place: 0 });
  assert.equal(space.nearestOnPath([[1, 1]], 0, 0).distance, Infinity);
});

test('a point is inside a polygon or outside, also where it is bent inward', () => {
  const bent = [
    [0, 0],
    [10, 0],
    [10, 10],
    [5, 4],
    [0, 10],
  ];
  assert.ok(space.inside(bent, 5, 3));
  assert.ok(space.inside(bent, 1, 7));
  assert.ok(!space.inside(bent, 5, 7));
  assert.ok(!space.inside(bent, 11, 5));
});

test('a path is closed where that is wanted, and empty of nothing', () => {
  assert.equal(
    space.pathOf([
      [0, 0],
      [1.25, 2],
    ]),
    'M0.0 0.0L1.3 2.0',
  );
  assert.equal(
    space.pathOf(
      [
        [0, 0],
        [1, 2],
      ],
      true,
    ),
    'M0.0 0.0L1.0 2.0Z',
  );
  assert.equal(space.pathOf([]), '');
});
