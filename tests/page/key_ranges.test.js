// Ranges of keyframes: what is chosen, where they go when moved or stretched.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as ranges from '../../static/actions/selection.js';

const KEYS = [0, 12, 24, 48, 72];

test('a range is chosen from either end', () => {
  assert.deepEqual(ranges.between(KEYS, 12, 48), [12, 24, 48]);
  assert.deepEqual(ranges.between(KEYS, 50, 11), [12, 24, 48]);
  assert.deepEqual(ranges.between(KEYS, 13, 20), []);
});

test('one more is chosen, and one less, in the order of frames', () => {
  assert.deepEqual(ranges.toggled([12, 48], 24), [12, 24, 48]);
  assert.deepEqual(ranges.toggled([12, 24, 48], 24), [12, 48]);
  assert.deepEqual(ranges.joined([48], [12, 48]), [12, 48]);
});

test('a range moves as one and stops where the film does', () => {
  assert.deepEqual(ranges.shifted([12, 24], 10.4, 80), [22, 34]);
  assert.deepEqual(ranges.shifted([12, 24], -30, 80), [0, 12]);
  assert.deepEqual(ranges.shifted([12, 24], 99, 80), [68, 80]);
});

test('stretching scales about the other end', () => {
  assert.deepEqual(ranges.stretched([10, 20, 40], 'last', 70, 100), [10, 30, 70]);
  assert.deepEqual(ranges.stretched([10, 20, 40], 'first', 25, 100), [25, 30, 40]);
  assert.deepEqual(ranges.stretched([10, 20, 40], 'last', 999, 100), [10, 40, 100]);
  assert.deepEqual(ranges.stretched([10, 20, 40], 'first', -5, 100), [0, 13, 40]);
});

test('squeezed together frames stay distinct, in order and within their ends', () => {
  assert.deepEqual(ranges.stretched([0, 10, 20, 30], 'last', 1, 100), [0, 1, 2, 3]);
  assert.deepEqual(ranges.stretched([0, 10, 20, 30], 'first', 29, 100), [27, 28, 29, 30]);
  assert.deepEqual(ranges.stretched([0, 1, 2, 3, 100], 'last', 10, 100), [0, 1, 2, 3, 10]);
  assert.deepEqual(ranges.stretched([0, 97, 98, 99, 100], 'last', 10, 100), [0, 7, 8, 9, 10]);
});

test('every stretch of every range holds what it promises', () => {
  for (let n = 2; n < 7; n += 1) {
    const frames = Array.from({ length: n }, (_, i) => 5 + i * i + 2 * i);
    for (let to = 0; to < 80; to += 1) {
      for (const end of ['first', 'last']) {
        const there = ranges.stretched(frames, end, to, 60);
        const fixed = end === 'last' ? 0 : n - 1;
        assert.equal(there[fixed], frames[fixed]);
        assert.ok(
          there.every((at, i) => Number.isInteger(at) && at >= 0 && at <= 60 && (i === 0 || at > there[i - 1])),
          `${there}`,
        );
      }
    }
  }
});

test('stretching back gives nearly what was there, to the frame that rounding takes', () => {
  const frames = [0, 7, 20, 30];
  const back = ranges.stretched(ranges.stretched(frames, 'last', 60, 100), 'last', 30, 100);
  assert.deepEqual(back, frames);
});

test('what is met is told: keyframes that stay, and of copies also their own', () => {
  assert.deepEqual(ranges.met(KEYS, [12, 24], [24, 36]), []);
  assert.deepEqual(ranges.met(KEYS, [12, 24], [36, 48]), [48]);
  assert.deepEqual(ranges.met(KEYS, [12, 24], [24, 36], true), [24]);
  assert.equal(ranges.listed([12, 24]), '12 and 24');
  assert.equal(ranges.listed([1, 2, 3, 4, 5]), '1, 2 and 3 more');
});
