// What the mask of the person asks of the server while the playhead moves on, and says if there is none.

import assert from 'node:assert/strict';
import test from 'node:test';

import { animationFrame } from './browser.js';

test('masks are asked for one after another, and a frame that has none is told once', async () => {
  globalThis.setTimeout = /** @type {any} */ ((fn) => void fn()); // the playhead rests
  const asked = [];
  const answers = [];
  globalThis.localStorage ??= /** @type {any} */ ({ getItem: () => '' });
  globalThis.fetch = /** @type {any} */ (
    (path) => {
      asked.push(path);
      return new Promise((done) =>
        answers.push(() => done({ ok: false, text: async () => `No person at ${path}.\n` })),
      );
    }
  );
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
  const said = () => (ui.toasts ?? []).map(({ words }) => words);
  const answered = async () => {
    answers.at(-1)();
    await new Promise(setImmediate);
  };
  assert.deepEqual(said(), []); // of the frame that was left behind
  await answered();
  await rest(6);
  await answered();
  assert.deepEqual(said(), ['No person at /person/5.png.']);
  setUi('personMask', false);
  animationFrame();
  setUi('personMask', true);
  await rest(7);
  await answered();
  assert.deepEqual(said().at(-1), 'No person at /person/7.png.');
});
