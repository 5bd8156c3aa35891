// The box around a person: drawn, pulled at its grips and moved, within the picture.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { between, clipped, GRIPS, gripsOf, holds, moved, pulled, sizeOf } from '../../static/handles/box_shape.js';

const BOX = [10, 20, 50, 100];
const PICTURE = [-0.5, -0.5, 199.5, 149.5];

test('a box is the same from whichever corner it was drawn', () => {
  assert.deepEqual(between([10, 20], [50, 100]), BOX);
  assert.deepEqual(between([50, 20], [10, 100]), BOX);
  assert.deepEqual(between([50, 100], [10, 20]), BOX);
});

test('a grip takes its own sides along and leaves the others', () => {
  const names = ['left', 'top', 'right', 'bottom'];
  const sides = GRIPS.map((_, grip) => {
    const after = pulled(BOX, grip, [3, -4]);
    return names.filter((_side, i) => after[i] !== BOX[i]).join(' ');
  });
  assert.deepEqual(sides, ['left top', 'top', 'top right', 'right', 'right bottom', 'bottom', 'left bottom', 'left']);
});

test('a grip follows the pointer', () => {
  for (const [grip, [x, y]] of gripsOf(BOX).entries()) {
    const [u, v] = gripsOf(pulled(BOX, grip, [3, -4]))[grip];
    assert.deepEqual([u, v], [x + 3 * (GRIPS[grip][0] === 0.5 ? 0 : 1), y - 4 * (GRIPS[grip][1] === 0.5 ? 0 : 1)]);
  }
});

test('a box pulled past its opposite side turns over', () => {
  assert.deepEqual(pulled(BOX, 3, [-60, 0]), [-10, 20, 10, 100]);
});

test('a moved box keeps its size and stays in the picture', () => {
  assert.deepEqual(moved(BOX, [5, 5], PICTURE), [15, 25, 55, 105]);
  const far = moved(BOX, [1000, -1000], PICTURE);
  assert.deepEqual(sizeOf(far), sizeOf(BOX));
  assert.deepEqual(far, [159.5, -0.5, 199.5, 79.5]);
});

test('what is drawn beyond the picture ends at its border', () => {
  assert.deepEqual(clipped([-30, 20, 500, 900], PICTURE), [-0.5, 20, 199.5, 149.5]);
});

test('a place is inside or outside', () => {
  assert.ok(holds(BOX, [30, 60]));
  assert.ok(!holds(BOX, [30, 101]));
});
