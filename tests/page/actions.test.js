// The table of actions: everything in it has words, its keys work, and menus refer to nothing else.

import './browser.js';
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { beforeEach, test } from 'node:test';
import { BY_CHORD, keySheet, labelOf, perform, titleOf, whyNot } from '../../static/actions/actions.js';
import { ACTIONS, GROUPS } from '../../static/actions/table.js';
import { isFine, modifiers, watchKeys } from '../../static/handles/drag.js';
import { server, ui } from '../../static/store/state.js';

const ABOUT = {
  openRecent: { id: 'a', name: 'jump' },
  goTo: 12,
  deleteKeyframe: 8,
  zoomToSegment: { first: 0, last: 8 },
  trackThis: { first: 0, last: 8 },
};
const STATIC = new URL('../../static/', import.meta.url);

beforeEach(() => {
  server.file = { name: 'jump', path: '/jump', frames: 60 };
  server.view = { frame: 4, selected: 'left_hand', mode: 'both', ghosts: false, trail: true, live: false };
  server.body = {
    parts: [{ name: 'left_hand', label: 'Left hand', parent: null, mirror: 'right_hand', landmarks: [] }],
  };
  server.keys = { frames: [0, 8, 20], drafts: [] };
  server.segments = [
    { first: 0, last: 8, state: 'good' },
    { first: 8, last: 20, state: 'check' },
  ];
  server.undo = { undo: 'turn left hand', redo: null };
  ui.toasts = [];
});

const all = () => Object.entries(ACTIONS);

test('no action stands in two groups', () => {
  const names = GROUPS.flatMap(({ actions }) => Object.keys(actions));
  assert.equal(new Set(names).size, names.length);
});

test('every action has words, in every state of the page', () => {
  const states = [
    () => {},
    () => ['view', 'body', 'keys', 'segments', 'undo'].forEach((name) => (server[name] = undefined)),
  ];
  for (const change of states) {
    change();
    for (const [id] of all()) {
      assert.match(String(labelOf(id, ABOUT[id])), /\S/, id);
      assert.match(String(titleOf(id, ABOUT[id])), /\S/, id);
      assert.equal(typeof whyNot(id, ABOUT[id]), 'string', id);
    }
  }
});

test('words begin with a capital and a reason has no full stop of its own', () => {
  server.keys = { frames: [], drafts: [] };
  server.segments = [];
  for (const [id] of all()) {
    if (id !== 'openRecent') assert.match(String(labelOf(id, ABOUT[id])), /^[A-Z1-9]/, id);
    assert.doesNotMatch(whyNot(id, ABOUT[id]), /\.$/, id);
  }
});

test('no two keys clash', () => {
  const chords = all().flatMap(([, { handledBy, keys = [], aliases = [] }]) =>
    handledBy ? [] : [...keys, ...aliases],
  );
  assert.deepEqual(
    chords.filter((chord, i) => chords.indexOf(chord) !== i),
    [],
  );
});

test('every key of the sheet is handled', () => {
  const elsewhere = new Set(all().flatMap(([, { handledBy, keys = [] }]) => (handledBy ? keys : [])));
  for (const { words, keys } of keySheet().flatMap(({ lines }) => lines)) {
    assert.ok(keys.length > 0, words);
    for (const chord of keys) assert.ok(BY_CHORD.has(chord) || elsewhere.has(chord), `${words}: ${chord}`);
  }
});

test('every action is either a message or something that the page does', () => {
  for (const [id, { message, run, handledBy }] of all()) {
    const isHeld = handledBy === 'drag' || handledBy === 'pointer';
    assert.equal(Number(Boolean(message)) + Number(Boolean(run)), isHeld ? 0 : 1, id);
  }
});

test('keys that are held in a drag change the drag', () => {
  const listeners = new Map();
  globalThis.addEventListener = (kind, fn) => listeners.set(kind, fn);
  watchKeys();
  const press = (key, more = {}) =>
    listeners.get('keydown')({ key, code: '', shiftKey: false, ctrlKey: false, altKey: false, ...more });
  const does = {
    Shift: () => isFine(),
    Ctrl: () => modifiers().snap,
    D: () => modifiers().depth,
    U: () => modifiers().free,
    Alt: () => modifiers().carry,
    X: () => modifiers().axis === 'x',
    Y: () => modifiers().axis === 'y',
    Z: () => modifiers().axis === 'z',
  };
  const held = all().flatMap(([, { handledBy: by, keys }]) => (by === 'drag' ? keys : []));
  for (const key of held.filter((one) => one !== 'Escape')) {
    listeners.get('blur')();
    assert.equal(does[key](), false, key);
    press(key, { shiftKey: key === 'Shift', ctrlKey: key === 'Ctrl', altKey: key === 'Alt' });
    assert.equal(does[key](), true, key);
  }
});

test('what cannot be done says why, unless an answer is still on its way', () => {
  server.clipboard = false;
  server.done = 1e9;
  perform('pastePose');
  assert.deepEqual(
    ui.toasts.map(({ words }) => words),
    ['Copy a pose first (Ctrl C).'],
  );
  ui.toasts = [];
  server.done = -1;
  perform('pastePose');
  assert.deepEqual(ui.toasts, []);
});

test('a step that leads nowhere says nothing', () => {
  server.view.frame = 0;
  server.done = 1e9;
  for (const id of ['previousFrame', 'previousKeyframe', 'redo']) perform(id);
  assert.deepEqual(ui.toasts, []);
});

test('menus and buttons refer to actions of the table', () => {
  const files = readdirSync(STATIC, { recursive: true }).filter(
    (name) => name.endsWith('.js') && !name.includes('vendor'),
  );
  const named = files.flatMap((name) => {
    const text = readFileSync(new URL(name, STATIC), 'utf8');
    return [...text.matchAll(/\b(?:menuItem|actionIcon|actionButton|actionBox|perform|keyOf|labelOf)\('(\w+)'/g)].map(
      (found) => found[1],
    );
  });
  assert.ok(named.length > 30);
  for (const id of named) assert.ok(id in ACTIONS, id);
});

test('a menu is made of the table, and no entry is written by hand', () => {
  const textOf = (name) => readFileSync(new URL(name, STATIC), 'utf8');
  // The one entry by hand is that of the in or the out point alone, which has no key.
  const marks = readdirSync(new URL('timeline/marks', STATIC))
    .filter((name) => name !== 'span.js')
    .map((name) => `timeline/marks/${name}`);
  const menus = [
    'shell/export_menu.js',
    'shell/topbar.js',
    'shell/track.js',
    ...marks.filter((name) => textOf(name).includes('openMenuAt(')),
  ];
  assert.ok(menus.length > 9);
  for (const name of menus) {
    const text = textOf(name);
    assert.match(text, /(menuItem|\w+Entries)\(/, name);
    assert.doesNotMatch(text, /\brun:/, name);
  }
});

test('what is not there cannot even be asked for while an answer is on its way', () => {
  server.view.frame = 0; // no keyframe lies before it
  server.done = -1; // something sent is not answered yet
  perform('copyPrevious');
  assert.deepEqual(
    ui.toasts.map(({ words }) => words),
    ['There is no keyframe before frame 0.'],
  );
  server.done = undefined;
});
