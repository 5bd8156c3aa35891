// How degrees lie on the rows of the curve.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { rangeOf, scaleOf } from '../../static/timeline/draw/curve.js';

const ROW = { y: 50, h: 112 };

test('a range has some air, and a curve that hardly moves at least twenty degrees', () => {
  assert.deepEqual(rangeOf([0, null, 100]), { low: -6, high: 106 });
  const { low, high } = rangeOf([30, 30, 30]);
  assert.deepEqual([low, high], [20, 40]);
});

test('without any value there is no range', () => {
  assert.equal(rangeOf([]), null);
  assert.equal(rangeOf([null, null]), null);
  assert.equal(rangeOf(undefined), null);
});

test('the highest value is at the top, and a value and its pixel lead to each other', () => {
  const scale = scaleOf({ low: -50, high: 50 }, ROW);
  assert.equal(scale.y(50), 56);
  assert.equal(scale.y(-50), 156);
  for (const value of [-80, -12.5, 0, 33]) assert.ok(Math.abs(scale.value(scale.y(value)) - value) < 1e-9);
});

test('the ticks are round, lie within the range and leave room for their numbers', () => {
  const cases = [
    [-50, 50],
    [-3, 17],
    [0, 700],
    [-181, 12],
    [10.2, 31.1],
  ];
  for (const [low, high] of cases) {
    const { ticks, y } = scaleOf({ low, high }, ROW);
    assert.ok(ticks.length >= 1 && ticks.length <= 7, `${ticks}`);
    assert.ok(
      ticks.every((tick) => tick >= low && tick <= high),
      `${ticks}`,
    );
    const step = ticks[1] - ticks[0];
    assert.ok(ticks.length < 2 || [1, 2, 5, 10, 15, 20, 30, 45, 60, 90, 180, 360].includes(step));
    assert.ok(ticks.length < 2 || y(ticks[0]) - y(ticks[1]) >= 15);
  }
  assert.deepEqual(scaleOf({ low: -50, high: 50 }, ROW).ticks, [-40, -20, 0, 20, 40]);
});

test('a row that is too low for a curve divides by nothing', () => {
  const scale = scaleOf({ low: 0, high: 10 }, { y: 0, h: 3 });
  assert.ok(Number.isFinite(scale.y(5)));
});
