// People who are proposed for a box: who is meant, what is said of them, and when they are out of the way.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server, ui } from '../../static/store/state.js';
import {
  isLooking,
  isNobodyHere,
  peopleHere,
  peopleWords,
  personAt,
  personMeant,
  takePerson,
} from '../../static/actions/people.js';

const TALL = [10, 20, 110, 320];
const CHILD = [60, 200, 100, 310];

const found = (...boxes) => void (server.people = { frame: 4, boxes });

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 9, path: 'a' },
    view: { frame: 4 },
    body: { is_persons: true },
    surface: null,
  });
  Object.assign(ui, { tool: 'box', box: null, personHover: null, playing: false });
});

test('a click takes the box of who is there, of several the smallest', () => {
  found(TALL, CHILD);
  assert.equal(personAt([20, 30]), TALL);
  assert.equal(personAt([80, 250]), CHILD);
  assert.equal(personAt([300, 250]), null);
  takePerson(personAt([80, 250]));
  assert.deepEqual(ui.box, CHILD);
});

test('without a click the one who is pointed at is meant, else the tallest', () => {
  found(TALL, CHILD);
  assert.equal(personMeant(), TALL);
  ui.personHover = CHILD;
  assert.equal(personMeant(), CHILD);
  ui.personHover = [1, 2, 3, 4]; // of a frame before
  takePerson();
  assert.deepEqual(ui.box, TALL);
});

test('a box that is there goes before everybody who was found', () => {
  found(TALL);
  ui.box = [1, 2, 30, 90];
  assert.deepEqual(peopleHere(), []);
  takePerson();
  assert.deepEqual(ui.box, [1, 2, 30, 90]);
});

test('people of another frame, or with another tool in hand, are not proposed', () => {
  found(TALL);
  server.view.frame = 5;
  assert.deepEqual(peopleHere(), []);
  server.view.frame = 4;
  ui.tool = 'select';
  assert.deepEqual(peopleHere(), []);
});

test('one line says who was found, or that nobody was, and nothing where nobody has looked', () => {
  found(TALL, CHILD);
  assert.match(peopleWords(), /^2 people found\./);
  found(TALL);
  assert.match(peopleWords(), /^One person found\./);
  found();
  assert.equal(isNobodyHere(), true);
  assert.equal(peopleWords(), 'No person found in this frame. Draw a box, or choose another frame.');
  server.people = { frame: 4, boxes: null };
  assert.equal(peopleWords(), '');
  server.people = null;
  assert.equal(peopleWords(), '');
  assert.equal(isLooking(), false);
});
