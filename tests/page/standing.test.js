// When the motion can be stood on its floor, and what drafting anew says that it changes.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server } from '../../static/store/state.js';
import * as standing from '../../static/actions/standing.js';

const foot = { name: 'left_foot', landmarks: ['left_toe', 'left_heel'] };
const hand = { name: 'left_hand', landmarks: [] };

beforeEach(() => {
  Object.assign(server, {
    surface: null,
    camera: { up_origin: 'drawn', tilt_deg: -12.2, roll_deg: 1.8, lifts: null },
    draft: null,
    body: { parts: [foot, hand] },
    segments: [{ state: 'good' }],
    settings: { method: 'keypose' },
  });
});

const CANNOT = [
  [{ surface: {} }, /surfaces/],
  [{ settings: { method: 'paper' } }, /no pins/],
  [{ body: { parts: [hand] } }, /no feet/],
  [{ segments: [{ state: 'none' }] }, /Track first/],
];

test('standing is possible once something is tracked; else it is said why it is not', () => {
  assert.equal(standing.whyNotStand(), '');
  for (const [without, why] of CANNOT) {
    const before = { ...server };
    Object.assign(server, without);
    assert.match(standing.whyNotStand(), why);
    Object.assign(server, before);
  }
});

test('what drafting anew changes is named, and nothing of what it does not', () => {
  assert.match(standing.whyNotLift(), /no drafts/);
  server.draft = {};
  assert.match(standing.whyNotLift(), /as the up direction has them/);
  server.camera.lifts = { drafts: 280, keyframes: 6, segments: 5 };
  assert.equal(standing.whyNotLift(), '');
  assert.equal(
    standing.liftWords(),
    '280 drafts and 6 keyframes that nobody posed change; 5 segments are tracked anew',
  );
  server.camera.lifts = { drafts: 0, keyframes: 1, segments: 1 };
  assert.equal(standing.liftWords(), '1 keyframe that nobody posed changes; 1 segment is tracked anew');
});

test('what is up is known once somebody has said it', () => {
  assert.ok(standing.isUpKnown());
  assert.equal(standing.tiltWords(), 'Looks down by 12°, leans 2° to the left');
  server.camera.up_origin = 'camera';
  assert.ok(!standing.isUpKnown());
  server.camera = null;
  assert.ok(!standing.isUpKnown());
  assert.match(standing.whyNotFindUp(), /Open a video/);
});
