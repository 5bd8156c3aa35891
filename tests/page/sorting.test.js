// The order of the files in the chooser.

import assert from 'node:assert/strict';
import test from 'node:test';

import { heldIn, sorted } from '../../static/start/sorting.js';

const FILES = [
  { name: 'clip 10', bytes: 5, modified_at: 3 },
  { name: 'Clip 9', bytes: 7, modified_at: 1 },
  { name: 'a', bytes: 5, modified_at: 2 },
];
const names = (files) => files.map(({ name }) => name);

test('by name, numbers by their value and letters whatever their case', () => {
  assert.deepEqual(names(sorted(FILES)), ['a', 'Clip 9', 'clip 10']);
});

test('by date or size either way, equal ones by name', () => {
  assert.deepEqual(names(sorted(FILES, { by: 'date', down: true })), ['clip 10', 'a', 'Clip 9']);
  assert.deepEqual(names(sorted(FILES, { by: 'size', down: false })), ['a', 'clip 10', 'Clip 9']);
});

test('a folder holds what lies in it and in those inside, and nothing of one whose name begins alike', () => {
  const files = ['0/clips/a.mp4', '0/clips/more/b.mp4', '0/clips2/c.mp4', '1/clips/d.mp4'].map((id) => ({ id }));
  assert.equal(heldIn('0/clips', files), 2);
  assert.equal(heldIn('0/', files), 3);
  assert.equal(heldIn('0/empty', files), 0);
});
