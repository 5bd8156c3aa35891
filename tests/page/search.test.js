// The command search: what people type leads to what they mean, and nothing is offered in vain.

import './browser.js';
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import { beforeEach, test } from 'node:test';
import { allEntries, fitOf, found, runEntry, SETTINGS } from '../../static/actions/search.js';
import { ACTIONS } from '../../static/actions/table.js';
import { inBrowser } from '../../static/store/storage.js';
import { server, ui } from '../../static/store/state.js';

const part = (name, label, side) => ({ name, label, short: label, side, parent: null, mirror: null, landmarks: [] });

beforeEach(() => {
  Object.assign(server, {
    file: { name: 'jump', path: '/jump', frames: 60 },
    view: { frame: 4, selected: null, mode: 'both', trail: true },
    body: {
      parts: [
        part('left_forearm', 'Left forearm', 'L'),
        part('left_upper_arm', 'Left upper arm', 'L'),
        part('right_forearm', 'Right forearm', 'R'),
      ],
      handles: [],
    },
    keys: { frames: [0, 8, 20], drafts: [] },
    undo: { undo: 'turn left hand', redo: null },
    history: { done: 1, total: 1, first: 0, steps: [] },
    segments: [
      { first: 0, last: 8, state: 'good' },
      { first: 8, last: 20, state: 'check' },
    ],
    clipboard: false,
    done: 1e9,
    notes: [
      { frame: 12, text: 'elbow hidden behind the chest' },
      { frame: 30, text: '' },
    ],
    pins: [],
    proposed_pins: [],
  });
  ui.library = { recents: [{ id: 'a', name: 'hurdle', path: '/hurdle', keyframes: 4, opened_at: 0, missing: false }] };
  inBrowser.remove('keypose.recent-commands');
});

const ids = (query, kind) => found(query, kind).map(({ id }) => id);

test('every action of the table can be found, but those that need something pointed at', () => {
  const known = new Set(allEntries().map(({ id }) => id));
  const missing = Object.keys(ACTIONS).filter((id) => !known.has(`action:${id}`));
  assert.deepEqual(missing.sort(), [
    'copyKeyHere',
    'duplicateKeyframe',
    'goTo',
    'goToStep',
    'insertMirrored',
    'insertPose',
    'openRecent',
    'pinCorner',
    'search',
    'splitPin',
    'unkeyLimb',
  ]);
});

test('whatever can be done needs nothing that is not there', () => {
  for (const { id, off } of allEntries()) {
    const action = ACTIONS[id.replace('action:', '')];
    if (!off && action?.message) assert.ok(action.message(undefined).do, id);
  }
});

test('what people type leads to what they mean', () => {
  const meant = {
    undo: 'action:undo',
    'undo list': 'action:history',
    blender: 'action:saveGlb',
    unreal: 'action:saveGlb',
    screenshot: 'action:saveImage',
    shortcuts: 'action:showKeys',
    'dark mode': 'action:darkTheme',
    'onion skin': 'action:ghosts',
    comment: 'action:note',
    marker: 'action:note',
    wireframe: 'action:wire',
    'plant foot': 'action:pin',
    'left forearm': 'part:left_forearm',
    forearm: 'part:left_forearm',
    'l forearm': 'part:left_forearm',
    focal: 'setting:camera:Lens',
    'camera tab': 'tab:camera',
    mask: 'setting:camera:Ignore masks',
    hurdle: 'file:a',
    'chest hidden': 'note:12',
    'add key': 'action:addKeyframe',
    lense: 'setting:camera:Lens',
    keyfrmae: 'action:addKeyframe',
    'export table': 'action:saveCsv',
    excel: 'action:saveCsv',
    quality: 'setting:track:Method',
    preset: 'setting:body:Body',
    speed: 'action:playFaster',
    gif: 'action:exportFilm',
    fbx: 'action:saveFbx',
    'flip leg': 'action:turnInDepth',
    retarget: 'action:exportMotion',
    'another person': 'action:drawBox',
    elbow: 'part:left_forearm',
    'right elbow': 'part:right_forearm',
  };
  for (const [query, id] of Object.entries(meant)) {
    const place = ids(query).indexOf(id);
    assert.ok(place >= 0 && place < 4, `${query}: ${id} at ${place} of ${ids(query).slice(0, 5)}`);
  }
  for (const query of ['undo', 'left forearm', 'dark mode', 'screenshot', 'shortcuts', 'hurdle', 'camera tab']) {
    assert.equal(ids(query)[0], meant[query], query);
  }
});

test('a number leads to its frame, if the video has it', () => {
  for (const query of ['47', 'frame 47', 'go to frame 47', 'goto 47', 'f47', ' 47 ']) {
    assert.equal(found(query)[0].title, 'Go to frame 47', query);
    assert.equal(found(query)[0].off, '', query);
  }
  assert.equal(found('60')[0].off, 'The video has frames 0 to 59');
  assert.notEqual(found('47a')[0]?.id, 'frame');
});

test('what cannot be done says why and stands behind what can', () => {
  const paste = found('paste')[0];
  assert.equal(paste.off, 'Copy a pose first (Ctrl C)');
  server.clipboard = true;
  assert.equal(found('paste')[0].off, '');
  assert.equal(found('redo')[0].off, 'Nothing to redo');
  assert.match(allEntries().find(({ id }) => id === 'action:fine').off, /^Held/);
});

test('what was used lately comes first, while nothing is typed', () => {
  const wanted = allEntries().find(({ id }) => id === 'action:lightTheme');
  runEntry({ ...wanted, run: () => {} });
  const [first, second] = found('');
  assert.deepEqual([first.id, first.group], ['action:lightTheme', 'Recent']);
  assert.equal(second.group, 'Frames');
  assert.equal(found('').filter(({ id }) => id === 'action:lightTheme').length, 1);
});

test('a kept list that is damaged is none', () => {
  for (const kept of ['{', '{"a":1}', '[1,null,"gone:x"]']) {
    inBrowser.write('keypose.recent-commands', kept);
    assert.equal(found('')[0].group, 'Frames', kept);
  }
});

test('notes alone are listed by frame, and searched by their words', () => {
  assert.deepEqual(ids('', 'Note'), ['note:12', 'note:30']);
  assert.deepEqual(ids('elbow', 'Note'), ['note:12']);
  assert.deepEqual(ids('undo', 'Note'), []);
});

test('without a file only what needs none can be done', () => {
  server.file = null;
  const can = allEntries()
    .filter(({ off }) => !off)
    .map(({ id }) => id);
  assert.deepEqual(can.sort(), [
    'action:darkTheme',
    'action:lightTheme',
    'action:openFile',
    'action:showKeys',
    'action:systemTheme',
    'file:a',
  ]);
});

test('every setting is a section of the inspector', () => {
  const folder = new URL('../../static/inspector/', import.meta.url);
  const text = readdirSync(folder)
    .map((name) => readFileSync(new URL(name, folder), 'utf8'))
    .join('');
  for (const { section } of SETTINGS) assert.ok(text.includes(`'${section}'`), section);
});

test('the fit is best for whole words, and none for other ones', () => {
  const fit = (query, text) => fitOf(query, [{ text, weight: 1 }]);
  assert.ok(fit('pose', 'Copy pose') > fit('pos', 'Copy pose'));
  assert.ok(fit('pos', 'Copy pose') > fit('ose', 'Copy pose'));
  assert.ok(fit('poze', 'Copy pose') > 0);
  assert.ok(fit('kf', 'Keyframe') > 0);
  assert.equal(fit('pose turtle', 'Copy pose'), 0);
  assert.equal(fit('', 'Copy pose'), 0);
  assert.equal(fit('!?', 'Copy pose'), 0);
  assert.ok(fit('ecran', 'Écran') > 0);
});
