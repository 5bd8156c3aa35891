// Series of values by frame, as they are sent and as the page has them.

import assert from 'node:assert/strict';
import test from 'node:test';
import './browser.js';
import { listOf, unpacked } from '../../static/store/series.js';

test('each run of values stands at its frames, with nulls where nothing is known', () => {
  assert.deepEqual(
    listOf([
      [2, 0.5, 1],
      [6, 7],
    ]),
    [null, null, 0.5, 1, null, null, 7],
  );
  assert.deepEqual(listOf([]), []);
});

test('series are unpacked wherever they are sent, all else stays as it is', () => {
  const view = { frame: 3 };
  const sides = [{ side: 'L', part: 'shin', values: [[1, 9]] }];
  const found = unpacked({
    view,
    need: [[0, 1]],
    lanes: { waist: [[1, 2]] },
    curve: { part: 'shin', x: [], y: [[0, 1]], z: [], error: [[2, 3]] },
    joint_angle: { joint: 'knee', sides },
  });
  assert.equal(found.view, view);
  assert.deepEqual(found.need, [1]);
  assert.deepEqual(found.lanes, { waist: [null, 2] });
  assert.deepEqual(found.curve, { part: 'shin', x: [], y: [1], z: [], error: [null, null, 3] });
  assert.deepEqual(found.joint_angle, { joint: 'knee', sides: [{ side: 'L', part: 'shin', values: [null, 9] }] });
});

test('a session without a body has none of them', () => {
  assert.deepEqual(unpacked({ need: [], lanes: {}, curve: null, joint_angle: null }), {
    need: [],
    lanes: {},
    curve: null,
    joint_angle: null,
  });
});
