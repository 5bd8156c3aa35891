// Playing keeps time: which frame is due is told by the clock alone.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { changedAt, dueAt, framesAhead, rangeToPlay, shuttled } from '../../static/views/clock.js';

const run = (more = {}) => ({
  from: 0,
  began: 1000,
  rate: 1,
  first: 0,
  last: 59,
  loops: false,
  fps: 30,
  times: null,
  ...more,
});
const frameIn = (one, seconds) => dueAt(one, 1000 + seconds * 1000).frame;
const NO_SPAN = { first: null, last: null };

test('the frame due follows the clock, whatever was shown before', () => {
  assert.equal(frameIn(run(), 0), 0);
  assert.equal(frameIn(run(), 0.034), 1);
  assert.equal(frameIn(run(), 1), 30);
  assert.equal(frameIn(run({ from: 10 }), 1), 40);
  assert.equal(dueAt(run(), 0).frame, 0);
});

test('every speed takes its own time', () => {
  for (const [rate, frame] of [
    [0.1, 3],
    [0.25, 7],
    [0.5, 15],
    [1, 30],
    [2, 59],
  ]) {
    assert.equal(frameIn(run({ rate }), rate === 2 ? 0.99 : 1), frame, rate);
  }
});

test('the last frame is seen as long as any other, and then it is over', () => {
  assert.deepEqual(dueAt(run({ from: 58 }), 1000 + 65), { frame: 59, lap: 0, over: false });
  assert.deepEqual(dueAt(run({ from: 58 }), 1000 + 67), { frame: 59, lap: 0, over: true });
});

test('a loop begins anew without losing time', () => {
  const loop = run({ first: 10, last: 19, from: 15, loops: true });
  const seen = Array.from({ length: 30 }, (_, i) => dueAt(loop, 1000 + ((i + 0.5) * 1000) / 30));
  assert.deepEqual(
    seen.slice(0, 8).map(({ frame }) => frame),
    [15, 16, 17, 18, 19, 10, 11, 12],
  );
  assert.deepEqual([seen[4].lap, seen[5].lap, seen[15].lap, seen[25].lap], [0, 1, 2, 3]);
  assert.equal(dueAt(loop, 1000 + 3600_000).over, false);
});

test('into a loop from before it, and round from then on', () => {
  const loop = run({ first: 10, last: 19, from: 5, loops: true });
  assert.equal(frameIn(loop, 9.5 / 30), 14);
  assert.equal(frameIn(loop, 15.5 / 30), 10);
});

test('backward it goes as fast, and ends at the first', () => {
  const back = run({ from: 30, rate: -1 });
  assert.equal(frameIn(back, 0), 30);
  assert.equal(frameIn(back, 0.5 / 30), 30);
  assert.equal(frameIn(back, 1.5 / 30), 29);
  assert.equal(frameIn(back, 30.5 / 30), 0);
  assert.deepEqual(dueAt(back, 1000 + 31_000 / 30), { frame: 0, lap: 0, over: true });
  assert.equal(frameIn(run({ first: 10, last: 19, from: 10, rate: -2, loops: true }), 0.75 / 30), 19);
});

test('frames of a varying rate stay as long as they were filmed', () => {
  const times = [5, 5.1, 5.2, 6.2, 6.3];
  const some = run({ times, last: 4, fps: 10 });
  assert.deepEqual(
    [0, 0.1, 0.25, 1.1, 1.2, 1.35].map((s) => frameIn(some, s)),
    [0, 1, 2, 2, 3, 4],
  );
  assert.deepEqual(
    [0.05, 0.15, 0.9, 1.15].map((s) => frameIn({ ...some, from: 3, rate: -1 }, s)),
    [3, 2, 2, 1],
  );
});

test('another speed goes on from the frame that was due', () => {
  const later = changedAt(run(), 2000, { rate: 0.5 });
  assert.deepEqual([later.from, later.began], [30, 2000]);
  assert.equal(dueAt(later, 3000).frame, 45);
});

test('pictures are fetched ahead in the way it goes, round a loop, and no more than are shown', () => {
  assert.deepEqual(framesAhead(run({ last: 12 }), 10, 5), [11, 12]);
  assert.deepEqual(framesAhead(run({ first: 8, last: 12, loops: true }), 11, 4), [12, 8, 9, 10]);
  assert.deepEqual(framesAhead(run({ rate: -1 }), 2, 5), [1, 0]);
  assert.deepEqual(framesAhead(run({ rate: 4, fps: 60 }), 10, 4), [12, 16, 20, 24]);
  assert.deepEqual(framesAhead(run({ rate: 4, fps: 60, last: 21 }), 10, 9), [12, 16, 20, 21]);
  assert.deepEqual(framesAhead(run({ first: 4, last: 5, loops: true }), 4, 9), [5, 4]);
});

test('what is played ends where keyframes end', () => {
  const here = { lastFrame: 100, keys: [10, 40, 80], span: NO_SPAN };
  assert.deepEqual(rangeToPlay({ ...here, at: 0 }), { first: 10, last: 80, from: 0 });
  assert.deepEqual(rangeToPlay({ ...here, at: 50 }), { first: 10, last: 80, from: 50 });
  assert.deepEqual(rangeToPlay({ ...here, at: 80 }), { first: 10, last: 80, from: 10 });
  assert.deepEqual(rangeToPlay({ ...here, at: 90 }), { first: 10, last: 100, from: 90 });
  assert.deepEqual(rangeToPlay({ ...here, at: 100 }), { first: 10, last: 80, from: 10 });
  assert.deepEqual(rangeToPlay({ ...here, keys: [], at: 30 }), { first: 0, last: 100, from: 30 });
});

test('an in and an out point go before keyframes, and one from outside begins at the in point', () => {
  const here = { lastFrame: 100, keys: [10, 40, 80], span: { first: 20, last: 30 } };
  assert.deepEqual(rangeToPlay({ ...here, at: 25 }), { first: 20, last: 30, from: 25 });
  assert.deepEqual(rangeToPlay({ ...here, at: 30 }), { first: 20, last: 30, from: 20 });
  assert.deepEqual(rangeToPlay({ ...here, at: 5 }), { first: 20, last: 30, from: 20 });
  assert.deepEqual(rangeToPlay({ ...here, at: 5, way: -1 }), { first: 20, last: 30, from: 30 });
  assert.deepEqual(rangeToPlay({ ...here, span: { first: 20, last: null }, at: 90 }), {
    first: 20,
    last: 100,
    from: 90,
  });
});

test('backward it plays to the first keyframe, and from there anew from the last', () => {
  const here = { lastFrame: 100, keys: [10, 40, 80], span: NO_SPAN, way: -1 };
  assert.equal(rangeToPlay({ ...here, at: 10 }).from, 80);
  assert.deepEqual(rangeToPlay({ ...here, at: 5 }), { first: 0, last: 80, from: 5 });
  assert.equal(rangeToPlay({ ...here, at: 0 }).from, 80);
});

test('L goes faster, J slower and then backward', () => {
  assert.deepEqual(
    [1, 2, 4, -1].map((rate) => shuttled(rate, 1)),
    [2, 4, 4, 1],
  );
  assert.deepEqual(
    [4, 1, -1, -4].map((rate) => shuttled(rate, -1)),
    [2, -1, -2, -4],
  );
});
