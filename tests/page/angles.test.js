// The angle of a joint: found by its name, its table, its ticks.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { whyNot } from '../../static/actions/actions.js';
import { angleRange, ticksOf } from '../../static/actions/angle_picture.js';
import { angleTable, degrees, extremes, framesWithAngle } from '../../static/actions/angles.js';
import { found } from '../../static/actions/search.js';
import { server, ui } from '../../static/store/state.js';

const SHOWN = {
  joint: 'knee',
  angle: 'flexion',
  label: 'Knee flexion',
  positive: 'flexion',
  negative: 'extension',
  choices: [],
  sides: [
    { side: 'L', part: 'left_shin', values: [null, 10, 62.4, null] },
    { side: 'R', part: 'right_shin', values: [null, -3, null, 5] },
  ],
};

beforeEach(() => {
  Object.assign(server, {
    file: { name: 'jump', path: '/jump', frames: 4, fps: 25 },
    view: { frame: 2, mode: 'both' },
    body: { is_persons: true, parts: [], presets: [] },
    keys: { frames: [1], drafts: [] },
    segments: [],
    joint_angle: null,
    notes: [],
  });
  Object.assign(ui, { search: 'All' });
});

test('it is found by its name before all else', () => {
  for (const [query, title] of [
    ['knee angle', 'Knee angle'],
    ['elbow angle', 'Elbow angle'],
    ['trunk', 'Trunk angle'],
  ]) {
    const [first] = found(query, 'All');
    assert.equal(first.title, title);
    assert.equal(first.off, '');
  }
});

test('what has no motion or is no person has none', () => {
  server.keys = { frames: [], drafts: [] };
  assert.equal(whyNot('kneeAngle'), 'Track or draft a motion first');
  server.body = { ...server.body, is_persons: false };
  assert.equal(whyNot('kneeAngle'), 'Needs a person’s body');
});

test('its table has what is known, a row a frame', () => {
  const rows = angleTable(SHOWN, (frame) => frame / 25)
    .trim()
    .split('\r\n');
  assert.deepEqual(rows, [
    'frame,time_s,left_knee_flexion_deg,right_knee_flexion_deg',
    '1,0.0400,10,-3',
    '2,0.0800,62.4,',
    '3,0.1200,,5',
  ]);
  assert.deepEqual(framesWithAngle(SHOWN), [1, 3]);
});

test('where depth was lifted its table says how far off each may be', () => {
  const sides = SHOWN.sides.map((side) => ({ ...side, errors: [null, 4.2, 5.1] }));
  const [head, first, , last] = angleTable({ ...SHOWN, sides }, (frame) => frame / 25)
    .trim()
    .split('\r\n');
  assert.equal(
    head,
    'frame,time_s,left_knee_flexion_deg,left_knee_flexion_expected_error_deg,right_knee_flexion_deg,right_knee_flexion_expected_error_deg',
  );
  assert.deepEqual([first, last], ['1,0.0400,10,4.2,-3,4.2', '3,0.1200,,,5,']);
});

test('the lowest and the highest are named with their frames', () => {
  assert.deepEqual(extremes(SHOWN.sides[0].values), { low: { frame: 1, value: 10 }, high: { frame: 2, value: 62.4 } });
  assert.equal(extremes([null]), null);
  assert.deepEqual([degrees(62.4), degrees(null), degrees(undefined)], ['62°', '–', '–']);
});

test('its scale is round and holds every value', () => {
  const [low, high] = angleRange(SHOWN);
  assert.ok(low < -3 && high > 62.4);
  assert.deepEqual(ticksOf(low, high, [1, 2, 5, 10, 20, 30], 6), [0, 20, 40, 60]);
  assert.deepEqual(ticksOf(0, 1, [0.1, 0.2, 0.5], 6), [0, 0.2, 0.4, 0.6, 0.8, 1]);
});
