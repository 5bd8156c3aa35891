// What the dialog of exports asks of the server, and what it refuses by itself.

import assert from 'node:assert/strict';
import test from 'node:test';

import './browser.js';

const { beginExport, cancelExport, exportOrder, motionAddress, notInstalled, usualExport, whyNoMatte, whyNotExport } =
  await import('../../static/actions/exporting.js');
const { server, setUi, ui } = await import('../../static/store/state.js');

Object.assign(server, {
  file: { name: 'walk', frames: 41, width: 640, height: 360 },
  keys: { frames: [0, 24, 40], drafts: [] },
  body: { is_persons: true },
  surface: null,
  view: { mode: 'both', opacity: 0.5, tint: 'clay', frame: 7 },
});

/** What the dialog starts with, and what was chosen in it. */
function chosen(what, changed = {}, format = 'all') {
  const usual = usualExport();
  return { ...usual, what, format, values: { ...usual.values, [what]: { ...usual.values[what], ...changed } } };
}

const LOOK = { style: 'both', opacity: '50' };

test('a film has the frames, the size and the rate that were chosen', () => {
  assert.deepEqual(exportOrder(chosen('film')), { what: 'film', ...LOOK, view: 'main', frames: '0-40' });
  const order = exportOrder(chosen('film', { size: '1280x720', fps: '25', view: 'orbit', style: 'wire' }));
  assert.deepEqual([order.size, order.fps, order.view, order.style], ['1280x720', '25', 'orbit', 'wire']);
});

test('a film or images are first of the view in the large place', () => {
  for (const layout of ['free', 'side', 'main']) {
    setUi('layout', layout);
    assert.deepEqual(
      ['film', 'pictures'].map((what) => usualExport().values[what].view),
      [layout, layout],
    );
  }
});

test('the free view is a camera that stands where it looks from', () => {
  assert.match(
    exportOrder(chosen('film', { view: 'free' }), { azimuth: 30, elevation: 10 }).view,
    /^camera:30.00,10.00$/,
  );
});

test('images are of this frame, of the keyframes, or of every frame', () => {
  assert.equal(exportOrder(chosen('pictures', { frames: 'this' })).frames, '7');
  assert.equal(exportOrder(chosen('pictures')).frames, 'keyframes');
});

test('a sheet has the columns that were chosen, or as many as fit', () => {
  assert.deepEqual(exportOrder(chosen('sheet')), { what: 'sheet', ...LOOK });
  assert.equal(exportOrder(chosen('sheet', { columns: '3' })).columns, '3');
});

test('a matte is of all frames, and knows nothing of how the body is drawn', () => {
  assert.deepEqual(exportOrder(chosen('matte')), { what: 'matte', kind: 'png', frames: '0-40' });
  const order = exportOrder(chosen('matte', { kind: 'webm', alpha_only: 'true', frames: '3-9' }));
  assert.deepEqual(order, { what: 'matte', kind: 'webm', frames: '3-9', alpha_only: 'true' });
});

test('a matte needs a person in a video, and a pose to start from', () => {
  const { body, keys } = server;
  assert.equal(whyNoMatte(), '');
  server.keys = { ...keys, frames: [] };
  assert.match(whyNoMatte(), /keyframe/);
  server.keys = { ...keys, frames: [], drafts: [3] };
  assert.equal(whyNoMatte(), '');
  server.body = { ...body, is_persons: false };
  assert.match(whyNoMatte(), /person/);
  Object.assign(server, { body, keys });
});

test('motion is asked for with what was chosen of it and what its format heeds', () => {
  const asked = (changed, format) =>
    Object.fromEntries(new URLSearchParams(motionAddress(chosen('motion', changed, format)).split('?')[1]));
  assert.deepEqual(asked({ filter_hz: '6', fps: '30', from_zero: 'true' }, 'csv'), {
    format: 'csv',
    origin: 'body',
    frames: '0-40',
    fps: '30',
    from_zero: 'true',
    filter_hz: '6',
  });
  assert.deepEqual(asked({ rig: 'ue5', unit: 'cm' }, 'glb'), {
    format: 'glb',
    rig: 'ue5',
    origin: 'body',
    frames: '0-40',
  });
  assert.equal(asked({ unit: 'cm' }, 'bvh').unit, 'cm');
  assert.equal(asked({ origin: 'camera' }, 'chan').origin, 'camera');
});

test('several bodies share one file where that is chosen and the format can', () => {
  const asked = (format) => new URLSearchParams(motionAddress(chosen('motion', { together: 'true' }, format)));
  assert.equal(asked('trc').get('together'), null, 'there is one body');
  server.bodies = [{ id: 'ann' }, { id: 'bo' }];
  for (const format of ['trc', 'c3d', 'csv', 'npz']) assert.equal(asked(format).get('together'), 'true');
  for (const format of ['glb', 'bvh', 'chan']) assert.equal(asked(format).get('together'), null);
  server.bodies = [];
});

test('what is not installed says what mends it', () => {
  setUi('exportMissing', { usd: "pip install 'keypose[usd]'" });
  assert.equal(notInstalled('usd'), "USD needs usd-core: pip install 'keypose[usd]'");
  assert.equal(notInstalled('c3d'), '');
  assert.equal(notInstalled('bvh'), '');
});

test('what cannot be exported is said before it is tried', () => {
  assert.equal(whyNotExport(chosen('film'), 41), '');
  assert.match(whyNotExport(chosen('film', { frames: '0-41' }), 41), /last frame of the video is 40/);
  assert.match(whyNotExport(chosen('film', { frames: '9-3' }), 41), /not after the last/);
  assert.match(whyNotExport(chosen('film', { frames: 'x-3' }), 41), /two numbers/);
  assert.match(whyNotExport(chosen('film', { fps: '0' }), 41), /Rate is a number from 0.1 to 1000/);
  assert.match(whyNotExport(chosen('motion', { filter_hz: 'six' }), 41), /Low-pass filter.* Hz/);
  assert.match(whyNotExport(chosen('sheet', { columns: '0' }), 41), /1 to 100/);
});

/** Lets the test answer what is asked: [path, method, answer with this]. */
function heldBack() {
  /** @type {[string, string, (value: unknown) => void][]} */
  const asked = [];
  globalThis.fetch = /** @type {any} */ (
    (path, { method = 'GET' } = {}) =>
      new Promise((answer) =>
        asked.push([path, method, (value) => answer({ ok: true, status: 200, json: async () => value })]),
      )
  );
  return asked;
}

const settled = () => new Promise((done) => setTimeout(done));

test('an export that is cancelled before the server knows it stays cancelled, and ends there too', async () => {
  const asked = heldBack();
  setUi('exporting', chosen('film'));
  void beginExport();
  await cancelExport();
  void beginExport(); // another one, at once
  const [[, , first], [, , second]] = asked;
  second({ id: 'second' });
  await settled();
  first({ id: 'first' });
  await settled();
  assert.equal(ui.exportJob?.id, 'second');
  assert.deepEqual(
    asked.slice(2).map(([path, method]) => [path, method]),
    [
      ['/exports/second', 'GET'],
      ['/exports/first', 'DELETE'],
    ],
  );
  setUi('exportJob', null); // or it would be looked after for ever
});
