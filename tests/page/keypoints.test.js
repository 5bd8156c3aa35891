// Keypoints of a frame: which are shown first, how sure they are, and their rings.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { server, ui } from '../../static/store/state.js';
import {
  arcOf,
  fewOf,
  keypointActions,
  keypointsHere,
  percentOf,
  ringsAreShown,
  unsure,
  worstOf,
} from '../../static/actions/keypoints.js';

const NAMES = [
  'left_shoulder',
  'left_elbow',
  'left_wrist',
  'right_wrist',
  'left_hip',
  'left_ankle',
  'right_ankle',
  'nose',
];
const points = (sure = {}) =>
  NAMES.map((joint) => ({ joint, label: joint, at: [1, 2], sure: sure[joint] ?? 0.9, state: 'found' }));

test('five are listed: the unsure ones, then those one looks at first, in the order of the body', () => {
  const names = (found) => fewOf(found).map(({ joint }) => joint);
  assert.deepEqual(names(points()), ['left_wrist', 'right_wrist', 'left_ankle', 'right_ankle', 'nose']);
  const unlike = points({ left_hip: 0.2, left_elbow: 0.6 });
  assert.deepEqual(names(unlike), ['left_elbow', 'left_wrist', 'right_wrist', 'left_hip', 'left_ankle']);
});

test('the worst is named where a person should look, never where one has decided', () => {
  assert.equal(worstOf(points()), undefined);
  const found = points({ left_hip: 0.3, nose: 0.5 });
  assert.equal(worstOf(found).joint, 'left_hip');
  found[4] = { ...found[4], state: 'ignored', sure: 0 };
  assert.equal(worstOf(found).joint, 'nose');
  assert.deepEqual(found.map(unsure).filter(Boolean).length, 1);
});

test('a ring says how sure it is', () => {
  assert.equal(percentOf({ state: 'found', sure: 0.577 }), '58 %');
  assert.equal(percentOf({ state: 'corrected', sure: 1 }), 'set');
  assert.equal(percentOf({ state: 'ignored', sure: 0 }), 'ignored');
  assert.equal(arcOf(10, 10, 5, 0), '');
  assert.equal(arcOf(10, 10, 5, 0.25), 'M10 5A5 5 0 0 1 15.00 10.00');
  assert.equal(arcOf(10, 10, 5, 0.75), 'M10 5A5 5 0 1 1 5.00 10.00');
  assert.equal(arcOf(10, 10, 5, 1), 'M10 5A5 5 0 0 1 10.00 15.00A5 5 0 0 1 10 5');
});

test('rings are shown while one works at tracking, unless somebody chose', () => {
  const shown = (tab, rings) => (Object.assign(ui, { tab, rings }), ringsAreShown());
  assert.deepEqual([shown('part'), shown('track')], [false, true]);
  assert.deepEqual([shown('part', true), shown('track', false)], [true, false]);
});

test('keypoints of another frame are never shown', () => {
  server.keypoints = { frame: 3, points: points() };
  server.view = { frame: 3 };
  assert.equal(keypointsHere().length, NAMES.length);
  server.view = { frame: 4 };
  assert.deepEqual(keypointsHere(), []);
});

test('what is as it was found cannot be put back, and what is ignored not be ignored again', () => {
  const offs = (state) => keypointActions({ joint: 'nose', state }, 3).map(({ off }) => Boolean(off));
  assert.deepEqual(offs('found'), [true, false]);
  assert.deepEqual(offs('corrected'), [false, false]);
  assert.deepEqual(offs('ignored'), [false, true]);
});
