// Curves of many frames on few pixels: nothing that a person should see is lost.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server } from '../../static/store/state.js';
import { extent, line, numbers, runsOf } from '../../static/timeline/draw/series.js';
import * as scale from '../../static/timeline/draw/scale.js';
import * as timeWindow from '../../static/actions/window.js';

beforeEach(() => {
  server.file = { frames: 6 };
  scale.setWidth(scale.left() + 500 + 26);
  timeWindow.showAll();
});

test('a list is turned into numbers once, missing ones into NaN', () => {
  const list = [1, null, 3];
  assert.deepEqual([...numbers(list)], [1, NaN, 3]);
  assert.equal(numbers(list), numbers(list));
  assert.equal(numbers(null).length, 0);
});

test('lowest and highest leave out what is missing, and what is not asked for', () => {
  assert.deepEqual(extent([NaN, 4, -2, NaN, 9]), { low: -2, high: 9 });
  assert.deepEqual(extent([NaN, 4, -2, NaN, 9], 0, 2), { low: -2, high: 4 });
  assert.equal(extent([NaN]), null);
  assert.equal(extent([]), null);
});

test('a missing value parts a curve in two', () => {
  const runs = runsOf([0, 1, null, 3, 4, 5]);
  assert.deepEqual(
    runs.map((run) => run.map(({ frame }) => frame)),
    [
      [0, 1],
      [3, 4, 5],
    ],
  );
  assert.equal(runs[1][0].x, scale.x(3));
});

test('only the frames that are asked for are drawn', () => {
  const runs = runsOf([0, 1, 2, 3, 4, 5], 2, 4);
  assert.deepEqual(
    runs.map((run) => run.map(({ frame }) => frame)),
    [[2, 3, 4]],
  );
});

test('of many thousand frames no more columns are drawn than pixels, and a single dip is seen', () => {
  server.file = { frames: 200_000 };
  const list = Array(200_000).fill(1);
  list[123_456] = 0;
  const [run] = runsOf(list);
  assert.ok(run.length <= 510, `${run.length}`);
  const dips = run.filter(({ low }) => low === 0);
  assert.equal(dips.length, 1);
  assert.ok(Math.abs(dips[0].x - scale.x(123_456)) < 2);
});

test('a line goes through one value, and through both ends where frames share a column', () => {
  const y = (value) => 10 * value;
  const run = [
    { x: 1, low: 2, high: 2 },
    { x: 2, low: 1, high: 3 },
  ];
  assert.equal(line(run, y), 'M1.0 20.0L2.0 30.0L2.0 10.0');
});
