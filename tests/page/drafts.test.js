// Drafts on the timeline: which of them are one bar, which stand alone, and how places are named.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { server, ui } from '../../static/store/state.js';
import {
  boxFrameFor,
  draftAllLabel,
  draftedWords,
  draftMessage,
  draftTimeWords,
  restCount,
  draftRange,
  nobodyWords,
  personWords,
  placesWords,
  reasonOf,
  setDraftRange,
  smallWords,
  whyNotDraft,
} from '../../static/actions/drafting.js';
import { suggestedFrame } from '../../static/actions/playhead.js';
import { labelOf, whyNot } from '../../static/actions/actions.js';
import { draftStretches } from '../../static/timeline/marks/drafts.js';

test('drafts without a gap are one stretch, one or two stand alone', () => {
  const found = draftStretches([1, 2, 3, 4, 9, 20, 21, 30, 31, 32], []);
  assert.deepEqual(found, {
    stretches: [
      [1, 4],
      [30, 32],
    ],
    alone: [9, 20, 21],
  });
});

test('between keyframes the segment is shown, not the drafts', () => {
  const { stretches } = draftStretches([1, 2, 3, 5, 6, 7, 8], [{ first: 0, last: 4 }]);
  assert.deepEqual(stretches, [[5, 8]]);
});

test('a draft says which frames it found, and where nobody was', () => {
  const found = (last, many, missing) => ({
    latest: true,
    first: 0,
    last,
    drafted: many,
    behind: 0,
    missing,
    proposals: [],
  });
  assert.equal(draftedWords(found(179, 180, [])), 'Drafted 180 frames.');
  assert.equal(draftedWords(found(179, 149, [[0, 30]])), 'Drafted 31–179.');
  assert.equal(draftedWords(found(179, 170, [[170, 179]])), 'Drafted 0–169.');
  assert.equal(
    draftedWords(
      found(9, 7, [
        [3, 4],
        [6, 6],
      ]),
    ),
    'Drafted 7 of 10 frames.',
  );
  assert.equal(
    draftedWords({ ...found(179, 180, []), behind: 24 }),
    'Drafted 180 frames. The tracked motion is shown at 24 of them.',
  );
  assert.equal(
    draftedWords({ ...found(8, 9, []), behind: 9 }),
    'Drafted 9 frames. The tracked motion is shown at all of them.',
  );
  const reported = (...missing) => {
    server.draft = found(179, 100, missing);
    return nobodyWords();
  };
  assert.equal(reported(), '');
  assert.equal(reported([0, 30]), 'No person found in frames 0–30.');
  assert.equal(reported([61, 61]), 'No person found in frame 61.');
  assert.equal(reported([0, 30], [96, 96]), 'No person found in frames 0–30 and 96.');
  assert.equal(
    reported([0, 1], [3, 3], [5, 6], [8, 9], [11, 12]),
    'No person found in frames 0–1, 5–6, 8–9 and 2 more places.',
  );
  assert.equal(reported([0, 1], [3, 9], [170, 179]), 'No person found in frames 0–1, 3–9 and 170–179.');
  assert.equal(
    reported([0, 1], [3, 3], [6, 9], [12, 14], [20, 29]),
    'No person found in frames 6–9, 12–14, 20–29 and 2 more places.',
  );
});

test('a draft says where the person may change', () => {
  const reported = (...frames) => {
    server.draft = {
      proposals: [
        { frame: 3, reason: 'start', parts: [] },
        ...frames.map((frame) => ({ frame, reason: 'person', parts: [] })),
      ],
    };
    return personWords();
  };
  assert.equal(reported(), '');
  assert.equal(reported(96), 'The person may change at 96.');
  assert.equal(reported(96, 140), 'The person may change at 96 and 140.');
  assert.equal(reported(9, 30, 60, 96), 'The person may change at 9, 30, 60 and 1 more place.');
  assert.equal(reported(9, 30, 60, 96, 140), 'The person may change at 9, 30, 60 and 2 more places.');
});

test('a box is asked for in the middle of a gap, or where somebody was seen last', () => {
  const at = (...missing) => boxFrameFor({ first: 0, last: 99, missing });
  assert.equal(at([2, 4], [10, 34]), 22);
  assert.equal(at([2, 4], [50, 99]), 50);
  assert.equal(at([0, 49], [70, 71]), 49);
});

test('an animal is drafted by a network of animals, which has to be added', () => {
  const person = { id: 'thunder', chosen: true, of_animals: false, frame_s: 0.1 };
  const animals = { id: 'paws', chosen: false, of_animals: true, frame_s: 2 };
  Object.assign(server, { job: null, file: { frames: 100 }, view: { frame: 30 }, draft: null });
  ui.box = null;
  for (const [body, networks, words] of /** @type {[object, object[], string][]} */ ([
    [{ is_persons: true, is_animals: false }, [person], 'Draw a box around the person first'],
    [{ is_persons: false, is_animals: true }, [person, animals], 'Draw a box around the animal first'],
    [{ is_persons: false, is_animals: false }, [person, animals], 'Needs the body of a person, a dog or a horse'],
  ])) {
    Object.assign(server, { body, networks });
    assert.equal(whyNotDraft(), words);
  }
  Object.assign(server, { body: { is_animals: true }, networks: [person] });
  assert.match(whyNotDraft(), /^Needs a network of animals, added by “keypose models add NAME .* --animals”$/);
  server.networks = [person, animals];
  assert.match(draftTimeWords(100), /^Takes about 3 minutes\. Cancel keeps what is found by then\.$/);
  server.body = { is_persons: true };
  server.networks = [person];
});

test('a draft is of the frames that were chosen, and its box lies on one of them', () => {
  server.file = { frames: 100 };
  setDraftRange(20, 400);
  assert.deepEqual(draftRange(), [20, 99]);
  server.body = { is_persons: true };
  ui.box = [1, 2, 30, 90];
  server.view = { frame: 30 };
  assert.equal(whyNotDraft(), '');
  assert.deepEqual([draftMessage().first, draftMessage().last], [20, 99]);
  server.view = { frame: 7 };
  assert.equal(whyNotDraft(), 'The box must lie on one of the frames to draft, 20–99');
  setDraftRange(0, 99);
  assert.equal(ui.draftRange, null);
  assert.equal('first' in draftMessage(), false);
});

test('every reason is a sentence of its own', () => {
  const reasons = ['start', 'end', 'residual', 'hidden', 'flip', 'wrong', 'person', 'pose'];
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
  server.draft = { latest: true, first: 0, last: 99, drafted: 100, missing: [], proposals: [place(10), place(40)] };
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

test('how long it will take is said where it takes long and is known', () => {
  server.networks = [
    { id: 'a', chosen: false, frame_s: 9 },
    { id: 'b', chosen: true, frame_s: 0.16 },
  ];
  assert.equal(draftTimeWords(1500), 'Takes about 4 minutes. Cancel keeps what is found by then.');
  assert.match(draftTimeWords(250), /about 40 seconds/);
  assert.match(draftTimeWords(36000), /about 1.6 hours/);
  assert.equal(draftTimeWords(60), '');
  server.networks[1].frame_s = null;
  assert.equal(draftTimeWords(1500), '');
});

test('frames that a draft was cancelled before are left to draft, and no gap', () => {
  const draft = {
    latest: true,
    first: 0,
    last: 1499,
    drafted: 300,
    behind: 0,
    missing: [],
    rest: [[300, 1499]],
    proposals: [],
  };
  assert.equal(draftedWords(draft), 'Drafted 300 frames, 1200 are left.');
  Object.assign(server, { draft, job: null, body: { is_persons: true } });
  assert.equal(restCount(), 1200);
  assert.equal(labelOf('draftRest'), 'Draft the remaining 1200 frames');
  assert.equal(whyNot('draftRest'), '');
  const cancelled = (name, more = {}) => ({ name, posed: false, rest: 1200, ...more });
  server.bodies = [cancelled('Anna', { posed: true }), cancelled('Ben'), cancelled('Ball', { rest: 0 })];
  assert.equal(draftedWords(draft), 'Drafted 300 frames, 1200 are left of Anna and Ben.');
  server.bodies = [];
  server.draft = { ...draft, rest: [] };
  assert.equal(whyNot('draftRest'), 'No frames are left to draft');
});

test('everybody is drafted at once, two as both', () => {
  assert.deepEqual([0, 2, 3].map(draftAllLabel), ['Draft all people', 'Draft both people', 'Draft all 3 people']);
});
