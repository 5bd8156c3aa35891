import './browser.js';
import assert from 'node:assert/strict';
import test from 'node:test';

import { fillsOf } from '../../static/timeline/marks/part_keyframes.js';

const arm = { side: 'R' };
const leg = { side: 'L' };

test('one limb fills the lower half in its colour', () => {
  assert.deepEqual(fillsOf([arm], 10, 20, 5), [['R', 'M5 20h10l-5 5z']]);
});

test('two limbs share the diamond, left and right', () => {
  const fills = fillsOf([arm, leg], 10, 20, 5);
  assert.deepEqual(
    fills.map(([side]) => side),
    ['R', 'L'],
  );
  assert.ok(fills.every(([, path]) => path.startsWith('M10 15')));
});

test('more limbs than two have the colour of the trunk', () => {
  assert.deepEqual(
    fillsOf([arm, leg, arm], 0, 0, 5).map(([side]) => side),
    ['C'],
  );
});
