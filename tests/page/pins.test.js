// Pins on the page: which one is meant, where its bar is grabbed, what is sent.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import { server } from '../../static/store/state.js';
import * as pins from '../../static/actions/pins.js';
import { labelOf, whyNot } from '../../static/actions/actions.js';
import * as marks from '../../static/timeline/marks/pins.js';
import * as scale from '../../static/timeline/draw/scale.js';

const foot = { name: 'left_foot', label: 'Left foot', short: 'Foot', side: 'L', landmarks: ['left_toe', 'left_heel'] };
const hand = { name: 'left_hand', label: 'Left hand', short: 'Hand', side: 'L', landmarks: [] };
const chest = { name: 'chest', label: 'Chest', short: 'Chest', side: 'C', landmarks: [] };
const pin = (first, last, more = {}) => ({
  part: 'left_foot',
  label: 'Left foot',
  side: 'L',
  landmarks: ['left_heel', 'left_toe'],
  point_m: null,
  first,
  last,
  floor: false,
  sole: [],
  slides_cm: null,
  keyframe: null,
  problem: '',
  ...more,
});
const row = { y: 100, h: 30, thin: false };

beforeEach(() => {
  const ends = ['left_foot', 'left_hand'].map((name) => ({ kind: 'end', part: name, name }));
  Object.assign(server, {
    file: { frames: 101 },
    view: { frame: 30, selected: 'left_foot' },
    keys: { frames: [0, 50], drafts: [], soft: [50] },
    body: { parts: [foot, hand, chest], handles: ends },
    pins: [pin(0, 20), pin(40, 60)],
    proposed_pins: [],
  });
  scale.setWidth(scale.left() + 1000 + 26);
});

test('a foot is held whole by heel and toe, in this order; a hand has no sole', () => {
  assert.deepEqual(pins.wholeFoot(foot), ['left_heel', 'left_toe']);
  assert.ok(pins.isFoot(foot) && !pins.isFoot(hand) && pins.isEnd(hand) && !pins.isEnd(chest));
});

test('one pin is here, or else the nearest is meant', () => {
  assert.equal(pins.pinHere(foot), undefined);
  assert.equal(pins.pinMeant(foot), 0);
  server.view.frame = 45;
  assert.equal(pins.pinHere(foot), 1);
  assert.equal(pins.pinMeant(hand), undefined);
});

test('one pins only a hand or a foot with the key, but unpins whatever is pinned', () => {
  server.view.selected = 'chest';
  assert.equal(whyNot('pin'), 'Select a foot or a hand to pin it');
  server.pins = [pin(10, 40, { part: 'chest' })];
  assert.equal(whyNot('pin'), '');
  assert.equal(labelOf('pin'), 'Unpin');
});

test('a keyframe is softened, and made exact again', () => {
  assert.equal(labelOf('softKey', 0), 'Make the keyframe approximate');
  assert.equal(labelOf('softKey', 50), 'Make the keyframe exact');
  assert.equal(whyNot('softKey', 7), 'Frame 7 is not a keyframe');
});

test('keyframes that pins contradict by more than is seen are softened together', () => {
  assert.equal(whyNot('softKeys'), 'No pin contradicts a keyframe');
  const found = { kind: 'pin', words: '', part: 'left_foot', first: 0, last: 60, remedy: 'soften' };
  server.space = [
    { ...found, go: 50, cm: 36, keyframes: [0, 50] },
    { ...found, go: 24, cm: 2, keyframes: [24] },
  ];
  assert.deepEqual(pins.contradicted(), [0, 50]);
  assert.equal(whyNot('softKeys'), '');
  assert.equal(labelOf('softKeys'), 'Relax 2 keyframes');
  assert.equal(labelOf('softKeys', [24]), 'Relax the keyframe');
  server.space = [];
});

const hit = (mark, place, there = row) => mark.hit(place, { rows: { pins: there } }) || null;
const pinAt = (place, there) => hit(marks.pin, place, there);

test('a bar is pulled at its ends and moved by its middle', () => {
  const at = (frame) => pinAt({ x: scale.x(frame), y: 125 });
  assert.deepEqual(at(40), { index: 1, end: 'first' });
  assert.deepEqual(at(50), { index: 1, end: 'middle' });
  assert.deepEqual(at(60), { index: 1, end: 'last' });
  assert.equal(at(30), null);
  assert.equal(pinAt({ x: scale.x(50), y: 95 }), null);
  assert.equal(pinAt({ x: scale.x(50), y: 101 }, { ...row, thin: true, h: 3 }), null);
});

test('where two pins touch, each end is the one on its own side', () => {
  server.pins = [pin(0, 39), pin(40, 60)];
  assert.deepEqual(pinAt({ x: scale.x(39) - 2, y: 125 }), { index: 0, end: 'last' });
  assert.deepEqual(pinAt({ x: scale.x(40) + 2, y: 125 }), { index: 1, end: 'first' });
});

test('what is proposed is no pin yet', () => {
  server.proposed_pins = [pin(70, 90)];
  assert.equal(pinAt({ x: scale.x(80), y: 125 }), null);
  assert.deepEqual(hit(marks.proposal, { x: scale.x(80), y: 125 }), { part: 'left_foot', first: 70 });
  assert.equal(labelOf('acceptPins'), 'Accept');
  assert.deepEqual(pins.acceptMessage(server.proposed_pins[0]), { do: 'accept_pins', part: 'left_foot', first: 70 });
  assert.deepEqual(pins.acceptMessage(), { do: 'accept_pins' });
  server.proposed_pins = [pin(70, 80), pin(85, 90)];
  assert.equal(labelOf('acceptPins'), 'Accept all 2');
});

test('hand and foot of one side share the height of their bar', () => {
  server.pins = [pin(0, 60), pin(0, 60, { part: 'left_hand', landmarks: [] })];
  const index = (y) => pinAt({ x: scale.x(30), y })?.index;
  assert.equal(index(118), 0);
  assert.equal(index(126), 1);
});
