// In and out points, and what playing keeps.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import * as playing from '../../static/actions/playing.js';
import { WHILE_PLAYING, BY_CHORD } from '../../static/actions/actions.js';
import { server, ui } from '../../static/store/state.js';
import { span as mark } from '../../static/timeline/marks/span.js';
import * as scale from '../../static/timeline/draw/scale.js';

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 101, id: 'a', path: '/a' },
    view: { frame: 30 },
    keys: { frames: [], drafts: [] },
  });
  playing.clearSpan();
  Object.assign(ui, { playing: false, shuttle: 1, speed: 1 });
  scale.setWidth(scale.left() + 1000 + 26);
});

test('an end beyond the other takes its place', () => {
  playing.setIn(20);
  playing.setOut(60);
  assert.deepEqual(ui.span, { first: 20, last: 60 });
  playing.setIn(70);
  assert.deepEqual(ui.span, { first: 70, last: null });
  playing.setOut(10);
  assert.deepEqual(ui.span, { first: null, last: 10 });
});

test('a dragged end stops before the other and within the film', () => {
  const span = { first: 20, last: 60 };
  assert.deepEqual(playing.withEndDragged(span, 'first', 90), { first: 59, last: 60 });
  assert.deepEqual(playing.withEndDragged(span, 'last', 3), { first: 20, last: 21 });
  assert.deepEqual(playing.withEndDragged(span, 'last', 999), { first: 20, last: 100 });
});

test('what another film or a person wrote into the browser is read as far as it fits', () => {
  assert.deepEqual(playing.readable({ first: 20, last: 60 }, 100), { first: 20, last: 60 });
  assert.deepEqual(playing.readable({ first: 20, last: 600 }, 100), { first: 20, last: null });
  for (const wrong of [undefined, null, 'x', { first: 'a', last: -1 }, { first: 1.5 }]) {
    assert.deepEqual(playing.readable(wrong, 100), { first: null, last: null });
  }
});

test('brackets are grabbed outside their frames, where the playhead is not', () => {
  const spanEndAt = (place) => mark.hit(place)?.end ?? null;
  playing.keepSpan({ first: 20, last: 60 });
  assert.equal(spanEndAt({ x: scale.x(20) - 4, y: 10 }), 'first');
  assert.equal(spanEndAt({ x: scale.x(20) + 4, y: 10 }), null);
  assert.equal(spanEndAt({ x: scale.x(60) + 4, y: 10 }), 'last');
  assert.equal(spanEndAt({ x: scale.x(60) + 4, y: 40 }), null);
});

test('J turns it backward, then faster; L forward again; the words tell how fast', () => {
  playing.playBack();
  assert.deepEqual([ui.playing, ui.shuttle, playing.rateWords()], [true, -1, '−1×']);
  playing.playSlower();
  assert.equal(playing.rateWords(), '−2×');
  playing.playFaster();
  playing.playFaster();
  assert.equal(playing.rateWords(), '1×');
  ui.speed = 0.25;
  playing.playFaster();
  assert.equal(playing.rateWords(), '0.5×');
});

test('J, K and L shuttle while it plays, and mean what they ever did while nothing does', () => {
  assert.deepEqual(
    ['J', 'K', 'L'].map((key) => WHILE_PLAYING.get(key)),
    ['playSlower', 'stopPlaying', 'playFaster'],
  );
  assert.deepEqual([BY_CHORD.get('K').id, BY_CHORD.get('L').id], ['addKeyframe', 'live']);
});
