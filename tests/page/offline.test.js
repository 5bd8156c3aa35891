// What the page shows of a drag by itself while the server does not answer.

import assert from 'node:assert/strict';
import test from 'node:test';

import './browser.js';

const { neighboursOf } = await import('../../static/handles/drag.js');

const PARTS = [
  { name: 'chest', parent: null, landmarks: [] },
  { name: 'upper_arm', parent: 'chest', landmarks: [] },
  { name: 'forearm', parent: 'upper_arm', landmarks: [] },
  { name: 'hand', parent: 'forearm', landmarks: ['hand_tip', 'thumb'] },
];
const POINTS = {
  chest: [0, 0, 0],
  upper_arm: [0, 1, 0],
  forearm: [0, 2, 0],
  hand: [0, 3, 0],
  hand_tip: [0, 4, 0],
  thumb: [1, 4, 0],
};

test('a joint hangs between the joints beside it', () => {
  assert.deepEqual(neighboursOf('forearm', PARTS, POINTS), [POINTS.upper_arm, POINTS.hand]);
});

test('the end of a limb hangs on its own part', () => {
  assert.deepEqual(neighboursOf('hand_tip', PARTS, POINTS), [POINTS.hand]);
  assert.deepEqual(neighboursOf('hand', PARTS, POINTS), [POINTS.forearm]);
});

test('what is not known has no neighbours', () => {
  assert.deepEqual(neighboursOf('nothing', PARTS, POINTS), []);
});
