// Copying and pasting on the page: what a clipboard holds, and what is sent.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, mock, test } from 'node:test';
import { awaitPaste, copiedIn, framesFrom, onPaste, nothingCopied, pasteText } from '../../static/actions/copying.js';
import { server, ui } from '../../static/store/state.js';

const pose = { keypose: 'pose', version: 1, keys: [{ after: 0, root_m: [0, 0, 3], rotations_wxyz: {} }] };
const keys = { keypose: 'keyframes', version: 1, keys: [{ after: 0 }, { after: 12 }] };

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 73 },
    view: { frame: 12 },
    keys: { frames: [0, 24], drafts: [] },
    clipboard: false,
  });
  Object.assign(ui, { toasts: [], timeKeys: [], copiedHere: false });
});

const said = () => ui.toasts.map(({ words }) => words);

test('a text that holds poses is known, all others are not', () => {
  assert.deepEqual(copiedIn(JSON.stringify(pose)), pose);
  for (const text of [
    '',
    null,
    'hello',
    '{"keypose"',
    '{"keypose": "poem", "keys": [1]}',
    '{"keypose": "pose"}',
    '"keypose"',
    `"keypose"${' '.repeat(2e6)}`,
  ]) {
    assert.equal(copiedIn(text), null, String(text).slice(0, 30));
  }
});

test('keyframes are counted from the playhead', () => {
  assert.deepEqual(framesFrom(keys, 30), [30, 42]);
});

test('what else is on the clipboard is told in one sentence', () => {
  server.clipboard = true;
  pasteText('a poem');
  assert.deepEqual(said(), ['The clipboard holds no pose or keyframes. Copy some first (Ctrl C).']);
});

test('keyframes in the way are told with a button that replaces them', () => {
  pasteText(JSON.stringify(keys));
  assert.deepEqual(said(), ['Frame 24 is already a keyframe.']);
  assert.equal(ui.toasts[0].button.label, 'Replace it');
  assert.deepEqual(ui.timeKeys, []);
  ui.toasts[0].button.run();
  assert.deepEqual(ui.timeKeys, [12, 24]);
});

test('without a clipboard that can be read one copies first', () => {
  assert.equal(nothingCopied(), 'Copy a pose first (Ctrl C)');
  server.clipboard = true;
  assert.equal(nothingCopied(), '');
});

test('a browser that is late to tell what is on its clipboard does not paste twice', () => {
  const pastes = (act) => {
    ui.toasts = [];
    act();
    return said().length;
  };
  mock.timers.enable({ apis: ['setTimeout'] });
  awaitPaste(false);
  assert.equal(
    pastes(() => mock.timers.tick(60_000)),
    1,
  );
  assert.equal(
    pastes(() => onPaste('a poem')),
    0,
  );
  awaitPaste(false);
  assert.equal(
    pastes(() => onPaste('a poem')),
    1,
  );
  assert.equal(
    pastes(() => mock.timers.tick(60_000)),
    0,
  );
  mock.timers.reset();
});
