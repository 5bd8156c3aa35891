// Tracking ahead: what is sent, and why it cannot begin.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server } from '../../static/store/state.js';
import { ACTIONS } from '../../static/actions/table.js';
import { beyondKeys, isUnderWay, noMotionYet, whyNotAhead } from '../../static/actions/tracking.js';

beforeEach(() =>
  Object.assign(server, { file: { frames: 73 }, job: null, keys: { frames: [24], drafts: [], soft: [] } }),
);

test('one keyframe is enough, in either direction', () => {
  assert.equal(whyNotAhead('forward'), '');
  assert.equal(whyNotAhead('backward'), '');
  assert.deepEqual(ACTIONS.trackAhead.message(), { do: 'track_ahead', direction: 'forward' });
  assert.deepEqual(ACTIONS.trackBack.message(), { do: 'track_ahead', direction: 'backward' });
});

test('where it leads nowhere the button says why', () => {
  server.keys.frames = [];
  assert.equal(whyNotAhead('forward'), 'Add a keyframe first');
  server.keys.frames = [0, 72];
  assert.equal(whyNotAhead('forward'), 'The keyframe at 72 is the last frame');
  assert.equal(whyNotAhead('backward'), 'The keyframe at 0 is the first frame');
  server.keys.frames = [24];
  server.job = { state: 'running', kind: 'ahead' };
  assert.equal(whyNotAhead('forward'), 'Tracking ahead already');
});

test('a frame beyond all keyframes has no motion until it is tracked ahead', () => {
  Object.assign(server, { keys: { frames: [24, 48] }, pose: { source: 'held' }, view: { frame: 60 } });
  assert.equal(beyondKeys(), 'forward');
  assert.equal(noMotionYet('forward'), 'Frames 49–72 have no motion yet');
  server.view.frame = 10;
  assert.equal(beyondKeys(), 'backward');
  assert.equal(noMotionYet('backward'), 'Frames 0–23 have no motion yet');
  server.pose.source = 'draft';
  assert.equal(beyondKeys(), null);
});

test('nobody is asked for what is being done: not for a box while frames are drafted', () => {
  const suggested = { kind: 'pose' };
  assert.equal(isUnderWay(suggested), false);
  server.job = { state: 'running', kind: 'draft' };
  assert.equal(isUnderWay(suggested), true);
  assert.equal(isUnderWay({ kind: 'key' }), false);
  server.job = { state: 'done', kind: 'draft' };
  assert.equal(isUnderWay(suggested), false);
});
