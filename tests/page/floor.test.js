// The floor on the screen: a grid that fades, what is dropped onto it, pictures laid into a frame.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { CELL_M, dropped, gridPaths, hull, onto, outlineOf, placed } from '../../static/views/floor.js';

const LEVEL = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];
const project = ([x, y, z]) => [(500 * x) / z, (500 * y) / z, z];

test('the grid lies on the floor, fades outward, and every fourth line is strong', () => {
  const paths = gridPaths(project, { level: LEVEL, floor: -1, centre: [0, 0, 5], reach: 2 });
  const points = paths.flatMap(({ d }) => [...d.matchAll(/(-?[\d.]+) (-?[\d.]+)/g)].map(([, , y]) => Number(y)));
  assert.ok(points.length > 100);
  // A floor one metre below the eye, 3 to 7 metres away.
  for (const y of points) assert.ok(y > 500 / 7 - 1 && y < 500 / 3 + 1, `${y}`);
  for (const { share } of paths) assert.ok(share > 0 && share <= 1);
  assert.ok(paths.some(({ isStrong }) => isStrong) && paths.some(({ isStrong }) => !isStrong));
  assert.equal(CELL_M, 0.25);
});

test('nothing is drawn of a floor behind the eye', () => {
  assert.deepEqual(gridPaths(project, { level: LEVEL, floor: -1, centre: [0, 0, -5], reach: 2 }), []);
});

test('a point is dropped straight down', () => {
  assert.deepEqual(dropped([0.5, -0.2, 3], LEVEL, -1.1), [0.5, 1.1, 3]);
});

test('a convex solid is seen as the hull of its corners, or not at all', () => {
  const cube = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z) => [x, y, z])));
  const T = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5];
  assert.equal(outlineOf(placed(cube, T), project).length, 4);
  assert.deepEqual(outlineOf(cube, project), []);
  assert.equal(
    hull([
      [0, 0],
      [2, 0],
      [2, 2],
      [0, 2],
      [1, 1],
    ]).length,
    4,
  );
});

test('a picture is laid onto four corners', () => {
  const corners = [
    [10, 20],
    [110, 30],
    [100, 140],
    [5, 120],
  ];
  const m = onto(corners, 64, 48).slice('matrix3d('.length, -1).split(',').map(Number);
  const at = (x, y) => {
    const w = m[3] * x + m[7] * y + m[15];
    return [(m[0] * x + m[4] * y + m[12]) / w, (m[1] * x + m[5] * y + m[13]) / w];
  };
  [
    [0, 0],
    [64, 0],
    [64, 48],
    [0, 48],
  ].forEach(([x, y], i) => {
    at(x, y).forEach((value, k) => assert.ok(Math.abs(value - corners[i][k]) < 0.01, `${at(x, y)} ≠ ${corners[i]}`));
  });
});
