// The marks of the timeline: which of them a pointer means, and that each is whole.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import * as selection from '../../static/actions/selection.js';
import { showAll, showFrames } from '../../static/actions/window.js';
import { server, ui } from '../../static/store/state.js';
import { bodiesHeight, rowHeight } from '../../static/timeline/marks/bodies.js';
import { filmsHeight } from '../../static/timeline/marks/films.js';
import { MARKS, under } from '../../static/timeline/marks.js';
import * as scale from '../../static/timeline/draw/scale.js';

const WIDTH = scale.left() + 1000 + 26;

/** What the drawing stands on: 400 px high, with two lanes and rows of pins, the camera, another body and film. */
function stage() {
  const lanes = [
    { label: 'Arm', parts: ['hand'] },
    { label: 'Leg', parts: ['foot'] },
  ];
  const zoomed = ui.timeWindow !== null;
  return {
    rows: scale.rowsFor({
      height: 400,
      zoomed,
      lanes: 2,
      weakest: false,
      pins: true,
      camera: true,
      bodies: bodiesHeight(),
      films: filmsHeight(),
    }),
    lanes,
    scroll: 0,
    empty: false,
  };
}

beforeEach(() => {
  const [pin, proposed] = [
    { part: 'foot', label: 'Foot', side: 'L', landmarks: [], first: 10, last: 30, problem: '', keyframe: null },
    { part: 'foot', label: 'Foot', side: 'L', landmarks: [], first: 60, last: 80, problem: '' },
  ];
  Object.assign(server, {
    file: { frames: 101, path: '/a' },
    view: { frame: 0 },
    body: { parts: [{ name: 'shin', tracked: ['rx'], words: {} }] },
    keys: {
      frames: [20, 40, 60],
      drafts: [],
      soft: [],
      parts: [
        { frame: 50, limbs: [] },
        { frame: 70, limbs: [] },
      ],
    },
    notes: [{ frame: 20, text: 'one' }],
    pins: [pin],
    proposed_pins: [proposed],
    draft: { proposals: [{ frame: 70 }, { frame: 85 }] },
    segments: [{ first: 20, last: 40, state: 'good' }],
    review: { places: [{ id: 'a', frame: 20, kind: 'draft', px: 99 }], goal: 0 },
    camera_motion: {
      counts: true,
      keys: [40],
      error_px: [],
      findings: [
        { kind: 'no_texture', first: 50, last: 60, words: '' },
        { kind: 'rolling_shutter', first: 0, last: 100, words: '' },
      ],
    },
    bodies: [
      { id: 'p', name: 'Ann', posed: true, keys: [20, 40, 60], places: [], segments: [] },
      { id: 'q', name: 'Racket', posed: false, keys: [10, 30], places: [90], segments: [], open: 1, worst: null },
    ],
    bonds: [{ index: 3, holder: { body: 'p', part: 'hand' }, held: { body: 'q', part: 'grip' }, first: 40, last: 50 }],
    films: [{ id: 'b', name: 'side.mp4', frames: 41, frame: 0, begins: 20, rate: 0.5, sigma: 0.1, also: [70] }],
    films_seen: { seen: { a: [[0, 100]], b: [[30, 60]] }, disagree: [[40, 44]], places: {} },
    curve: { part: 'shin', x: Array.from({ length: 101 }, (_, i) => i) },
    done: 1e9,
  });
  Object.assign(ui, { span: { first: null, last: null }, chart: 'angle', curveAxis: 'x', reviewLeft: false });
  scale.setWidth(WIDTH);
  showAll();
  selection.selectKeys([]);
});

const kindAt = (frame, y, off = 0) => under({ x: scale.x(frame) + off, y }, stage()).what.kind;
const middle = () => stage().rows.keys.middle;

test('each mark is found where it is drawn, and the frames everywhere else', () => {
  const { rows } = stage();
  const found = [
    ['note', kindAt(20, scale.RULER - 4)],
    ['frames', kindAt(30, scale.RULER - 4)],
    ['key', kindAt(20, middle())],
    ['part', kindAt(50, middle())],
    ['place', kindAt(85, middle())],
    ['segment', kindAt(30, middle())],
    ['box', kindAt(30, middle() + 12)],
    ['box', kindAt(95, middle())],
    ['pin', kindAt(20, rows.pins.y + 20)],
    ['proposal', kindAt(70, rows.pins.y + 20)],
    ['body', kindAt(30, rows.bodies.y + 9)],
    ['bond', kindAt(44, rows.bodies.y + 17)],
    ['body', kindAt(60, rows.bodies.y + 17)],
    ['camera_key', kindAt(40, rows.camera.y + 9)],
    ['camera_finding', kindAt(55, rows.camera.y + 9)],
    ['camera', kindAt(80, rows.camera.y + 9)],
    ['film', kindAt(50, rows.films.y + 16)],
    ['film_minimum', kindAt(70, rows.films.y + 16)],
    ['frames', kindAt(10, rows.films.y + 16)],
    ['lane', kindAt(90, rows.lanes.y + 2)],
    ['frames', kindAt(90, rows.curve.y + 2)],
    ['curvekey', kindAt(20, rows.curve.y + 6 + ((rows.curve.h - 12) * (106 - 20)) / 112)],
    ['edge', kindAt(0, middle(), -60)],
    ['edge', kindAt(0, rows.lanes.y, -60)],
  ];
  for (const [kind, there] of found) assert.equal(there, kind);
});

test('what parts of the posed body hold of each other has a row of its own below the other bodies', () => {
  const { rows: before } = stage();
  const own = (part) => ({ body: 'p', part, name: 'Ann', label: part });
  server.bonds = [...server.bonds, { index: 4, holder: own('hand'), held: own('trunk'), first: 60, last: 70 }];
  const { rows } = stage();
  assert.equal(rows.bodies.h, 2 * before.bodies.h);
  const at = (frame, y) => under({ x: scale.x(frame), y }, stage()).what;
  const y = rows.bodies.y + before.bodies.h + 17;
  assert.deepEqual([at(61, y).kind, at(61, y).index], ['bond', 4]);
  assert.equal(at(44, y).kind, 'body', 'the other one lies in the row of the body that is held');
  assert.equal(at(61, rows.bodies.y + 17).kind, 'body');
});

test('more than four bodies have lower rows, each found where it is drawn', () => {
  assert.deepEqual([1, 4].map(rowHeight), [20, 20]);
  const beside = Array.from({ length: 9 }, (_, at) => ({ ...server.bodies[1], id: `q${at}`, keys: [] }));
  server.bodies = [server.bodies[0], ...beside];
  server.bonds = [];
  const { rows } = stage();
  assert.equal(rows.bodies.h, 90);
  const found = beside.map((_, at) => under({ x: scale.x(30), y: rows.bodies.y + 10 * at + 5 }, stage()).what.id);
  assert.deepEqual(
    found,
    beside.map(({ id }) => id),
  );
});

test('where marks lie over each other, the one listed first is meant', () => {
  ui.reviewLeft = true;
  assert.equal(kindAt(20, scale.RULER), 'note', 'before a place to review');
  assert.equal(kindAt(20, scale.RULER + 5), 'review', 'before a keyframe');
  assert.equal(kindAt(70, middle()), 'part', 'before a place to confirm');
  server.keys = { ...server.keys, frames: [20, 40, 51, 60] };
  assert.equal(kindAt(50, middle()), 'key', 'before a part keyframe');
  selection.selectKeys([40, 60]);
  assert.equal(kindAt(40, middle(), -9), 'keys', 'the grip of a selection before the keyframe at its side');
  ui.span = { first: 20, last: null };
  assert.equal(kindAt(20, scale.RULER - 4, -4), 'span', 'the in point before a note');
});

test('while zoomed the strip of the whole film lies before the keyframes that reach under it', () => {
  showFrames(10, 60);
  assert.equal(kindAt(40, scale.RULER + 3), 'overview');
  assert.equal(kindAt(20, scale.RULER - 1), 'overview', 'and before notes');
  selection.selectKeys([40, 60]);
  assert.equal(kindAt(40, scale.RULER + 7, -9), 'keys', 'but not before the grips of a selection');
});

test('the chart of passes has no frames to grab', () => {
  ui.chart = 'score';
  const { mark } = under({ x: scale.x(90), y: stage().rows.curve.y + 2 }, stage());
  assert.equal(mark.kind, 'score');
  assert.equal(mark.grab, undefined);
});

test('kinds differ, and what can be grabbed and hovered says how it looks', () => {
  assert.equal(new Set(MARKS.map(({ kind }) => kind)).size, MARKS.length);
  assert.equal(MARKS.at(-1).kind, 'frames');
  for (const mark of MARKS) assert.ok(!mark.edits || (mark.drag && mark.tip && mark.cursor && mark.menu), mark.kind);
});
