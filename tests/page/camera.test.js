// What is known of how the film's camera moves, and what can be done about it.

import './browser.js';
import assert from 'node:assert/strict';
import { beforeEach, test } from 'node:test';
import * as camera from '../../static/actions/camera.js';
import { filmSteps } from '../../static/guide/film_steps.js';
import { cameraMatch } from '../../static/handles/match.js';
import { interaction } from '../../static/handles/interaction.js';
import { server } from '../../static/store/state.js';

const TURNS = {
  kind: 'turns',
  counts: true,
  words: 'The camera turns.',
  error_px: [0.1, null, 0.2],
  keys: [2],
  findings: [],
  path: null,
};

beforeEach(() => {
  Object.assign(server, {
    file: { frames: 60 },
    surface: null,
    camera: { up_origin: 'drawn', fx: 100, fy: 100, cx: 50, cy: 50 },
    camera_here: null,
    view: { frame: 4 },
    job: { state: 'idle' },
    settings: { static_camera: null, found_still: null },
    camera_motion: null,
  });
});

/** What is found, what a person says, the motion, how it moves, what is said, whether it is worth finding. */
const KNOWN = [
  [null, null, null, null, /Nobody has looked/, false],
  [true, null, null, 'static', /stands still\.$/, false],
  [false, null, null, null, /not known yet/, true],
  [false, null, TURNS, 'turns', /^The camera turns/, false],
  [false, true, { ...TURNS, counts: false }, 'static', /as you said/, false],
  [true, false, null, null, /not known yet/, true],
  [true, false, TURNS, 'turns', /^The camera turns/, false],
];

test('what a person says counts more than what was found, and a motion only while the camera moves', () => {
  for (const [found, said, motion, kind, words, isUnknown] of KNOWN) {
    Object.assign(server, { settings: { static_camera: said, found_still: found }, camera_motion: motion });
    assert.equal(camera.cameraKind(), kind);
    assert.match(camera.cameraWords(), words);
    assert.equal(camera.isCameraUnknown(), isUnknown);
  }
});

test('it is said why the camera cannot be found, corrected or left', () => {
  assert.equal(camera.whyNotFindCamera(), '');
  assert.match(camera.whyNotMatchCamera(), /Find the camera/);
  assert.match(camera.whyNotForgetCamera(), /No motion/);
  server.camera_motion = TURNS;
  assert.equal(camera.whyNotForgetCamera() + camera.whyNotMatchCamera() + camera.whyNotCameraHorizon(), '');
  assert.equal(camera.whyNoCameraKey(2), '');
  assert.match(camera.whyNoCameraKey(), /not corrected at frame 4/);
  server.camera = { up_origin: 'camera' };
  assert.match(camera.whyNotCameraHorizon(), /what is up/);
  server.job = { state: 'running', kind: 'camera' };
  assert.match(camera.whyNotFindCamera(), /being found/);
  Object.assign(server, { surface: {}, job: { state: 'idle' } });
  assert.match(camera.whyNotFindCamera(), /Surfaces/);
});

test('the guide asks for the camera only where it was found to move', () => {
  const words = () => filmSteps().map(({ word }) => word);
  for (const [found, said, asks] of [
    [null, null, false],
    [true, null, false],
    [false, null, true],
    [false, true, false],
  ]) {
    server.settings = { static_camera: said, found_still: found };
    assert.equal(words().includes('Camera'), asks);
    assert.equal(words().at(-1), 'Review');
  }
});

test('the camera’s step of the guide can be skipped once, not by two buttons while it is being found', () => {
  server.settings = { static_camera: null, found_still: false };
  const step = filmSteps().find(({ word }) => word === 'Camera');
  assert.deepEqual([step.choices.map(({ label }) => label), step.next().label], [['Skip'], 'Find its motion']);
  server.job = { state: 'running', kind: 'camera' };
  assert.deepEqual([step.choices, step.next()], [undefined, null]);
});

const view = { toView: (at) => at, fromView: (at) => at };

function click(x, y) {
  cameraMatch.down(view, x, y);
  cameraMatch.up(view, x, y);
}

test('points of two frames can be sent once all are marked in both', () => {
  interaction.sketch = { tool: 'cameraMatch', points: [], pointer: null, hold: null };
  cameraMatch.forget();
  click(10, 10);
  click(90, 20);
  assert.equal(cameraMatch.done(), null, 'there is no other frame yet');
  server.view = { frame: 7 };
  click(12, 10);
  assert.match(cameraMatch.done().off, /1 more point/);
  assert.match(cameraMatch.words(), /point 2 of frame 4/);
  click(92, 21);
  assert.equal(cameraMatch.done().off, '');
  click(50, 50);
  cameraMatch.key({}, 'backspace');
  assert.match(cameraMatch.done().off, /1 more point/, 'a third one was none, so that the second is the last');
  server.view = { frame: 0 };
  assert.match(cameraMatch.done().off, /first frame/);
});

test('a ring shows where the camera of another frame should see a point', () => {
  interaction.sketch = { tool: 'cameraMatch', points: [], pointer: null, hold: null };
  cameraMatch.forget();
  click(60, 50);
  const rings = () => cameraMatch.draw(view).values[0];
  assert.equal(rings().length, 0, 'none where it was marked');
  const turn = Math.atan(0.1); // to the right, until it is in the middle
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  Object.assign(server, { view: { frame: 9 }, camera_here: [c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0] });
  const [x, y] = rings()[0].values;
  assert.ok(Math.abs(x - 50) < 1e-9 && Math.abs(y - 50) < 1e-9);
  click(51, 50);
  assert.equal(rings().length, 0, 'it is marked');
});

test('a point that was marked is pulled, and goes back where the drag is cancelled', () => {
  interaction.sketch = { tool: 'cameraMatch', points: [], pointer: null, hold: null };
  cameraMatch.forget();
  click(10, 10);
  const at = () => cameraMatch.draw(view).values[1][0].values[1];
  const before = at();
  cameraMatch.down(view, 12, 12);
  cameraMatch.move(view, 40, 30);
  assert.notEqual(at(), before);
  cameraMatch.cancel();
  assert.equal(at(), before);
});
