// What is done between the in and the out point, and says so.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { labelOf, titleOf, whyNot } from '../../static/actions/actions.js';
import { draftMessage, draftRange, setDraftRange } from '../../static/actions/drafting.js';
import { motionFrames, usualExport } from '../../static/actions/exporting.js';
import { places } from '../../static/actions/review.js';
import { changedSegments, trackMessage } from '../../static/actions/tracking.js';
import { server, ui } from '../../static/store/state.js';

const segment = (first, last) => ({ first, last, state: 'none' });

beforeEach(() => {
  Object.assign(server, {
    file: { name: 'walk', frames: 100 },
    view: { frame: 30, mode: 'both' },
    body: { is_persons: true },
    job: null,
    surface: null,
    keys: { frames: [0, 20, 40, 60], drafts: [] },
    segments: [segment(0, 20), segment(20, 40), segment(40, 60)],
    review: {
      goal: 5,
      goals: [5],
      places: [
        { id: '1', frame: 10, px: 9 },
        { id: '2', frame: 30, px: 9 },
      ],
    },
  });
  Object.assign(ui, { span: { first: 20, last: 50 }, box: [1, 2, 30, 90], draftRange: null, filterMotion: false });
});

const noSpan = () => (ui.span = { first: null, last: null });

test('frames are drafted', () => {
  assert.equal(labelOf('draft'), 'Draft 31 frames, 20–50');
  assert.deepEqual([draftMessage().first, draftMessage().last], [20, 50]);
  setDraftRange(0, 99);
  assert.deepEqual(draftRange(), [0, 99], 'chosen by hand it may be more');
  assert.equal(labelOf('draft'), 'Draft 100 frames');
  setDraftRange(20, 50);
  assert.equal(ui.draftRange, null);
});

test('segments are tracked, but for those that only meet it', () => {
  assert.deepEqual(
    changedSegments().map(({ first }) => first),
    [20, 40],
  );
  assert.deepEqual(trackMessage('all'), { do: 'track', what: 'all', first: 20, last: 50 });
  assert.equal(labelOf('trackAll'), 'Track all 2 segments, 20–50');
  assert.equal(labelOf('trackChanged'), 'Track changed segments, 20–50');
  ui.span = { first: 70, last: null };
  assert.match(whyNot('trackAll'), /No segment reaches between the in and the out point, 70–99/);
  assert.equal(whyNot('trackThis'), '', 'one of them can be tracked by itself');
  noSpan();
  assert.deepEqual(trackMessage('changed'), { do: 'track', what: 'changed' });
  assert.equal(labelOf('trackAll'), 'Track all 3 segments');
});

test('places are reviewed', () => {
  assert.deepEqual(
    places().map(({ frame }) => frame),
    [30],
  );
  assert.match(titleOf('review'), /within 20–50/);
  noSpan();
  assert.equal(places().length, 2);
});

test('films, motion and mattes are exported', () => {
  const { values } = usualExport();
  assert.deepEqual([values.film.frames, values.motion.frames, values.matte.frames], ['20-50', '20-50', '20-50']);
  ui.span = { first: 50, last: null };
  assert.deepEqual(motionFrames(), [50, 60], 'as far as there is motion');
  assert.equal(usualExport().values.matte.frames, '50-99');
  noSpan();
  assert.deepEqual([usualExport().values.film.frames, usualExport().values.matte.frames], ['0-60', '0-99']);
});
