// Drafts on the timeline: which of them are one bar, which stand alone, and how places are named.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { server, ui } from '../../static/store/state.js';
import { draftedWords, draftMessage, placesWords, reasonOf, smallWords } from '../../static/actions/drafting.js';
import { suggestedFrame } from '../../static/actions/playhead.js';
import { draftStretches } from '../../static/timeline/draw/drafts.js';

test('drafts without a gap are one stretch, one or two stand alone', () => {
  const found = draftStretches([1, 2, 3, 4, 9, 20, 21, 30, 31, 32], []);
  assert.deepEqual(found, { stretches: [[1, 4], [30, 32]], alone: [9, 20, 21] });
});

test('between keyframes the segment is shown, not the drafts', () => {
  const { stretches } = draftStretches([1, 2, 3, 5, 6, 7, 8], [{ first: 0, last: 4 }]);
  assert.deepEqual(stretches, [[5, 8]]);
});

test('a draft says how many frames it found', () => {
  assert.equal(draftedWords({ latest: true, first: 0, last: 179, missing: [], proposals: [] }), 'Drafted 180 frames.');
  const some = { latest: true, first: 0, last: 9, missing: [3, 4], proposals: [] };
  assert.equal(draftedWords(some), 'Drafted 8 of 10 frames.');
});

test('every reason is a sentence of its own', () => {
  const reasons = ['start', 'end', 'residual', 'hidden', 'flip', 'person'];
  const said = reasons.map((reason) => reasonOf({ frame: 1, reason, parts: ['Left shin'] }));
  assert.equal(new Set(said).size, reasons.length);
  for (const words of said) assert.match(words, /^[A-Z]/);
  assert.equal(said[3], 'Left shin hidden');
  const several = { frame: 1, reason: 'hidden', parts: ['Left shin', 'Left foot', 'Head'] };
  assert.equal(reasonOf(several), 'Left shin and 2 more parts hidden');
});

test('the next place is the first after the playhead, then the first of all', () => {
  server.file = { frames: 100 };
  const place = (frame) => ({ frame, reason: 'hidden', parts: [] });
  server.draft = { latest: true, first: 0, last: 99, missing: [], proposals: [place(10), place(40)] };
  const after = (frame) => {
    server.view = { ...server.view, frame };
    return suggestedFrame();
  };
  assert.deepEqual([0, 10, 12, 40, 90].map(after), [10, 40, 40, 10, 10]);
  assert.equal(placesWords(), '2 places to confirm');
});

test('the box is sent to a tenth of a pixel with the frame it lies on', () => {
  ui.box = [10.04, 20.26, 30, 80];
  assert.deepEqual(draftMessage().box, [10, 20.3, 30, 80]);
  assert.equal(smallWords(), '');
  ui.box = [10, 20, 30, 62];
  assert.match(smallWords(), /42 px/);
});
