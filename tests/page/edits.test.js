// Edits that a page of this tab left behind: taken over entry by entry, as far as they are edits.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';

const NAME = 'keypose.edits';
const kept = new Map();
const storage = {
  getItem: (name) => kept.get(name) ?? null,
  setItem: (name, value) => void kept.set(name, value),
  removeItem: (name) => void kept.delete(name),
};
Object.defineProperty(globalThis, 'sessionStorage', { configurable: true, value: storage });

let pages = 0;

/** A page of this tab that begins with this kept. */
async function page(value) {
  kept.clear();
  if (value !== undefined) kept.set(NAME, typeof value === 'string' ? value : JSON.stringify(value));
  return import(`../../static/store/edits.js?${++pages}`);
}

const ENTRY = {
  client: 'ab'.repeat(12),
  n: 3,
  message: { do: 'key' },
  file: null,
  look: {},
  server: 's',
  revision: 'r',
};
const sent = (edits) => edits.due(1).map((message) => message.do);

test('what a page has not sent, the next page of its tab sends', async () => {
  (await page()).keep({ do: 'key' });
  const edits = await page(kept.get(NAME));
  assert.deepEqual(sent(edits), ['key']);
});

test('what is of another shape is left out, and everything else goes on', async () => {
  const wrong = [
    null,
    7,
    'text',
    [],
    {},
    { ...ENTRY, message: null },
    { ...ENTRY, message: { do: 7 } },
    { ...ENTRY, client: 7 },
    { ...ENTRY, n: 0 },
    { ...ENTRY, n: '3' },
    { ...ENTRY, file: {} },
    { ...ENTRY, file: 'path' },
    { ...ENTRY, look: null },
    { ...ENTRY, over: 'later' },
    { ...ENTRY, server: 7 },
    { ...ENTRY, revision: {} },
  ];
  const edits = await page({ version: 1, entries: [...wrong, ENTRY] });
  edits.keep({ do: 'unkey' });
  assert.deepEqual(sent(edits), ['key', 'unkey']);
});

test('what another version, or nobody, has kept is not taken for edits', async () => {
  for (const value of ['{', 'null', '7', [ENTRY], { version: 2, entries: [ENTRY] }, { version: 1, entries: {} }]) {
    const edits = await page(value);
    edits.keep({ do: 'unkey' });
    assert.deepEqual(sent(edits), ['unkey'], JSON.stringify(value));
  }
});

test('an edit is past once the document stands as a later one of this page has left it', async () => {
  const edits = await page();
  const n = edits.keep({ do: 'delete_key', frame: 0 });
  const [{ client }] = JSON.parse(kept.get(NAME)).entries;
  const { server } = await import('../../static/store/state.js');
  for (const [revision, isNewest, isPast] of [
    [`${client}:${n}`, true, false],
    [`${client}:${n + 1}`, false, true],
    [`another:${n + 1}`, false, false],
    ['', false, false],
  ]) {
    server.revision = revision;
    assert.deepEqual([edits.isNewest(n), edits.isPast(n)], [isNewest, isPast], revision);
  }
});
