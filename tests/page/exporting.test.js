// What the dialog of exports asks of the server, and what it refuses by itself.

import assert from 'node:assert/strict';
import test from 'node:test';

import './browser.js';

const { beginExport, cancelExport, motionAddress, notInstalled, orderOf, whyNotExport } = await import('../../static/actions/exporting.js');
const { MOTION } = await import('../../static/actions/table/export.js');
const { server, setUi, ui } = await import('../../static/store/state.js');

/** @type {import('../../static/actions/exporting.js').Options} */
const OPTIONS = {
  what: 'film', view: 'main', size: 'own', style: 'both', first: '0', last: '40', fps: '', frames: 'keyframes',
  background: 'video', columns: '', format: 'all', filter: '', rig: 'keypose', unit: 'm',
};
const AT = { opacity: 0.5, tint: 'clay', frame: 7, eye: { azimuth: 30, elevation: 10 } };
const LOOK = { style: 'both', opacity: 0.5, tint: 'clay' };

test('a film has the frames, the size and the rate that were chosen', () => {
  assert.deepEqual(orderOf(OPTIONS, AT), { what: 'film', ...LOOK, view: 'main', size: null, frames: [0, 40], fps: null });
  const chosen = orderOf({ ...OPTIONS, size: '1280x720', fps: '25', view: 'orbit' }, AT);
  assert.deepEqual([chosen.size, chosen.fps, chosen.view], [[1280, 720], 25, 'orbit']);
});

test('the free view is a camera that stands where it looks from', () => {
  const { view, azimuth, elevation } = orderOf({ ...OPTIONS, view: 'free' }, AT);
  assert.deepEqual([view, azimuth, elevation], ['camera', 30, 10]);
});

test('images are of this frame, of the keyframes, or of every frame', () => {
  assert.equal(orderOf({ ...OPTIONS, what: 'pictures', frames: 'this' }, AT).frames, 7);
  assert.equal(orderOf({ ...OPTIONS, what: 'pictures' }, AT).frames, 'keyframes');
});

test('a sheet has the columns that were chosen, or as many as fit', () => {
  assert.deepEqual(orderOf({ ...OPTIONS, what: 'sheet' }, AT), { what: 'sheet', ...LOOK, columns: null });
  assert.equal(orderOf({ ...OPTIONS, what: 'sheet', columns: '3' }, AT).columns, 3);
});

test('motion is asked for with its filter and rate only where they were chosen', () => {
  assert.equal(motionAddress(OPTIONS), '/motion?format=all&first=0&last=40');
  assert.equal(motionAddress({ ...OPTIONS, format: 'bvh', filter: '6', fps: '30' }), '/motion?format=bvh&filter_hz=6&fps=30&first=0&last=40');
});

test('bones are asked for by the name of a rig, the body’s own by none', () => {
  assert.equal(motionAddress({ ...OPTIONS, format: 'glb', rig: 'ue5' }), '/motion?format=glb&rig=ue5&first=0&last=40');
});

test('lengths of BVH are asked for in the unit that was chosen, metres without a word', () => {
  assert.equal(motionAddress({ ...OPTIONS, format: 'glb', fromZero: true }), '/motion?format=glb&from_zero=true&first=0&last=40');
  assert.equal(motionAddress({ ...OPTIONS, format: 'bvh', unit: 'cm' }), '/motion?format=bvh&unit=cm&first=0&last=40');
});

test('what is not installed says what mends it', () => {
  setUi('exportMissing', { usd: "pip install 'keypose[usd]'" });
  assert.equal(notInstalled(MOTION.saveUsd), "USD needs usd-core: pip install 'keypose[usd]'");
  assert.equal(notInstalled(MOTION.saveC3d), '');
  assert.equal(notInstalled(MOTION.saveBvh), '');
});

test('what cannot be exported is said before it is tried', () => {
  assert.equal(whyNotExport(OPTIONS, 41), '');
  assert.match(whyNotExport({ ...OPTIONS, last: '41' }, 41), /last frame of the video is 40/);
  assert.match(whyNotExport({ ...OPTIONS, first: '9', last: '3' }, 41), /not after the last/);
  assert.match(whyNotExport({ ...OPTIONS, first: 'x' }, 41), /two numbers/);
  assert.match(whyNotExport({ ...OPTIONS, fps: '0' }, 41), /0.1 to 1000/);
  assert.match(whyNotExport({ ...OPTIONS, what: 'motion', filter: 'six' }, 41), /hertz/);
  assert.match(whyNotExport({ ...OPTIONS, what: 'sheet', columns: '0' }, 41), /1 to 100/);
});

/** Lets the test answer what is asked: [path, method, answer with this]. */
function heldBack() {
  /** @type {[string, string, (value: unknown) => void][]} */
  const asked = [];
  globalThis.fetch = /** @type {any} */ ((path, { method = 'GET' } = {}) =>
    new Promise((answer) => asked.push([path, method, (value) => answer({ ok: true, status: 200, json: async () => value })])));
  return asked;
}

const settled = () => new Promise((done) => setTimeout(done));

test('an export that is cancelled before the server knows it stays cancelled, and ends there too', async () => {
  const asked = heldBack();
  Object.assign(server, { view: { opacity: 0.5, tint: 'clay', frame: 0 }, file: { name: 'walk', frames: 41 }, surface: null });
  setUi('exporting', OPTIONS);
  void beginExport();
  await cancelExport();
  void beginExport(); // another one, at once
  const [[, , first], [, , second]] = asked;
  second({ id: 'second' });
  await settled();
  first({ id: 'first' });
  await settled();
  assert.equal(ui.exportJob?.id, 'second');
  assert.deepEqual(asked.slice(2).map(([path, method]) => [path, method]), [['/exports/second', 'GET'], ['/exports/first', 'DELETE']]);
  setUi('exportJob', null); // or it would be looked after for ever
});
