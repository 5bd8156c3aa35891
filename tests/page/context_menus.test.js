// Menus where the hand is: made of the table, with keys where these do the same, and reasons.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { CONTEXTS, contextEntries, menusWith } from '../../static/actions/context_menus.js';
import { ACTIONS } from '../../static/actions/table.js';
import { beginTyping, typedTo } from '../../static/controls/menu.js';
import { server } from '../../static/store/state.js';

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 60 },
    view: { frame: 4, selected: null, mode: 'both' },
    keys: { frames: [0, 8], drafts: [] },
    body: {
      parts: [
        { name: 'left_hand', label: 'Left hand', parent: null, mirror: 'right_hand' },
        { name: 'head', label: 'Head', mirror: null },
      ],
      handles: [],
    },
    clipboard: false,
    notes: [{ frame: 8, text: 'here' }],
    segments: [],
    undo: { undo: null, redo: null },
    pins: [],
  });
});

const labelled = (entries) =>
  Object.fromEntries(entries.filter(({ label }) => label).map((entry) => [entry.label, entry]));

test('menus name actions of the table, and none twice', () => {
  for (const [name, { groups }] of Object.entries(CONTEXTS)) {
    const ids = groups.flat();
    for (const id of ids) assert.ok(id in ACTIONS, `${name}: ${id}`);
    assert.equal(new Set(ids).size, ids.length, name);
  }
});

test('what is not possible stays, with its reason in the place of the key', () => {
  const { Paste: paste, 'Add keyframe': add } = labelled(contextEntries('picture'));
  assert.deepEqual([paste.off, paste.right], ['Copy a pose first (Ctrl C)', 'Copy a pose first (Ctrl C)']);
  assert.deepEqual([add.off, add.right], ['', 'K']);
});

test('a keyframe is added or deleted, whichever fits the frame', () => {
  assert.ok('Add keyframe' in labelled(contextEntries('picture')));
  server.view = { ...server.view, frame: 8 };
  const menu = labelled(contextEntries('picture'));
  assert.ok('Delete keyframe' in menu && !('Add keyframe' in menu));
});

test('the menu of a part is about that part, whatever is selected', () => {
  const [hand, head] = server.body.parts;
  assert.equal(
    labelled(contextEntries('part', { otherSide: head, resetPart: head }))['Other side of the body'].off,
    'Head has no other side',
  );
  const menu = labelled(contextEntries('part', { otherSide: hand, resetPart: hand }));
  assert.deepEqual([menu['Other side of the body'].off, menu['Reset part'].off], ['', '']);
});

test('no key is shown where it would act at another frame', () => {
  assert.equal(labelled(contextEntries('frames', { goTo: 8, note: 8 }))['Edit note'].right, '');
  assert.equal(labelled(contextEntries('frames', { goTo: 4, note: 4 }))['Add note'].right, 'Shift M');
});

test('a keyframe’s pose is offered to other frames than its own', () => {
  assert.ok('Copy its pose to frame 4' in labelled(contextEntries('keyframe', { copyKeyHere: 8, note: 8 })));
  assert.ok(!('Copy its pose to frame 4' in labelled(contextEntries('keyframe', { copyKeyHere: 4, note: 4 }))));
});

test('one can look up in which menus an action is', () => {
  assert.deepEqual(menusWith('turnInDepth'), ['a part']);
  assert.deepEqual(menusWith('undo'), []);
});

test('letters lead to the entry that begins with them', () => {
  const labels = ['Copy pose', 'Paste pose', 'Paste mirrored', 'Reset pose'];
  assert.equal(typedTo(labels, -1, 'p', 1000), 1);
  assert.equal(typedTo(labels, 1, 'P', 1100), 2, 'the same letter again: the next');
  assert.equal(typedTo(labels, 2, 'p', 1200), 1, 'and round');
  assert.equal(typedTo(labels, 1, 'r', 9000), 3, 'after a pause a new word begins');
  assert.equal(typedTo(labels, 3, 'e', 9100), 3, 'it stays while it fits');
  assert.equal(typedTo(labels, 3, 'x', 20000), -1);
});

test('a letter that does not go on with the word begins another', () => {
  const labels = ['Copy pose', 'Paste pose', 'Reset pose'];
  assert.equal(typedTo(labels, -1, 'p', 50000), 1);
  assert.equal(typedTo(labels, 1, 'c', 50100), 0);
});

test('what was typed in one menu does not count in the next', () => {
  const labels = ['Copy pose', 'Other side'];
  assert.equal(typedTo(labels, -1, 'c', 90000), 0);
  beginTyping();
  assert.equal(typedTo(labels, -1, 'o', 90100), 1);
});
