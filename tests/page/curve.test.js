// The curve of the selected part: which axis, on which scale, which of its keys is at a place.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server, ui } from '../../static/store/state.js';
import * as curve from '../../static/timeline/draw/curve.js';
import { curveKey } from '../../static/timeline/marks/curve_keys.js';
import * as scale from '../../static/timeline/draw/scale.js';

const ROW = { y: 0, h: 112 };

beforeEach(() => {
  server.file = { frames: 11 };
  server.body = {
    parts: [
      { name: 'shin', tracked: ['tx', 'rz'] },
      { name: 'foot', tracked: [] },
    ],
  };
  server.curve = {
    part: 'shin',
    x: Array(11).fill(null),
    y: [0, ...Array(9).fill(null), 40],
    z: [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100],
    error: Array(11).fill(0),
  };
  server.keys = { frames: [0, 10], drafts: [] };
  ui.curveAxis = undefined;
  curve.freezeRange(false);
  scale.setWidth(scale.left() + 1000 + 26);
});

test('the axis is the chosen one, else the first that is tracked, else x', () => {
  assert.equal(curve.axis(), 'z');
  curve.chooseAxis('y');
  assert.equal(curve.axis(), 'y');
  ui.curveAxis = undefined;
  server.curve = { ...server.curve, part: 'foot' };
  assert.equal(curve.axis(), 'x');
});

test('one value alone is no curve, two are', () => {
  assert.ok(curve.hasCurve());
  const none = Array(11).fill(null);
  server.curve = { ...server.curve, y: none, z: [5, ...none.slice(1)] };
  assert.ok(!curve.hasCurve());
  server.curve = null;
  assert.ok(!curve.hasCurve());
});

test('a frame without a value has none', () => {
  assert.equal(curve.valueAt(3), 30);
  assert.equal(curve.valueAt(30), null);
  curve.chooseAxis('y');
  assert.equal(curve.valueAt(3), null);
  assert.equal(curve.valueAt(0), 0);
});

test('while a key is dragged the scale stands still, and moves again afterwards', () => {
  const before = curve.scale(ROW).y(100);
  curve.freezeRange(true);
  server.curve = { ...server.curve, z: server.curve.z.map((value) => 3 * value) };
  assert.equal(curve.scale(ROW).y(100), before);
  curve.freezeRange(false);
  assert.notEqual(curve.scale(ROW).y(100), before);
});

test('a key of the curve is found where its diamond is, and not beside it', () => {
  const keyNear = (row, px, py) => curveKey.hit({ x: px, y: py }, { rows: { curve: row } })?.frame ?? null;
  const [x, y] = [scale.x(10), curve.scale(ROW).y(100)];
  assert.equal(keyNear(ROW, x, y), 10);
  assert.equal(keyNear(ROW, x - 9, y + 9), 10);
  assert.equal(keyNear(ROW, x - 10, y), null);
  assert.equal(keyNear(ROW, x, y + 10), null);
  assert.equal(keyNear(ROW, scale.x(5), curve.scale(ROW).y(50)), null); // no key
  assert.equal(keyNear(null, x, y), null);
});

test('there is an error to show where any is above nothing', () => {
  assert.ok(!curve.hasError());
  server.curve = { ...server.curve, error: [...Array(10).fill(null), 0.5] };
  assert.ok(curve.hasError());
});
