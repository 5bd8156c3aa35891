// Frames across, pixels along: the timeline's scale, its zoom and its ruler.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server } from '../../static/store/state.js';
import * as clip from '../../static/store/clip.js';
import * as scale from '../../static/timeline/draw/scale.js';
import * as timeWindow from '../../static/actions/window.js';

const near = (actual, expected, within = 1e-9) =>
  assert.ok(Math.abs(actual - expected) <= within, `${actual} ≠ ${expected}`);

beforeEach(() => {
  server.file = { frames: 101 };
  scale.setWidth(scale.left() + 1000 + 26);
  timeWindow.showAll();
});

test('the whole clip reaches from the left end to the right one', () => {
  assert.equal(scale.x(0), scale.left());
  assert.equal(scale.x(100), scale.right());
  near(scale.pxPerFrame(), 10);
  assert.ok(!timeWindow.isZoomed());
});

test('a frame and its pixel lead to each other, zoomed or not', () => {
  for (const zoom of [() => {}, () => timeWindow.showFrames(30, 60)]) {
    zoom();
    for (const frame of [0, 29.5, 42, 100, 130]) near(scale.frameAt(scale.x(frame)), frame);
  }
});

test('the frame under the pointer stays there while one zooms', () => {
  const at = scale.x(40);
  scale.zoomAt(at, 2);
  assert.ok(timeWindow.isZoomed());
  near(scale.frameAt(at), 40);
  near(timeWindow.shown().last - timeWindow.shown().first, 50);
  scale.zoomAt(at, 1.5);
  near(scale.frameAt(at), 40);
});

test('zooming out as far as it goes shows everything', () => {
  timeWindow.showFrames(20, 40);
  scale.zoomAt(scale.x(30), 1 / 8);
  assert.ok(!timeWindow.isZoomed());
  assert.deepEqual(timeWindow.shown(), { first: 0, last: 100 });
});

test('no frame gets wider than 48 pixels, and the window keeps its middle', () => {
  timeWindow.showFrames(50, 51);
  near(scale.pxPerFrame(), 48);
  near((timeWindow.shown().first + timeWindow.shown().last) / 2, 50.5);
});

test('a window never leaves the clip', () => {
  timeWindow.showFrames(-20, 20);
  assert.deepEqual(timeWindow.shown(), { first: 0, last: 40 });
  timeWindow.showFrames(90, 130);
  assert.deepEqual(timeWindow.shown(), { first: 60, last: 100 });
  timeWindow.scrollBy(10);
  assert.deepEqual(timeWindow.shown(), { first: 60, last: 100 });
  timeWindow.scrollBy(-1000);
  assert.deepEqual(timeWindow.shown(), { first: 0, last: 40 });
  timeWindow.scrollBy(15);
  assert.deepEqual(timeWindow.shown(), { first: 15, last: 55 });
});

test('a frame that is not seen is scrolled into sight, and some further', () => {
  timeWindow.showFrames(0, 40);
  timeWindow.reveal(20, 0.25);
  assert.deepEqual(timeWindow.shown(), { first: 0, last: 40 });
  timeWindow.reveal(50, 0.25);
  assert.deepEqual(timeWindow.shown(), { first: 20, last: 60 });
  timeWindow.reveal(10, 0.25);
  assert.deepEqual(timeWindow.shown(), { first: 0, last: 40 });
});

test('where all is shown there is nothing to scroll to', () => {
  timeWindow.scrollBy(10);
  timeWindow.reveal(300, 0.5);
  assert.ok(!timeWindow.isZoomed());
});

test('a frame is kept within the clip and made whole', () => {
  assert.equal(clip.clampFrame(-3), 0);
  assert.equal(clip.clampFrame(41.6), 42);
  assert.equal(clip.clampFrame(900), 100);
});

test('a clip of one frame, and no clip, stand at the left end', () => {
  for (const file of [{ frames: 1 }, null]) {
    server.file = file;
    assert.equal(clip.lastFrame(), 0);
    assert.equal(scale.x(0), scale.left());
    assert.equal(clip.clampFrame(7), 0);
  }
});

test('the ruler steps by 1, 2 or 5 of a power of ten, the smallest that leaves room', () => {
  assert.equal(scale.rulerStep(10), 1);
  assert.equal(scale.rulerStep(11), 2);
  assert.equal(scale.rulerStep(50), 5);
  assert.equal(scale.rulerStep(51), 10);
  assert.equal(scale.rulerStep(150), 20);
  assert.equal(scale.rulerStep(201), 50);
});

test('pins have a row between the lanes and the curve, and a thin line beside the lane that stands alone', () => {
  const given = { height: 232, zoomed: false, lanes: 5, weakest: false };
  const without = scale.rowsFor({ ...given, height: 204 });
  const rows = scale.rowsFor({ ...given, pins: true });
  assert.equal(without.pins, null);
  assert.equal(rows.pins.h, 30);
  assert.ok(rows.pins.y >= rows.lanes.y + rows.lanes.room);
  assert.ok(rows.curve.y >= rows.pins.y + rows.pins.h);
  assert.ok(Math.abs(rows.curve.h - without.curve.h) < 5, 'the curve keeps its height in a timeline 28 px higher');
  const folded = scale.rowsFor({ ...given, height: 148, lanes: 1, weakest: true, pins: true });
  assert.equal(folded.pins.h, 3);
  assert.ok(folded.curve.y > folded.pins.y + folded.pins.h);
});

test('the camera has its row between keyframes and lanes, also in a low timeline', () => {
  for (const [height, lanes, weakest] of [
    [240, 5, false],
    [148, 1, true],
    [232, 0, false],
  ]) {
    const rows = scale.rowsFor({ height, zoomed: false, lanes, weakest, pins: true, camera: true });
    assert.equal(rows.camera.y, rows.keys.y + rows.keys.h);
    assert.ok(rows.camera.h >= 16);
    assert.ok(rows.lanes.y >= rows.camera.y + rows.camera.h);
    assert.ok(rows.pins.y >= rows.camera.y + rows.camera.h);
    assert.equal(scale.rowsFor({ height, zoomed: false, lanes, weakest, pins: true }).camera, null);
  }
});

test('pins have their row also where there are no lanes yet', () => {
  const rows = scale.rowsFor({ height: 232, zoomed: false, lanes: 0, weakest: false, pins: true });
  assert.ok(rows.pins.y >= rows.keys.y + rows.keys.h);
  assert.ok(rows.curve.y >= rows.pins.y + rows.pins.h);
});
