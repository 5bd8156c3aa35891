// What a browser keeps, where it may keep things and where it may not.

import './browser.js';
import assert from 'node:assert/strict';
import { afterEach, test } from 'node:test';
import { inBrowser, inTab } from '../../static/store/storage.js';

afterEach(() => {
  for (const name of ['theme', 'tool']) for (const place of [inBrowser, inTab]) place.remove(name);
});

/** Put this in the place of the browser's own storage. */
function standIn(name, value) {
  Object.defineProperty(globalThis, name, { configurable: true, ...value });
}

function working() {
  const values = new Map();
  return {
    getItem: (name) => values.get(name) ?? null,
    setItem: (name, value) => void values.set(name, value),
    removeItem: (name) => void values.delete(name),
  };
}

test('what is kept is read as it was written, until it is removed', () => {
  standIn('localStorage', { value: working() });
  assert.equal(inBrowser.read('theme'), null);
  inBrowser.write('theme', 'light');
  assert.equal(localStorage.getItem('theme'), 'light');
  assert.equal(inBrowser.read('theme'), 'light');
  inBrowser.remove('theme');
  assert.equal(inBrowser.read('theme'), null);
});

test('a browser that forbids keeping anything has it as long as the page is', () => {
  standIn('sessionStorage', {
    get() {
      throw new Error('forbidden');
    },
  });
  assert.equal(inTab.read('tool'), null);
  inTab.write('tool', 'move');
  assert.equal(inTab.read('tool'), 'move');
  inTab.remove('tool');
  assert.equal(inTab.read('tool'), null);
});

test('where there is no room, the newest counts and not what was kept before', () => {
  const full = working();
  standIn('localStorage', { value: full });
  inBrowser.write('theme', 'dark');
  const { setItem } = full;
  full.setItem = () => {
    throw new Error('no room');
  };
  inBrowser.write('theme', 'light');
  assert.equal(inBrowser.read('theme'), 'light');
  full.setItem = setItem;
  inBrowser.write('theme', 'auto');
  assert.equal(full.getItem('theme'), 'auto');
  assert.equal(inBrowser.read('theme'), 'auto');
});
