// The guide for a new film: whom it offers to draft, and what is posed by hand instead.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { otherBodies, takeBody } from '../../static/guide/film_steps.js';
import { steps } from '../../static/guide/steps.js';
import { server, ui } from '../../static/store/state.js';

const BOX = [10, 20, 30, 80];
const PRESETS = [
  { name: 'adult_male', label: 'Adult male', kind: 'adult' },
  { name: 'child', label: 'Child', kind: 'child' },
  { name: 'child_12', label: 'Child 12', kind: 'child' },
  { name: 'dog', label: 'Dog', kind: 'animal' },
  { name: 'box', label: 'Box', kind: 'object' },
];

beforeEach(() => {
  server.body = { presets: PRESETS };
  Object.assign(ui, { box: BOX, tool: 'box', guidePath: 'film', guideStep: 2 });
});

test('all bodies but those of adults are offered', () => {
  assert.deepEqual(
    otherBodies().map(({ label }) => label),
    ['Child', 'Child 12', 'Dog', 'Box'],
  );
});

test('every child is drafted in the box that is drawn; what is posed by hand needs no box', () => {
  for (const preset of otherBodies()) {
    Object.assign(ui, { box: BOX, tool: 'box' });
    takeBody(preset);
    const isDrafted = preset.name.startsWith('child');
    assert.deepEqual([ui.box, ui.tool], isDrafted ? [BOX, 'box'] : [null, 'move']);
  }
});

test('a thing has a guide of its own, from its first step', () => {
  takeBody(PRESETS[3]);
  assert.deepEqual([ui.guidePath, ui.guideStep], ['film', 2]);
  takeBody(PRESETS[4]);
  assert.deepEqual([ui.guidePath, ui.guideStep, ui.tab], ['thing', 0, 'part']);
});

test('what is posed by hand is called what it is', () => {
  const words = (/** @type {object} */ body) => {
    Object.assign(server, { body: { presets: PRESETS, parts: [{}, {}], ...body } });
    ui.guidePath = 'hand';
    return steps()
      .map(({ title, text }) => `${title} ${text}`)
      .join(' ');
  };
  const ofPerson = words({ is_persons: true });
  const ofAnimal = words({ is_animals: true });
  assert.match(ofPerson, /the hips of the person.*the size of the person.*hands and feet/s);
  assert.match(ofAnimal, /the hips of the animal.*the size of the animal.*paws or hooves/s);
  assert.doesNotMatch(ofAnimal, /person/);
});
