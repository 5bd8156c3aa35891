// Points of the background that two frames share: marked at one frame, and the same ones, in the same
// order, at another, where rings show where its camera should see them. It is turned until they meet.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { count } from '../controls/words.js';
import { server } from '../store/state.js';
import { send } from '../store/link.js';
import { moved, movedBack } from '../views/world.js';
import { interaction } from './interaction.js';
import { distance } from './space.js';

const REACH_PX = 11;
const RADIUS = 9;
const FEWEST = 2;
const MOST = 100;
/** The background is taken to be so far away. */
const FAR_M = 1000;

/** @typedef {import('../store/shapes.js').Spot} Spot */
/** @typedef {{ frame: number, spots: Spot[], camera: import('../store/shapes.js').Camera, T: number[] | null }} Marked
 *   `T` is T_world_camera of its frame. */

/** The points at the first frame, and those at the frame that is corrected. @type {Marked | null} */
let first = null;
/** @type {Marked | null} */
let second = null;

const frame = () => server.view.frame;

/** Those of the present frame; null before any is marked here. */
function here() {
  return [first, second].find((marked) => marked?.frame === frame()) ?? null;
}

const isFirst = () => first === null || first.frame === frame();
const missing = () => (isFirst() ? FEWEST : first.spots.length) - (here()?.spots.length ?? 0);

/** @type {import('./drawing_tool.js').Tool} */
export const cameraMatch = {
  icon: 'link',
  hints: [
    ['Click', 'mark a point'],
    ['Drag', 'move one'],
    ['← →', 'another frame'],
    ['Enter', 'correct the camera'],
    ['Backspace', 'remove the last'],
    ['Esc', 'done'],
  ],
  words() {
    const next = (here()?.spots.length ?? 0) + 1;
    if (isFirst()) {
      return missing() > 0
        ? `Click point ${next} of the background, sharp and far from the others.`
        : 'Go to another frame and click the same points in the same order, or click more here.';
    }
    return missing() > 0
      ? `Click where point ${next} of frame ${first.frame} is seen here.`
      : 'All points are marked. Drag what is off.';
  },
  done() {
    if (isFirst()) return null;
    return { label: 'Correct the camera here', key: 'Enter', off: whyNot(), act: correct };
  },
  down(view, x, y) {
    interaction.sketch.hold = gripAt(view, [x, y]) ?? { index: null };
  },
  move(view, x, y) {
    const { hold } = interaction.sketch;
    if (hold && hold.index !== null) put(hold.index, view.toView([x, y]));
  },
  up(view, x, y) {
    const { hold } = interaction.sketch;
    interaction.sketch.hold = null;
    if (hold?.index === null) mark(view.toView([x, y]));
  },
  /** A point that was being moved goes back. */
  cancel() {
    const { hold } = interaction.sketch;
    interaction.sketch.hold = null;
    if (hold && hold.index !== null) put(hold.index, hold.before);
  },
  forget() {
    first = null;
    second = null;
  },
  key(_, name) {
    if (name === 'enter') correct();
    else if (name === 'backspace' || name === 'delete') removeLast();
    else return false;
    return true;
  },
  cursor: (view) => (interaction.sketch.pointer && gripAt(view, interaction.sketch.pointer) ? 'move' : 'crosshair'),
  draw,
};

function whyNot() {
  if (frame() === 0) return 'The first frame is the world’s own: begin there, and correct another';
  return missing() > 0 ? `Mark ${count(missing(), 'more point')} here` : '';
}

/** The point under a place of the view: {index, before}; null. */
function gripAt(view, at) {
  const spots = here()?.spots ?? [];
  const index = spots.findIndex((spot) => distance(view.fromView(spot), at) <= REACH_PX);
  return index < 0 ? null : { index, before: spots[index] };
}

/** @param {Marked} marked */
function keep(marked) {
  if (marked.frame === first?.frame || first === null) first = marked;
  else second = marked;
}

/** @param {Spot} spot */
function mark(spot) {
  const spots = here()?.spots ?? [];
  if (spots.length >= MOST || (!isFirst() && missing() <= 0)) return;
  keep({ frame: frame(), camera: server.camera, T: server.camera_here, spots: [...spots, spot] });
}

/** @param {number} index  @param {Spot} spot */
function put(index, spot) {
  const marked = here();
  if (marked) keep({ ...marked, spots: marked.spots.map((old, i) => (i === index ? spot : old)) });
}

/** Without any point the first frame is open again. */
function removeLast() {
  const marked = here();
  if (!marked) return;
  const spots = marked.spots.slice(0, -1);
  if (marked === first && !spots.length) cameraMatch.forget();
  else keep({ ...marked, spots });
}

/** What is marked at the first frame stays, for a next one. */
function correct() {
  if (isFirst() || whyNot()) return;
  send({ do: 'camera_match', other: first.frame, here: second.spots, there: first.spots });
}

function draw(view) {
  const spots = here()?.spots ?? [];
  const left = isFirst() ? [] : first.spots.map((_, i) => i).slice(spots.length);
  return svg`<g class="sketch matched">${left.map((i) => expected(view, i))}${spots.map((spot, i) =>
    numbered(view, spot, i),
  )}</g>`;
}

/** Where the camera's motion has a point of the first frame, which is still to be marked here. */
function expected(view, i) {
  const { fx, fy, cx, cy } = first.camera;
  const [u, v] = first.spots[i];
  const far = [((u - cx) / fx) * FAR_M, ((v - cy) / fy) * FAR_M, FAR_M];
  const [x, y, z] = movedBack(moved(far, first.T), server.camera_here);
  if (z <= 0) return nothing;
  const [sx, sy] = view.fromView([
    server.camera.cx + (server.camera.fx * x) / z,
    server.camera.cy + (server.camera.fy * y) / z,
  ]);
  return svg`<g class="expected"><circle class="ring-edge" cx=${sx} cy=${sy} r=${RADIUS} /><circle class="ring" cx=${sx}
    cy=${sy} r=${RADIUS} />${badge(sx, sy, i)}</g>`;
}

/** A cross at the place, its number beside it. */
function numbered(view, spot, i) {
  const [x, y] = view.fromView(spot);
  const cross = `M${x - RADIUS} ${y}h${RADIUS - 2}M${x + 2} ${y}h${RADIUS - 2}M${x} ${y - RADIUS}v${RADIUS - 2}M${x} ${y + 2}v${RADIUS - 2}`;
  return svg`<g data-match=${i}><path class="line-edge" d=${cross} /><path class="line" d=${cross} />
    ${badge(x, y, i)}</g>`;
}

const badge = (x, y, i) => svg`<circle class="badge" cx=${x + RADIUS + 4} cy=${y - RADIUS - 4} r="8" />
  <text class="badge-number" x=${x + RADIUS + 4} y=${y - RADIUS} text-anchor="middle">${i + 1}</text>`;
