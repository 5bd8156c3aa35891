// From pointer events to gestures: one press at a time, captured by its view, in one of these states.
//
//   still      has not moved yet: released now it is a click
//   asking     has moved off a handle's reach; which part lies there is on its way
//   dragging   pulls a handle, a mask or a part
//   aside      the right button, which has not moved yet: released now it opens the menu
//   panning    moves the view, or orbits it
//   sketching  draws with the mask, the vertical, the horizon or the box tool
//   pinching   has a second finger: both move and zoom the view
//   spent      was cancelled: nothing more until the pointer is released

import { perform } from '../actions/actions.js';
import { server, ui } from '../store/state.js';
import { beginOnSurface, beginOnTarget } from './begin.js';
import { cancelDrag, endDrag, isKeyDown, moveDrag, noteModifiers } from './drag.js';
import { interaction } from './interaction.js';
import { hover, leave, pick, renameHandle } from './hover.js';
import { beginPan, endPan, movePan, pinch, wheel } from './pan.js';
import { click } from './select.js';
import { drawsOn, isDrawingTool, sketch, sketchCursor } from './sketch.js';
import { distance } from './space.js';
import { targetAt } from './targets.js';
import { openAt, openWhenPicked } from './viewmenu.js';

const CLICK_PX = 3;
const MIDDLE = 1;
const RIGHT = 2;
const RIGHT_DOWN = 2;

/** @typedef {'still' | 'aside' | 'asking' | 'dragging' | 'panning' | 'sketching' | 'pinching' | 'spent'} State */

/**
 * @typedef {object} Press
 * @property {any} view
 * @property {number} id  Of its pointer.
 * @property {number} button
 * @property {number} x  Where it began, in pixels of the view.
 * @property {number} y
 * @property {State} state
 * @property {any} target  The handle or mask it began on.
 * @property {Promise<{ parts: string[] }> | null} picked  Where there is none: the parts there, front to back.
 * @property {[PointerEvent, number, number]} [newest]  While asking: the last move.
 * @property {boolean} [released]  Released while asking.
 * @property {number} releasedAt  In the milliseconds of performance.now(); 0 until it is.
 */

/** @type {Press | null} */
let press = null;
/** The last click. @type {Press | null} */
let newest = null;
const fingers = new Map();
/** The right button has cancelled a gesture: letting go of it, which may come last, opens no menu. */
let hasCancelled = false;

/**
 * What a move does in each state, what releasing does, and how it is cancelled.
 * @type {Record<State, { move?: (view: any, event: PointerEvent, x: number, y: number) => void,
 *   end?: (done: Press, x: number, y: number) => void, cancel?: () => void }>}
 */
const STATES = {
  still: { move: leaveStill, end: finishClick },
  aside: { move: leaveAside, end: openMenu },
  asking: { move: (_, event, x, y) => void (press.newest = [event, x, y]) },
  dragging: {
    move: (_, event, x, y) => interaction.drag && moveDrag(event, x, y),
    end: () => interaction.drag && endDrag(),
    cancel: () => interaction.drag && cancelDrag(),
  },
  panning: {
    move: (view, _, x, y) => interaction.panning && movePan(view, x, y),
    end: () => interaction.panning && endPan(),
    cancel: () => interaction.panning && endPan(),
  },
  sketching: {
    move: (view, _, x, y) => sketch('move', view, x, y),
    end: ({ view }, x, y) => sketch('up', view, x, y),
    cancel: () => sketch('cancel'),
  },
  pinching: {}, // moved by both fingers
  spent: {},
};

/** Listen to a view's pointer. */
export function listenTo(view) {
  const { over } = view;
  over.addEventListener('pointerdown', (event) => down(view, event));
  over.addEventListener('pointermove', (event) => move(view, event));
  over.addEventListener('pointerup', (event) => up(view, event));
  over.addEventListener('pointercancel', (event) => onPointerLost(event));
  over.addEventListener('pointerleave', () => press || leave());
  over.addEventListener('contextmenu', (event) => menu(view, event));
  over.addEventListener('wheel', (event) => wheel(view, event, ...place(view, event)), { passive: false });
}

/** Whether a press is under way. */
export const isPressed = () => press !== null;

/** Cancel the gesture: Esc, or the right button. */
export function cancelPress() {
  STATES[press.state].cancel?.();
  press.state = 'spent';
}

function place(view, event) {
  const box = view.over.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

// --- pointer events

function down(view, event) {
  hasCancelled = false;
  if (!server.file || !server.pose) return;
  noteModifiers(event);
  const [x, y] = place(view, event);
  if (event.pointerType === 'touch') fingers.set(event.pointerId, [x, y]);
  if (press) return void secondFinger();
  if (event.button > MIDDLE && !(event.button === RIGHT && view.orbitBy)) return;
  // No focus, no text selection, no scrolling wheel of the middle button.
  event.preventDefault();
  document.activeElement?.blur?.();
  view.over.setPointerCapture(event.pointerId);
  press = {
    view,
    id: event.pointerId,
    button: event.button,
    x,
    y,
    state: 'still',
    target: null,
    picked: null,
    releasedAt: 0,
  };
  begin(view, event, x, y);
}

function begin(view, event, x, y) {
  const orbits = Boolean(view.orbitBy) && !event.shiftKey && !isKeyDown(' ');
  if (event.button === RIGHT) {
    press.state = 'aside';
    press.picked = pick(view, x, y);
  } else if (event.button === MIDDLE || isKeyDown(' ') || ui.tool === 'pan' || (orbits && event.altKey)) {
    press.state = 'panning';
    beginPan(view, x, y, orbits && (event.button === MIDDLE || event.altKey));
  } else if (drawsOn(view)) {
    press.state = 'sketching';
    sketch('down', view, x, y);
  } else {
    press.target = targetAt(view, x, y, event.pointerType === 'touch');
    if (!press.target) press.picked = pick(view, x, y);
  }
  setCursor(view, press.target);
}

function move(view, event) {
  if (!server.file || !server.pose) return;
  const [x, y] = place(view, event);
  if (fingers.has(event.pointerId)) moveFinger(view, event.pointerId, [x, y]);
  if (!press) return hoverAt(view, event, x, y);
  if (press.id !== event.pointerId || press.view !== view) return;
  if (event.buttons & RIGHT_DOWN && press.button !== RIGHT) {
    cancelPress();
    hasCancelled = true;
  } else STATES[press.state].move?.(view, event, x, y);
}

/** The pointer moves with nothing pressed. */
function hoverAt(view, event, x, y) {
  noteModifiers(event);
  if (drawsOn(view)) sketch('move', view, x, y);
  const target = hover(view, x, y, event.pointerType === 'touch');
  setCursor(view, target);
}

function up(view, event) {
  fingers.delete(event.pointerId);
  if (!press || press.id !== event.pointerId || press.view !== view) return;
  press.releasedAt = event.timeStamp;
  // The answer which part it was is still on its way: the drag ends when it has begun.
  if (press.state === 'asking') press.released = true;
  else finish(...place(view, event));
}

function onPointerLost(event) {
  fingers.delete(event.pointerId);
  if (press?.id !== event.pointerId) return;
  cancelPress();
  press = null;
}

/** The menu of what lies there, where it has one. */
function menu(view, event) {
  event.preventDefault();
  if (press || (hasCancelled && event.button === RIGHT) || !server.file || !server.pose) return;
  const target = targetAt(view, ...place(view, event), false);
  if (target?.menu) target.menu([event.clientX, event.clientY]);
  else if (!view.orbitBy) openAt(view, event); // where the right button orbits, its release opens one
}

// --- from state to state

/** A press that moves far enough is a drag, of what it began on. */
function leaveStill(view, event, x, y) {
  if (distance([press.x, press.y], [x, y]) < CLICK_PX) return;
  if (press.target) {
    press.state = beginOnTarget(view, press, press.target);
    STATES[press.state].move(view, event, x, y);
  } else {
    press.state = 'asking';
    press.newest = [event, x, y];
    beginWhenPicked(press);
  }
}

/** The right button pulls the view round, with Shift along. */
function leaveAside(view, event, x, y) {
  if (distance([press.x, press.y], [x, y]) < CLICK_PX) return;
  press.state = 'panning';
  beginPan(view, press.x, press.y, !event.shiftKey);
  setCursor(view, null);
  STATES.panning.move(view, event, x, y);
}

/** The menu of what the right button was pressed on. */
function openMenu({ view, picked }, x, y) {
  const box = view.over.getBoundingClientRect();
  openWhenPicked(view, picked, [box.left + x, box.top + y]);
}

/** The drag begins once it is known which part lies there, unless the press is over. */
async function beginWhenPicked(asked) {
  const { parts } = await asked.picked;
  if (press !== asked || press.state !== 'asking') return;
  press.state = beginOnSurface(press.view, press, parts[0]);
  const [event, x, y] = press.newest;
  STATES[press.state].move(press.view, event, x, y);
  if (press.released) finish(x, y);
}

function finish(x, y) {
  const done = press;
  press = null;
  STATES[done.state].end?.(done, x, y);
  setCursor(done.view, null);
}

function finishClick(done) {
  const { view, x, y, target, picked, releasedAt } = done;
  newest = done;
  // The time of the release counts, however late the page comes to it or learns which parts were there.
  const at = { x, y, time: releasedAt };
  if (target) {
    click(view, at, target, []);
    if (interaction.chosen) renameHandle();
  }
  // A click on a handle has overtaken those before it whose parts were not known yet.
  else picked.then((found) => (newest === done || !newest.target) && clickOn(view, at, found));
}

/** On parts of the body that is posed, else on another body, which is posed from then on. */
function clickOn(view, at, { parts, body }) {
  if (body && !parts.length) perform('poseBody', body);
  else click(view, at, null, parts);
}

/** A second finger takes over from a press that has not grabbed anything. */
function secondFinger() {
  if (fingers.size !== 2 || press.state === 'dragging') return;
  STATES[press.state].cancel?.();
  press.state = 'pinching';
}

function moveFinger(view, id, at) {
  const before = [...fingers.values()];
  fingers.set(id, at);
  if (press?.state === 'pinching' && fingers.size === 2) pinch(view, before, [...fingers.values()]);
}

// --- the cursor, which says what the pointer would do

function setCursor(view, target) {
  view.over.style.cursor = cursorFor(view, target);
}

function cursorFor(view, target) {
  if (interaction.drag || interaction.panning) return 'grabbing';
  if (isKeyDown(' ') || ui.tool === 'pan') return 'grab';
  if (isDrawingTool(ui.tool)) return sketchCursor(view);
  if (target?.cursor) return target.cursor;
  if (target) return ui.tool === 'size' ? 'crosshair' : 'grab';
  if (ui.tool === 'size') return 'crosshair';
  return interaction.over ? 'pointer' : '';
}
