// Several bodies: with which of them one goes on, and what is said of it.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { whyNot } from '../../static/actions/actions.js';
import { bodyAhead, leftToDo, posedWords } from '../../static/actions/bodies.js';
import { apartWords } from '../../static/inspector/bonds.js';
import { server } from '../../static/store/state.js';

const GOOD = { first: 0, last: 20, state: 'good' };
const CHECK = { first: 20, last: 40, state: 'check' };
const body = (id, more = {}) => ({ id, posed: false, places: [], segments: [GOOD], open: 0, worst: 'good', ...more });

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 100 },
    view: { frame: 0 },
    keys: { frames: [0, 20], drafts: [] },
    draft: null,
    suggest: { kind: 'good', frame: null },
    bodies: [body('ann', { posed: true }), body('bo')],
  });
});

const beside = (more) => (server.bodies = [server.bodies[0], body('bo', more)]);

test('where all are good there is none to go on with', () => {
  assert.equal(bodyAhead(), undefined);
  assert.equal(whyNot('suggestedFrame'), 'No frame is suggested');
});

const WAITING = [
  [{ places: [3, 9] }, '2 places to confirm'],
  [{ open: 1, worst: null, segments: [{ ...GOOD, state: 'none' }] }, '1 segment to track'],
  [{ worst: 'check', segments: [GOOD, CHECK] }, '1 segment to check'],
  [{ worst: 'lost', segments: [{ ...GOOD, state: 'lost' }, CHECK] }, '1 segment lost'],
];

for (const [state, words] of WAITING) {
  test(`it is gone on with where it has ${words}, once the posed one is good`, () => {
    beside(state);
    assert.equal(leftToDo(bodyAhead()), words);
    assert.equal(whyNot('suggestedFrame'), '');
    server.draft = { proposals: [{ frame: 7 }] };
    assert.equal(bodyAhead(), undefined, 'its own places come first');
  });
}

test('a draft of another is confirmed before the posed one is tracked', () => {
  server.suggest = { kind: 'track', frame: null };
  beside({ open: 1, worst: null });
  assert.equal(bodyAhead(), undefined);
  beside({ places: [3] });
  assert.equal(bodyAhead().id, 'bo');
});

test('a hold whose points are apart says why, and what to do', () => {
  const apart = { apart_cm: 8, worst: 20, unposed: null };
  assert.deepEqual(
    ['untracked', 'tracked', 'keyed'].map((cause) => apartWords({ ...apart, cause })),
    [
      '8.0 cm apart at frame 20 until it is tracked',
      '8.0 cm apart at frame 20, held apart by their keyframes: pose them together there',
      '8.0 cm apart at frame 20, where both are keyed: pose them together there',
    ],
  );
  assert.equal(apartWords({ ...apart, cause: 'unposed', unposed: 'Ball' }), 'Ball has no keyframe yet: pose it first');
});

test('a body says its keyframes, and its drafts where it has any', () => {
  assert.equal(posedWords({ keys: [4], drafts: 0 }), '1 keyframe');
  assert.equal(posedWords({ keys: [], drafts: 0 }), '0 keyframes');
  assert.equal(posedWords({ keys: [], drafts: 100 }), '100 drafts');
  assert.equal(posedWords({ keys: [4, 9], drafts: 1 }), '2 keyframes, 1 draft');
});
