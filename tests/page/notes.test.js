// Notes on the page: which is where, what is sent, where its mark is grabbed.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { labelOf, whyNot } from '../../static/actions/actions.js';
import { noteBeside, noteAsOneLine, noteMessage } from '../../static/actions/keying.js';
import { server } from '../../static/store/state.js';
import { note } from '../../static/timeline/marks/notes.js';
import * as scale from '../../static/timeline/draw/scale.js';

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 101 },
    view: { frame: 30 },
    keys: { frames: [], drafts: [] },
    notes: [
      { frame: 10, text: 'one' },
      { frame: 50, text: '' },
    ],
  });
  scale.setWidth(scale.left() + 1000 + 26);
});

test('one goes to the note before and after, and is told where there is none', () => {
  assert.deepEqual([noteBeside(-1).frame, noteBeside(1).frame], [10, 50]);
  assert.equal(whyNot('nextNote'), '');
  server.view = { frame: 50 };
  assert.equal(whyNot('nextNote'), 'There is no note after frame 50');
  server.notes = [];
  assert.equal(whyNot('nextNote'), 'There are no notes');
});

test('a note is added or edited, and only one that is there is deleted', () => {
  assert.deepEqual([labelOf('note'), labelOf('note', 10)], ['Add note', 'Edit note']);
  assert.equal(whyNot('deleteNote'), 'Frame 30 has no note');
  assert.equal(whyNot('deleteNote', 50), '');
});

test('the same words send nothing; none at all leave a flag', () => {
  assert.equal(noteMessage(10, ' one '), null);
  assert.deepEqual(noteMessage(10, 'two'), { do: 'set_note', frame: 10, text: 'two' });
  assert.deepEqual(noteMessage(30, ''), { do: 'set_note', frame: 30, text: '' });
  assert.equal(noteMessage(50, ''), null);
});

test('a note in one line is cut, and a flag has a name', () => {
  assert.equal(noteAsOneLine({ text: 'a\n b' }), 'a b');
  assert.equal(noteAsOneLine({ text: 'abcdefgh' }, 5), 'abcd…');
  assert.equal(noteAsOneLine({ text: '' }), 'Flag');
});

test('a mark is grabbed at the foot of the ruler, and nowhere else', () => {
  const y = scale.RULER - 4;
  const noteMarkAt = (place) => note.hit(place)?.frame ?? null;
  assert.equal(noteMarkAt({ x: scale.x(50) + 4, y }), 50);
  assert.equal(noteMarkAt({ x: scale.x(50) + 12, y }), null);
  assert.equal(noteMarkAt({ x: scale.x(50), y: 5 }), null);
  assert.equal(noteMarkAt({ x: scale.x(50), y: scale.RULER + 8 }), null);
});
