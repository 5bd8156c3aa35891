// A drag under way. The body stays where it was last seen, for how it follows only the server knows.
// Each message says what the drag does from where it began, so that only the newest counts and a lost
// one does no harm.

import { nothing, svg } from '../vendor/lit-html/lit-html.js';
import { paced } from '../controls/gesture.js';
import { newStroke, send } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { interaction, redrawSoon } from './interaction.js';
import { pathOf } from './space.js';

const down = new Set();
const watchers = new Set();
let shift = false;
let control = false;
let alt = false;

/** Listen to the whole page. */
export function watchKeys() {
  // Capture on the window: whatever has the focus, and before any room acts on the key.
  addEventListener('keydown', (event) => note(event, true), true);
  addEventListener('keyup', (event) => note(event, false), true);
  addEventListener('blur', forget);
}

/** Call fn after a key went down or up. */
export function onKeys(fn) {
  watchers.add(fn);
}

/** The key's letter, whatever the shift state or the alphabet of the keyboard. */
export function letterOf(event) {
  const key = event.key.toLowerCase();
  if (/^[a-z]$/.test(key)) return key;
  return event.code.startsWith('Key') ? event.code.slice(3).toLowerCase() : key;
}

/** Whether a key is down: a letter, or " ". */
export const isKeyDown = (key) => down.has(key);

/** Shift as of the newest key or pointer event. */
export const isFine = () => shift;

/** Pointer events know the modifiers too, also those pressed outside the page. */
export function noteModifiers(event) {
  shift = event.shiftKey;
  control = event.ctrlKey || event.metaKey;
  alt = event.altKey;
}

/** What the keys that are down ask of a drag. */
export function modifiers() {
  const axis = ['x', 'y', 'z'].find((letter) => down.has(letter)) ?? null;
  return { snap: control, free: down.has('u'), axis, depth: down.has('d'), carry: alt };
}

function note(event, isDown) {
  noteModifiers(event);
  const key = letterOf(event);
  if (isDown) down.add(key);
  else down.delete(key);
  for (const fn of watchers) fn(event);
}

function forget() {
  down.clear();
  shift = control = alt = false;
}

const RADIUS = 9;

/** Where handles were let go of since the line was lost, by the handle: the newest place of each. */
let left = new Map();

/** Forget the preview once the server shows what it was about. */
export function mountOffline() {
  watch(['u:connected'], () => {
    if (!ui.connected || !left.size) return;
    left = new Map();
    redrawSoon();
  });
}

/** A drag has ended whose moves still wait. */
export function keepPreview(drag) {
  const spot = spotOf(drag);
  if (ui.connected || !spot) return;
  left.set(spot.key, spot);
}

/** The handles that wait for the server, in the view they were dragged in. */
export function drawOffline(view) {
  if (ui.connected) return nothing;
  const now = interaction.drag && spotOf(interaction.drag);
  const spots = [...left.values()].filter(({ key }) => key !== now?.key);
  const shown = [...spots, ...(now ? [now] : [])].filter(
    (spot) => spot.view === view.name && spot.frame === server.view.frame,
  );
  return svg`<g class="offline">${shown.map((spot) => drawSpot(view, spot))}</g>`;
}

/** Where a drag has its handle: {key, view, at, frame, neighbours}; null for one without a place of its own. */
function spotOf(drag) {
  const key = drag.target?.key ?? '';
  const given = server.body?.handles.find(({ name }) => key === `grip:${name}`);
  if (!given) return null;
  const neighbours = neighboursOf(given.anchor, server.body.parts, server.pose.points);
  return { key, view: drag.view, at: drag.toView(drag.virtual), frame: server.view.frame, neighbours };
}

/**
 * The points that a joint or landmark is joined to by parts of the body.
 * @param {string} anchor  Its name: a part's, for its joint, or a landmark's.
 * @param {{ name: string, parent: string | null, landmarks: string[] }[]} parts
 * @param {Record<string, number[]>} points
 */
export function neighboursOf(anchor, parts, points) {
  const part = parts.find(({ name }) => name === anchor);
  const owner = parts.find(({ landmarks }) => landmarks.includes(anchor));
  const names = part
    ? [part.parent, ...parts.filter(({ parent }) => parent === anchor).map(({ name }) => name)]
    : [owner?.name];
  return names.filter((name) => name && points[name]).map((name) => points[name]);
}

function drawSpot(view, { at, neighbours }) {
  const [x, y] = view.fromView(at);
  const lines = neighbours.map((point) => pathOf([view.project(point), [x, y]])).join('');
  return svg`<path class="casing" d=${lines} /><path class="line" d=${lines} />
    <circle class="casing" cx=${x} cy=${y} r=${RADIUS} /><circle class="spot" cx=${x} cy=${y} r=${RADIUS} />
    <text x=${x + RADIUS + 7} y=${y + 4}>Preview</text>`;
}

const PAUSE_MS = 16;
const FINE = 0.1;

/**
 * Begin a drag. `messageAt(at, keys)` gives the action for a pointer at `at` in view coordinates.
 * `extra` is what is drawn of it meanwhile.
 */
export function beginDrag(view, press, messageAt, extra) {
  interaction.drag = {
    ...extra,
    messageAt,
    view: view.name,
    stroke: newStroke('drag'),
    virtual: [press.x, press.y],
    seen: [press.x, press.y],
    toView: (at) => view.toView(at),
  };
  setUi('playing', false);
  setUi('dragging', true);
  setUi('sight', sightOf(view, extra));
  redrawSoon();
}

/** What is dragged along a film's picture is seen from that film's camera. */
function sightOf(view, { target }) {
  const grip = server.body?.handles.find(({ name }) => target?.key === `grip:${name}`);
  const isFilms = view.name === 'main' || view.name === 'film';
  return grip && isFilms ? { anchor: grip.anchor, place: view.eye.place ?? [0, 0, 0] } : null;
}

/** The pointer moved: with Shift the virtual pointer goes a tenth of the way. */
export function moveDrag(event, x, y) {
  const { drag } = interaction;
  noteModifiers(event);
  const share = isFine() ? FINE : 1;
  drag.virtual = drag.virtual.map((v, i) => v + ([x, y][i] - drag.seen[i]) * share);
  drag.seen = [x, y];
  if (!ui.connected) redrawSoon(); // only the page can show where it goes
  sendSoon();
}

/** A key or the pointer changed what the drag does. */
export const sendSoon = paced(() => {
  const { drag } = interaction;
  if (!drag) return;
  send({ ...drag.messageAt(drag.toView(drag.virtual), modifiers()), stroke: drag.stroke });
  drag.sent = true;
}, PAUSE_MS);

export function endDrag() {
  sendSoon.flush();
  finish('end_stroke');
}

/** Everything as it was before. */
export function cancelDrag() {
  sendSoon.drop();
  finish('cancel_stroke');
}

function finish(word) {
  const { drag } = interaction;
  if (!drag) return;
  drag.kept = word === 'end_stroke';
  if (drag.kept) keepPreview(drag);
  if (drag.sent) send({ do: word, stroke: drag.stroke });
  interaction.drag = null;
  if ('limb' in drag) setUi('limb', drag.limb ?? null);
  setUi('dragging', false);
  setUi('sight', null);
  redrawSoon();
}
