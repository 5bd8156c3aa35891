// What the dialog of imports asks of the server, and what it refuses by itself.

import assert from 'node:assert/strict';
import test from 'node:test';

import './browser.js';

const { beginImport, importFile, importOrder, isImported, leaveImport, openPoseFile, placesOfBody, whyNotBegin } =
  await import('../../static/actions/importing.js');
const { server, setUi, ui } = await import('../../static/store/state.js');

const MOTION = /** @type {any} */ ({
  kind: 'motion',
  program: 'BVH',
  facts: { individuals: [], left_out: ['Hips', 'Tail_1'] },
});
const KEYPOINTS = /** @type {any} */ ({
  kind: 'keypoints',
  program: 'SLEAP',
  facts: { individuals: [], layouts: [], left_out: [], every: 24 },
});

test('what is left to the file is not said', () => {
  assert.deepEqual(importOrder(MOTION, { places: {} }), { kind: 'motion', places: [] });
  assert.deepEqual(importOrder({ kind: 'camera', program: '', facts: {} }, {}), { kind: 'camera' });
});

test('a start frame may be negative, and names mean places of the body', () => {
  const order = importOrder(MOTION, { offset_frames: '-12', places: { Hips: 'pelvis', Tail_1: 'tail.end' } });
  assert.equal(order.offset_frames, '-12');
  assert.deepEqual(order.places, ['Hips=pelvis', 'Tail_1=tail.end']);
});

test('how the columns of a camera are meant is asked of .chan alone', () => {
  const said = { offset_frames: '-1001', unit: 'cm', rotation_order: 'xyz', lens_column: 'mm' };
  const camera = (columns) => importOrder({ kind: 'camera', program: '', facts: { columns } }, said);
  assert.deepEqual(camera(true), { kind: 'camera', ...said });
  assert.deepEqual(camera(false), { kind: 'camera', offset_frames: '-1001', unit: 'cm' });
});

test('a name that is not known can be a joint, a free end or a landmark', () => {
  const parts = /** @type {any[]} */ ([
    { name: 'trunk', label: 'Trunk', parent: null, landmarks: [] },
    { name: 'tail', label: 'Tail', parent: 'trunk', landmarks: ['tail_mark'] },
  ]);
  const found = placesOfBody(parts).map(({ id, label }) => [id, label]);
  assert.deepEqual(found, [
    ['trunk', 'Trunk'],
    ['tail', 'Tail'],
    ['tail.end', 'Tail, end'],
    ['tail.tail_mark', 'Tail mark'],
  ]);
});

test('what cannot be ordered is said in a sentence', () => {
  assert.equal(whyNotBegin(MOTION, {}, 100), '');
  assert.match(whyNotBegin(MOTION, { offset_frames: '1.5' }, 100), /whole number/);
  assert.match(whyNotBegin(KEYPOINTS, { offset_frames: 'x' }, 9), /whole number/);
  assert.match(whyNotBegin(MOTION, { fps: '0' }, 100), /Rate/);
  assert.match(whyNotBegin(KEYPOINTS, { frames: '0, 100' }, 100), /no frame 100.*is 99/);
  assert.match(whyNotBegin(KEYPOINTS, { every: '0' }, 100), /from 1 on/);
  assert.match(whyNotBegin(KEYPOINTS, { every: '9', frames: '0, 3' }, 100), /leave one empty/);
});

test('of several individuals one is chosen first', () => {
  for (const found of [KEYPOINTS, MOTION]) {
    const several = { ...found, facts: { ...found.facts, individuals: ['a', 'b'] } };
    assert.match(whyNotBegin(several, {}, 9), /Choose: Individual/);
    assert.equal(whyNotBegin(several, { individual: 'b' }, 9), '');
  }
});

test('the frames of OpenPose are one list, each with the name of its file', async () => {
  const frame = (name, text) => ({ name, text: async () => text });
  const made = await openPoseFile('walk', [frame('walk_03_keypoints.json', '{"people":[]}')]);
  assert.equal(made.name, 'walk.json');
  assert.deepEqual(JSON.parse(await made.text()), [{ people: [], file_name: 'walk_03_keypoints.json' }]);
  await assert.rejects(openPoseFile('walk', [frame('a_keypoints.json', '{')]), /a_keypoints.json is not JSON/);
});

test('an ending tells what may be imported, whatever its case', () => {
  assert.ok(['Walk.BVH', 'dogDLC.h5', 'shot.chan'].every(isImported));
  assert.ok(!isImported('notes.txt'));
});

test('a file brought again under its name is the one that is shown, however late the first is answered', async () => {
  /** @type {[string, string, (value: unknown) => void][]} */
  const asked = [];
  globalThis.fetch = /** @type {any} */ (
    (path, { method = 'GET' } = {}) =>
      new Promise((answer) =>
        asked.push([path, method, (value) => answer({ ok: true, status: 200, json: async () => value })]),
      )
  );
  const settled = () => new Promise((done) => setTimeout(done));
  void importFile(new File(['wrong'], 'walk.bvh'));
  leaveImport();
  void importFile(new File(['right'], 'walk.bvh'));
  const [[, , first], [, , second]] = asked;
  first({ id: 'first' });
  await settled();
  assert.deepEqual(
    asked.slice(2).map(([path, method]) => [path, method]),
    [['/imports/first', 'DELETE']],
  );
  second({ id: 'second' });
  await settled();
  assert.equal(ui.importing?.id, 'second');
  setUi('importing', null); // or it would be looked after for ever
});

test('a motion of which nothing is keyed is offered to be reduced to keyframes, which show it', async () => {
  globalThis.fetch = /** @type {any} */ (
    async (path, { method = 'GET' } = {}) => {
      const state = method === 'GET' ? { state: 'done', stage: 'importing', words: `${path} imported.` } : {};
      return { ok: true, status: 200, json: async () => state };
    }
  );
  const offered = async (id, kind, frames) => {
    server.keys = /** @type {any} */ ({ frames, drafts: [] });
    setUi(
      'importing',
      /** @type {any} */ ({ stage: 'choosing', id, name: 'a', found: { ...MOTION, kind }, choices: {}, words: '' }),
    );
    await beginImport();
    return ui.toasts.find(({ words }) => words === `/imports/${id} imported.`).button?.label;
  };
  assert.equal(await offered('a', 'motion', []), 'Reduce to keyframes…');
  assert.equal(await offered('b', 'motion', [4, 9]), undefined);
  assert.equal(await offered('c', 'camera', []), undefined);
});
