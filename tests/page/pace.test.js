// The pace of a gesture: at most once per animation frame, the newest wins, the end is never lost.

import { animationFrame } from './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { paced } from '../../static/timeline/edit/pace.js';

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
