// Handles that lie over each other: which is meant, and in which order further presses go through them.

import './browser.js';
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { after, asBefore, likeliestFirst, meant, whichOf } from '../../static/handles/targets.js';

const handle = (part) => ({ key: `grip:${part}`, part });
const [hand, hip, knee] = ['hand', 'hip', 'knee'].map(handle);
const found = (...misses) =>
  [hand, hip, knee].map((target, i) => ({ target, miss: misses[i] })).filter(({ miss }) => miss !== undefined);

test('the nearest is meant, unless the selected part’s lies as near', () => {
  assert.deepEqual(likeliestFirst(found(0.1, 0.2, 0.3), null), [hand, hip, knee]);
  assert.deepEqual(likeliestFirst(found(0.1, 0.2, 0.3), 'knee'), [knee, hand, hip]);
  assert.deepEqual(likeliestFirst(found(0.1, 0.2, 0.6), 'knee'), [hand, hip, knee]);
});

test('a further press goes on to the next, and after the last to the first', () => {
  const stack = [hand, hip, knee];
  assert.equal(after(stack, hand), hip);
  assert.equal(after(stack, knee), hand);
  assert.equal(whichOf(stack, hip), '2 of 3');
  assert.equal(whichOf([hip], hip), '');
});

test('the chosen one is meant as long as it lies there', () => {
  const chosen = { view: 'main', key: hip.key, order: [hand, hip].map(({ key }) => key) };
  assert.equal(meant([hand, hip], chosen), hip);
  assert.equal(meant([hand, knee], chosen), hand);
  assert.equal(meant([], chosen), null);
});

test('the order stays while the pointer trembles, and is another where other handles lie', () => {
  const chosen = { view: 'main', key: hip.key, order: [hand, hip].map(({ key }) => key) };
  assert.deepEqual(asBefore([hip, hand], chosen), [hand, hip]);
  assert.deepEqual(asBefore([knee, hip], chosen), [knee, hip]);
  assert.deepEqual(asBefore([knee, hip, hand], chosen), [knee, hip, hand]);
  assert.deepEqual(asBefore([hip, hand], null), [hip, hand]);
});
