// The pace of a gesture: at most once per animation frame or so many milliseconds, the newest wins,
// the end is never lost.

import { animationFrame } from './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { paced } from '../../static/controls/gesture.js';

let calls;
let call;

beforeEach(() => {
  calls = [];
  call = paced((...args) => calls.push(args));
});

test('nothing happens before the next animation frame, and then only the newest', () => {
  call(1, 'a');
  call(2, 'b');
  assert.deepEqual(calls, []);
  animationFrame();
  assert.deepEqual(calls, [[2, 'b']]);
});

test('every animation frame has one call at most, and none without a wish', () => {
  for (const frame of [1, 2, 3]) {
    call(frame);
    animationFrame();
  }
  animationFrame();
  assert.deepEqual(calls, [[1], [2], [3]]);
});

test('the end makes the last wish happen now, and only once', () => {
  call(1);
  call(2);
  call.flush();
  assert.deepEqual(calls, [[2]]);
  animationFrame();
  call.flush();
  assert.deepEqual(calls, [[2]]);
});

test('after the end it goes on as before', () => {
  call(1);
  call.flush();
  call(2);
  animationFrame();
  call(3);
  animationFrame();
  assert.deepEqual(calls, [[1], [2], [3]]);
});

test('a wish that arises while one happens waits for the next frame', () => {
  const again = paced((n) => {
    calls.push(n);
    if (n < 3) again(n + 1);
  });
  again(1);
  animationFrame();
  assert.deepEqual(calls, [1]);
  animationFrame();
  animationFrame();
  animationFrame();
  assert.deepEqual(calls, [1, 2, 3]);
});

test('what is dropped never happens', () => {
  call(1);
  call.drop();
  animationFrame();
  call.flush();
  assert.deepEqual(calls, []);
});

test('told once in so many milliseconds, the first happens at once and the newest is not lost', (t) => {
  t.mock.timers.enable({ apis: ['setTimeout'] });
  let now = 1000;
  t.mock.method(performance, 'now', () => now);
  call = paced((n) => calls.push([now, n]), 16);
  for (const n of [1, 2, 3]) call(n);
  assert.deepEqual(calls, [[1000, 1]]);
  now = 1016;
  t.mock.timers.tick(16);
  assert.deepEqual(calls, [
    [1000, 1],
    [1016, 3],
  ]);
  now = 1040;
  call(4);
  assert.deepEqual(calls.at(-1), [1040, 4]);
});
