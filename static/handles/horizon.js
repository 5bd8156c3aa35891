// Drawing the horizon: a line over the picture, pulled at its two handles or moved as a whole. As long
// as a tool is in hand, the horizon of what counts as up is there to begin with. One tool sets what is up,
// the other corrects a camera that moves.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { server, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { interaction } from './interaction.js';
import { distance, pathOf } from './space.js';

const HANDLE_PX = 6;
const REACH_PX = 14;
const BEGINS_PX = 4;
const SHORTEST_PX = 12;
const KEY_STEPS = { arrowup: -1, arrowdown: 1 };
/** Of the picture's height. */
const KEY_STEP = 0.005;

/** @typedef {import('../store/shapes.js').Spot} Spot */
/** @typedef {[Spot, Spot]} Line */

/** The line in the picture's pixels: as it is being drawn, or of what is up. */
const lineNow = () => interaction.sketch.hold?.line ?? server.camera.horizon;

/** @returns {Line} */
const onScreen = (view, [a, b]) => [view.fromView(a), view.fromView(b)];

/** The handle under a place of the view, 'line' between them, or null. */
function gripAt(view, at) {
  const line = lineNow();
  if (!line || !at) return null;
  const ends = onScreen(view, line);
  const nearest = distance(ends[0], at) < distance(ends[1], at) ? 0 : 1;
  if (distance(ends[nearest], at) <= REACH_PX) return nearest;
  return offLine(ends, at) <= REACH_PX / 2 ? 'line' : null;
}

function offLine([[ax, ay], [bx, by]], [x, y]) {
  return Math.abs((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / Math.hypot(bx - ax, by - ay);
}

/**
 * A tool that draws this line. `what` is the message with which it is sent; `words` say what to do.
 * @param {'horizon' | 'camera_horizon'} what  @param {() => string} words
 * @returns {import('./drawing_tool.js').Tool}
 */
function lineTool(what, words) {
  /** @param {Line} line */
  const sendLine = ([a, b]) => send({ do: what, a, b });
  return {
    icon: 'floor',
    hints: [
      ['Drag', 'along the horizon, its ends, the line'],
      ['Alt ↑ ↓', 'move, with Shift turn'],
      ['Esc', 'done'],
    ],
    words,
    /** On a handle, on the line, or where another line begins. */
    down(view, x, y) {
      const grip = gripAt(view, [x, y]);
      interaction.sketch.hold = { grip, from: view.toView([x, y]), at: [x, y], before: lineNow(), line: null };
    },
    move,
    /** What is too short is no line. */
    up(view, x, y) {
      move(view, x, y);
      const { line } = interaction.sketch.hold;
      interaction.sketch.hold = null;
      if (!line) return;
      const [a, b] = onScreen(view, line);
      if (distance(a, b) >= SHORTEST_PX) sendLine(line);
    },
    cancel: () => void (interaction.sketch.hold = null),
    /** Alt with up or down moves the line, with Shift its right end. */
    key({ altKey, shiftKey }, name) {
      const way = KEY_STEPS[name];
      const line = server.camera.horizon;
      if (!altKey || !way || !line) return false;
      const step = way * Math.max(1, KEY_STEP * server.camera.height);
      const [[left, high], [right, low]] = line;
      sendLine([
        [left, shiftKey ? high : high + step],
        [right, low + step],
      ]);
      return true;
    },
    cursor: (view) => (hotGrip(view) === null ? 'crosshair' : 'move'),
    draw,
  };
}

/** It says what is up in the world. In the guide its card says what to do. */
export const horizon = lineTool('horizon', () =>
  ui.guideStep === null ? 'Drag along the horizon, or pull the line. The floor comes under the lower foot here.' : '',
);

/** It says how the camera is turned at this frame; what is up in the world stays. */
export const cameraHorizon = lineTool('camera_horizon', () =>
  server.view.frame === 0
    ? 'The first frame is the world’s own. Go to a frame where the line is off the horizon.'
    : `Pull the line onto the horizon: the camera is turned at frame ${server.view.frame}, what is up stays.`,
);

const hotGrip = (view) => interaction.sketch.hold?.grip ?? gripAt(view, interaction.sketch.pointer);

/** The pointer moved, with something in hand or not. */
function move(view, x, y) {
  const { hold } = interaction.sketch;
  if (!hold || (!hold.line && distance(hold.at, [x, y]) < BEGINS_PX)) return;
  hold.line = changed(hold, view.toView([x, y]));
}

function changed({ grip, from, before }, to) {
  if (grip === null) return [from, to];
  if (grip === 'line') return before.map(([u, v]) => [u + to[0] - from[0], v + to[1] - from[1]]);
  return before.map((end, i) => (i === grip ? to : end));
}

function draw(view) {
  const line = lineNow();
  if (!line) return nothing;
  const ends = onScreen(view, line);
  const hot = hotGrip(view);
  const path = pathOf(across(ends));
  return svg`<g class="sketch horizon">
    <path class="line-edge" d=${path} /><path class="line" d=${path} />
    ${ends.map(
      ([x, y], i) => svg`<circle class="corner ${i === hot ? 'hot' : ''}" cx=${x} cy=${y} r=${HANDLE_PX}
      data-horizon=${i} />`,
    )}
  </g>`;
}

/** A line beyond its two ends, as far as any view reaches. */
function across([[ax, ay], [bx, by]]) {
  const far = 10_000 / Math.max(1, Math.hypot(bx - ax, by - ay));
  const along = [far * (bx - ax), far * (by - ay)];
  return [
    [ax - along[0], ay - along[1]],
    [bx + along[0], by + along[1]],
  ];
}
