// From pointer events to gestures: one press at a time, captured by its view.

import { isFree } from '../store/limits.js';
import { server, ui, setUi } from '../store/state.js';
import { beginDrag, cancelDrag, endDrag, moveDrag } from './drag.js';
import { hold } from './hold.js';
import { hover, leave, pick } from './hover.js';
import { isHeldKey, noteModifiers } from './keysheld.js';
import { beginPan, endPan, movePan, pinch, wheel } from './pan.js';
import { wedgeOf } from './rings.js';
import { click, select } from './select.js';
import { isDrawingTool, sketchDown, sketches, sketchMove, sketchUp } from './sketch.js';
import { distance } from './space.js';
import { targetAt } from './targets.js';
import { surfaceTool } from './tools.js';

const CLICK_PX = 3;
const LEFT = 0;
const MIDDLE = 1;
const RIGHT_HELD = 2;

let press = null;
const fingers = new Map();

/** Listen to a view's pointer. */
export function listenTo(view) {
  const { over } = view;
  over.addEventListener('pointerdown', (event) => down(view, event));
  over.addEventListener('pointermove', (event) => move(view, event));
  over.addEventListener('pointerup', (event) => up(view, event));
  over.addEventListener('pointercancel', (event) => lost(view, event));
  over.addEventListener('pointerleave', () => press || leave());
  over.addEventListener('contextmenu', (event) => event.preventDefault());
  over.addEventListener('wheel', (event) => wheel(view, event, ...place(view, event)), { passive: false });
}

/** Whether a press is under way. */
export const isPressed = () => press !== null;

/** Take everything back: Esc, or the right button. */
export function takeBack() {
  if (hold.drag) cancelDrag();
  if (hold.panning) endPan();
  press = press && { ...press, mode: 'spent' };
}

function place(view, event) {
  const box = view.over.getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

function down(view, event) {
  if (!server.file || !server.pose) return;
  noteModifiers(event);
  const [x, y] = place(view, event);
  if (event.pointerType === 'touch') fingers.set(event.pointerId, [x, y]);
  if (press) return void secondFinger();
  if (event.button !== LEFT && event.button !== MIDDLE) return;
  // No focus, no text selection, no scrolling wheel of the middle button.
  event.preventDefault();
  document.activeElement?.blur?.();
  view.over.setPointerCapture(event.pointerId);
  press = { view, id: event.pointerId, x, y, mode: 'still', target: null, parts: null };
  begin(view, event, x, y);
}

function begin(view, event, x, y) {
  if (event.button === MIDDLE || isHeldKey(' ') || ui.tool === 'pan') {
    press.mode = 'push';
    beginPan(view, x, y);
  } else if (sketches(view)) {
    press.mode = 'sketch';
    sketchDown(view, x, y);
  } else {
    press.target = targetAt(view, x, y, event.pointerType === 'touch');
    if (!press.target) press.picked = pick(view, x, y);
  }
  pointerLook(view, press.target);
}

function move(view, event) {
  if (!server.file || !server.pose) return;
  const [x, y] = place(view, event);
  if (fingers.has(event.pointerId)) moveFinger(view, event.pointerId, [x, y]);
  if (!press) return rest(view, event, x, y);
  if (press.id !== event.pointerId || press.view !== view) return;
  if (event.buttons & RIGHT_HELD) return takeBack();
  if (press.mode === 'push' && hold.panning) movePan(view, x, y);
  else if (press.mode === 'sketch') sketchMove(view, x, y);
  else if (press.mode === 'drag' && hold.drag) moveDrag(event, x, y);
  else if (press.mode === 'still' && distance([press.x, press.y], [x, y]) >= CLICK_PX) leaveStill(view, event, x, y);
  else if (press.mode === 'asking') press.newest = [event, x, y];
}

/** The pointer moves with nothing pressed. */
function rest(view, event, x, y) {
  noteModifiers(event);
  if (sketches(view)) sketchMove(view, x, y);
  const target = hover(view, x, y, event.pointerType === 'touch');
  pointerLook(view, target);
}

/** A press became a drag. */
function leaveStill(view, event, x, y) {
  if (press.target) {
    press.mode = 'drag';
    beginTarget(view, press.target);
    return moveDrag(event, x, y);
  }
  press.mode = 'asking';
  press.newest = [event, x, y];
  const asked = press;
  press.picked.then(({ parts }) => {
    if (press !== asked || press.mode !== 'asking') return;
    beginSurface(view, parts[0]);
    const [newest, newX, newY] = press.newest;
    if (press.mode === 'drag') moveDrag(newest, newX, newY);
    else movePan(view, newX, newY);
    if (press.gone) finish(view, newX, newY);
  });
  return undefined;
}

function beginTarget(view, target) {
  const from = view.toView([press.x, press.y]);
  if (target.tell) return beginMask(view, target, from);
  if (target.kind === 'trail') return startPush(view);
  const { handle = { kind: 'ring', part: target.part.name, axis: target.axis } } = target;
  const wedge = target.kind === 'ring' ? wedgeOf(target, press.x, press.y) : null;
  const open = handle.kind === 'ring' && isFree(handle.part, handle.axis);
  const tell = (at, held) => ({
    do: 'drag', view: view.name, handle, from, at, ...held, free: open || held.free,
  });
  const extra = { target, wedge, point: target.point, limb: ui.limb, hint: handle.kind, axis: handle.axis };
  // The selected part stays so while its own limb is pulled.
  if (target.kind !== 'ring' && !target.limb?.includes(server.view.selected)) select(target.part);
  beginDrag(view, press, tell, extra);
  if (handle.kind === 'end') setUi('limb', target.limb);
  pointerLook(view, target);
  return undefined;
}

function beginMask(view, target, from) {
  const tell = (at) => ({
    do: 'change_mask', index: target.index, ...target.tell([at[0] - from[0], at[1] - from[1]]),
  });
  beginDrag(view, press, tell, { target, hint: 'mask', gentle: true });
}

/** On a part its tool decides; on nothing the view is panned. */
function beginSurface(view, part) {
  if (!part || ui.tool === 'size') return startPush(view);
  press.mode = 'drag';
  const root = server.body.parts.find(({ name }) => name === part)?.parent == null;
  const tool = surfaceTool(ui.tool, root);
  const handle = { kind: 'surface', part, tool };
  const from = view.toView([press.x, press.y]);
  select(part);
  const tell = (at, held) => ({ do: 'drag', view: view.name, handle, from, at, ...held });
  const hint = { rotate: 'turn', move: 'root', ends: 'end' }[tool];
  beginDrag(view, press, tell, { target: { key: `part:${part}`, part }, hint });
  view.over.style.cursor = 'grabbing';
  return undefined;
}

function startPush(view) {
  press.mode = 'push';
  beginPan(view, press.x, press.y);
  view.over.style.cursor = 'grabbing';
}

function up(view, event) {
  fingers.delete(event.pointerId);
  if (!press || press.id !== event.pointerId || press.view !== view) return;
  const [x, y] = place(view, event);
  // The answer which part it was is still on its way: the drag ends when it has begun.
  if (press.mode === 'asking') press.gone = true;
  else finish(view, x, y);
}

function finish(view, x, y) {
  const done = press;
  press = null;
  if (done.mode === 'drag' && hold.drag) endDrag();
  else if (done.mode === 'push' && hold.panning) endPan();
  else if (done.mode === 'sketch') sketchUp(view, x, y);
  else if (done.mode === 'still') clicked(view, done);
  pointerLook(view, null);
}

function clicked(view, done) {
  // The time of the release counts, not that of the answer which parts were there.
  const at = { x: done.x, y: done.y, time: performance.now() };
  if (done.target) click(view, at, done.target, []);
  else done.picked.then(({ parts }) => click(view, at, null, parts));
}

function lost(view, event) {
  fingers.delete(event.pointerId);
  if (press?.id !== event.pointerId) return;
  takeBack();
  press = null;
}

/** A second finger takes over from a press that has not grabbed anything. */
function secondFinger() {
  if (fingers.size !== 2 || press.mode === 'drag') return;
  if (hold.panning) endPan();
  press.mode = 'pinch';
}

function moveFinger(view, id, at) {
  const before = [...fingers.values()];
  fingers.set(id, at);
  if (press?.mode === 'pinch' && fingers.size === 2) pinch(view, before, [...fingers.values()]);
}

/** The cursor says what the pointer would do. */
function pointerLook(view, target) {
  view.over.style.cursor = lookOf(view, target);
}

function lookOf(view, target) {
  if (hold.drag || hold.panning) return 'grabbing';
  if (isHeldKey(' ') || ui.tool === 'pan') return 'grab';
  if (isDrawingTool(ui.tool)) return view.name === 'main' ? 'crosshair' : '';
  if (target?.kind === 'trail' || target?.kind === 'mask') return 'pointer';
  if (target) return ui.tool === 'size' ? 'crosshair' : 'grab';
  if (ui.tool === 'size') return 'crosshair';
  return hold.over ? 'pointer' : '';
}
