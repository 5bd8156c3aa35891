// The window of a view: its plane and the screen lead to each other.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Window } from '../../static/views/windows.js';

function windowOf(width, height) {
  const made = new Window();
  made.resize(width, height);
  return made;
}

const near = (actual, expected) =>
  actual.forEach((value, i) => assert.ok(Math.abs(value - expected[i]) < 1e-9, `${actual} ≠ ${expected}`));

test('a box is shown whole, in the middle of the room there is', () => {
  const made = windowOf(400, 300);
  made.showBox([0, 0, 100, 50], { x: 20, top: 60, bottom: 0 });
  assert.equal(made.scale, 3.6);
  near(made.fromPlane([50, 25]), [200, 180]);
  assert.ok(made.holds([0, 0, 100, 50]));
  assert.ok(!made.chosen);
});

test('a point of the plane and its pixel lead to each other', () => {
  const made = windowOf(400, 300);
  made.showBox([-3, 2, 8, 5]);
  made.zoomAt(70, 200, 1.7);
  made.panBy(-40, 12);
  near(made.toPlane(made.fromPlane([1.5, 3.25])), [1.5, 3.25]);
});

test('what is under the pointer stays there while one zooms', () => {
  const made = windowOf(400, 300);
  made.showBox([0, 0, 10, 10]);
  const before = made.toPlane([90, 40]);
  made.zoomAt(90, 40, 2.5);
  near(made.toPlane([90, 40]), before);
  assert.ok(made.chosen);
});

test('what is dragged follows the pointer', () => {
  const made = windowOf(400, 300);
  made.showBox([0, 0, 10, 10]);
  const held = made.toPlane([100, 100]);
  made.panBy(30, -20);
  near(made.fromPlane(held), [130, 80]);
});

test('the scale stays within its limits', () => {
  const made = windowOf(400, 300);
  made.limit(0.5, 4);
  made.zoomAt(0, 0, 1000);
  assert.equal(made.scale, 4);
  made.zoomAt(0, 0, 1e-6);
  assert.equal(made.scale, 0.5);
  made.showBox([0, 0, 1, 1], undefined, 2);
  assert.equal(made.scale, 2);
});

test('a box is wholly on the screen, partly, or not at all', () => {
  const made = windowOf(100, 100);
  made.showBox([0, 0, 100, 100]);
  assert.ok(made.holds([10, 10, 90, 90]) && made.touches([10, 10, 90, 90]));
  assert.ok(!made.holds([50, 50, 150, 90]) && made.touches([50, 50, 150, 90]));
  assert.ok(!made.touches([120, 10, 150, 90]));
});
