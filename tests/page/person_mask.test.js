// What the mask of the person asks of the server while the playhead moves on.

import assert from 'node:assert/strict';
import test from 'node:test';

import { animationFrame } from './browser.js';

test('masks are asked for one after another, and those left behind not at all', async () => {
  globalThis.setTimeout = /** @type {any} */ ((fn) => void fn()); // the playhead rests
  const asked = [];
  const answers = [];
  globalThis.localStorage ??= /** @type {any} */ ({ getItem: () => '' });
  globalThis.fetch = /** @type {any} */ ((path) => {
    asked.push(path);
    return new Promise((done) => answers.push(() => done({ ok: false })));
  });
  const { server, setUi, ui } = await import('../../static/store/state.js');
  const { mountPersonMask } = await import('../../static/views/person_mask.js');
  Object.assign(server, { file: { path: 'a.mp4' }, body: { is_persons: true } });
  ui.personMask = true;
  mountPersonMask(/** @type {any} */ ({ dataset: {} }), () => {});
  const rest = async (frame) => {
    setUi('shown', frame);
    animationFrame();
    await new Promise(setImmediate);
  };
  for (const frame of [3, 4, 5]) await rest(frame);
  assert.deepEqual(asked, ['/person/3.png']);
  answers[0]();
  await new Promise(setImmediate);
  assert.deepEqual(asked, ['/person/3.png', '/person/5.png']);
});
