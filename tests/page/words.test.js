// Numbers and times as the page says them.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import * as words from '../../static/controls/words.js';

const NOON = new Date(2026, 4, 13, 12).getTime() / 1000; // a Wednesday
const [MINUTE, HOUR, DAY] = [60, 3600, 86400];

test('one is singular, all else plural', () => {
  assert.equal(words.count(1, 'keyframe'), '1 keyframe');
  assert.equal(words.count(0, 'keyframe'), '0 keyframes');
  assert.equal(words.joined(['a']), 'a');
  assert.equal(words.joined(['a', 'b', 'c']), 'a, b and c');
});

test('sizes go in steps of a thousand', () => {
  assert.equal(words.bytes(999), '999 B');
  assert.equal(words.bytes(999_500), '1.0 MB');
  assert.equal(words.bytes(4_210_000), '4.2 MB');
  assert.equal(words.bytes(48_000_000), '48 MB');
});

test('how long ago something was saved', () => {
  assert.equal(words.shortAgo(NOON + 5, NOON), '0 s ago'); // clocks differ
  assert.equal(words.shortAgo(NOON - 59, NOON), '59 s ago');
  assert.equal(words.shortAgo(NOON - 5 * MINUTE, NOON), '5 min ago');
  assert.equal(words.shortAgo(NOON - 3 * HOUR, NOON), '3 h ago');
  assert.match(words.shortAgo(NOON - 2 * DAY, NOON), /^on 11 May/);
});

test('when a session was last open, by the days of the calendar', () => {
  assert.equal(words.longAgo(NOON - 10, NOON), 'Just now');
  assert.equal(words.longAgo(NOON - 2 * MINUTE, NOON), '2 min ago');
  assert.equal(words.longAgo(NOON - 11 * HOUR, NOON), '11 h ago');
  assert.equal(words.longAgo(NOON - 13 * HOUR, NOON), 'Yesterday');
  assert.equal(words.longAgo(NOON - 2 * DAY, NOON), 'Monday');
  assert.match(words.longAgo(NOON - 9 * DAY, NOON), /^4 May/);
});

test('an error in the picture and, where that is known, in space', () => {
  assert.equal(words.roughError(6.84, 3.16), '≈ 6.8 px · 3.2 cm');
  assert.equal(words.roughError(14.2, null), '≈ 14 px');
  assert.equal(words.roughError(0.49, 0.2), 'under 0.5 px');
  assert.equal(words.roughError(0.5, 0.04), '≈ 0.5 px · 0.0 cm');
});
