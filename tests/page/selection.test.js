// Selecting keyframes on the timeline, and what is sent for all of them.

import { animationFrame } from './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { labelOf, whyNot } from '../../static/actions/actions.js';
import * as selection from '../../static/actions/selection.js';
import { server, ui } from '../../static/store/state.js';
import { selection as mark } from '../../static/timeline/marks/selection.js';
import * as scale from '../../static/timeline/draw/scale.js';

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 101, path: '/a' },
    view: { frame: 0 },
    keys: { frames: [0, 20, 40, 100], drafts: [], soft: [] },
    done: 1e9,
  });
  Object.assign(ui, { toasts: [], timeGrabbed: null });
  selection.selectKeys([]);
  selection.chooseOnly(0);
  scale.setWidth(scale.left() + 1000 + 26);
});

const at = (frame) => scale.x(frame);
const gripNear = (px) => mark.hit({ x: px })?.end ?? null;

test('Shift selects from the keyframe clicked before, Ctrl one more, which counts that one', () => {
  selection.chooseOnly(0);
  selection.extendTo(40);
  assert.deepEqual(selection.selectedKeys(), [0, 20, 40]);
  selection.toggleKey(20);
  assert.deepEqual(selection.selectedKeys(), [0, 40]);
  selection.chooseOnly(0);
  selection.toggleKey(40);
  assert.deepEqual(selection.selectedKeys(), [0, 40], 'the one the playhead stands on was clicked first');
});

test('Shift without a click before selects from the playhead', () => {
  selection.chooseOnly(7);
  server.view.frame = 20;
  selection.extendTo(100);
  assert.deepEqual(selection.selectedKeys(), [20, 40, 100]);
});

test('where no keyframe stands any more nothing is selected', () => {
  selection.selectAll();
  server.keys = { frames: [0, 40], drafts: [] };
  assert.deepEqual(selection.selectedKeys(), [0, 40]);
});

test('the selection is deleted as one, a named keyframe alone', () => {
  assert.equal(labelOf('deleteKeyframe'), 'Delete keyframe');
  selection.selectBetween(10, 50);
  assert.equal(labelOf('deleteKeyframe'), 'Delete 2 keyframes');
  assert.equal(labelOf('deleteKeyframe', 100), 'Delete keyframe');
  server.view.frame = 3;
  assert.equal(whyNot('deleteKeyframe'), '');
  selection.clearSelection();
  assert.equal(whyNot('deleteKeyframe'), 'Frame 3 is not a keyframe');
});

test('without a keyframe a draft is what is deleted', () => {
  server.keys = { frames: [0, 20], drafts: [3, 20] };
  server.view.frame = 3;
  assert.equal(labelOf('deleteKeyframe'), 'Delete draft');
  assert.equal(whyNot('deleteKeyframe'), '');
  assert.equal(labelOf('deleteKeyframe', 20), 'Delete keyframe');
  selection.selectKeys([0, 20]);
  assert.equal(labelOf('deleteKeyframe'), 'Delete 2 keyframes');
});

test('the selection moves with keys until something is in the way, which is named', () => {
  assert.equal(whyNot('later'), 'Select keyframes first: drag a box over them');
  selection.selectKeys([0, 20]);
  assert.equal(whyNot('later'), '');
  assert.equal(whyNot('earlier'), 'The selection reaches the first frame');
  selection.selectKeys([39, 40].filter((frame) => server.keys.frames.includes(frame)));
  server.keys = { frames: [0, 40, 41], drafts: [] };
  selection.selectKeys([40]);
  assert.equal(whyNot('later'), 'Frame 41 is already a keyframe');
});

test('the grips of a selection stand beside its ends; a keyframe is nearer to its own middle', () => {
  selection.selectKeys([20, 40]);
  assert.equal(gripNear(at(20) - 10), 'first');
  assert.equal(gripNear(at(40) + 10), 'last');
  assert.equal(gripNear(at(20)), null);
  assert.equal(gripNear(at(30)), null);
  selection.selectKeys([20]);
  assert.equal(gripNear(at(20) - 10), null, 'one keyframe cannot be stretched');
});

test('Esc lets go of the selection only where there is one', () => {
  assert.equal(selection.clearSelection(), false);
  selection.selectAll();
  assert.equal(selection.clearSelection(), true);
  animationFrame();
});
