// The history as a list: the newest first, by days, the present step marked.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dayOf, historyRows } from '../../static/actions/history.js';

const NOON = new Date(2026, 10, 23, 12, 0).getTime() / 1000;
const DAY = 86400;
const step = (label, made) => ({ label, frame: 0, made });

test('steps stand under the day they were made on, the newest first', () => {
  const history = {
    done: 3,
    total: 4,
    first: 0,
    steps: [
      step('add keyframe 0', null),
      step('turn head', NOON - DAY),
      step('pin left foot', NOON - 60),
      step('unpin', NOON),
    ],
  };
  const rows = historyRows(history, NOON);
  assert.deepEqual(
    rows.map((row) => row.heading ?? `${row.done} ${row.label} ${row.state}`),
    [
      'Today',
      '4 Unpin undone',
      '3 Pin left foot here',
      'Yesterday',
      '2 Turn head done',
      'Earlier',
      '1 Add keyframe 0 done',
      '0 Beginning done',
    ],
  );
  assert.equal(rows[1].time, '12:00');
});

test('a part of a long history has no beginning, and counts from where it stands', () => {
  const rows = historyRows({ done: 201, total: 201, first: 200, steps: [step('turn head', NOON)] }, NOON);
  assert.deepEqual(rows.slice(1), [{ label: 'Turn head', time: '12:00', done: 201, state: 'here' }]);
});

test('where nothing was done one stands at the beginning', () => {
  assert.deepEqual(historyRows({ done: 0, total: 0, first: 0, steps: [] }, NOON), [
    { label: 'Beginning', time: '', done: 0, state: 'here' },
  ]);
  assert.deepEqual(historyRows(null), []);
});

test('days are those of the calendar', () => {
  assert.equal(dayOf(NOON - 13 * 3600, NOON), 'Yesterday');
  assert.equal(dayOf(NOON + 5, NOON), 'Today');
  assert.equal(dayOf(NOON - 11 * DAY, NOON), '12 Nov');
  assert.equal(dayOf(NOON - 400 * DAY, NOON), '19 Oct 2025');
});
