// What the pointer and the keys do on the drawing. What a press, a click, a drag and a menu are of a mark
// is told by the mark.

import { partKeyAt } from '../actions/parts.js';
import { frame, goTo, isKey, segmentAt, stopPlaying } from '../actions/playhead.js';
import { scrollBy } from '../actions/window.js';
import { follow } from '../controls/gesture.js';
import { lastFrame } from '../store/clip.js';
import { pxPerFrame, zoomAt } from './draw/scale.js';
import { under } from './marks.js';
import { openFramesMenu } from './marks/frames.js';
import { openKeyMenu } from './marks/keyframes.js';
import { openPartKeyMenu } from './marks/part_keyframes.js';
import { openSegmentMenu } from './marks/segments.js';
import { grabbed, setGrabbed, setHovered } from './pointer.js';

const CLICK_PX = 3;
const LONG_PRESS_MS = 500;

let element = null;
let ground = null;
/** The gesture under way: {mark, what, gesture, start, moved}. */
let pressed = null;
let pressTimer = 0;
let stopFollowing = () => {};
let wasCancelled = false;

/** Listen on the drawing; `ground()` gives its rows, lanes and scroll. */
export function listenOn(drawing, groundOf, scrollLanes) {
  element = drawing;
  ground = groundOf;
  drawing.addEventListener('pointerdown', down);
  drawing.addEventListener('pointermove', point);
  drawing.addEventListener('pointerleave', () => pressed === null && setHovered(null));
  drawing.addEventListener('contextmenu', menu);
  drawing.addEventListener('keydown', onKey);
  drawing.addEventListener('dblclick', (event) => {
    const { mark, what } = under(placeOf(event), ground());
    mark.open?.(what);
  });
  drawing.addEventListener('wheel', (event) => wheel(event, scrollLanes), { passive: false });
  // A click takes the focus away from no view and gives it to nothing here.
  drawing.addEventListener('mousedown', (event) => event.preventDefault());
}

/** @returns {import('./mark.js').Place} */
function placeOf(event) {
  const box = element.getBoundingClientRect();
  return {
    x: event.clientX - box.left,
    y: event.clientY - box.top,
    ctrl: event.ctrlKey || event.metaKey,
    shift: event.shiftKey,
    alt: event.altKey,
    page: [event.clientX, event.clientY],
  };
}

function down(event) {
  wasCancelled = false;
  if (event.button !== 0) return;
  document.activeElement?.blur?.();
  const start = placeOf(event);
  const stage = ground();
  const { mark, what } = under(start, stage);
  stopFollowing();
  const gesture = mark.grab?.(what, start, stage) ?? null;
  pressed = gesture && { mark, what, gesture, start, moved: false };
  if (pressed === null) return;
  stopFollowing = follow(element, event, { move: drag, end: up, cancel, holdsKeys: () => Boolean(mark.edits) });
  if (event.pointerType === 'touch') pressTimer = setTimeout(() => longPress(start), LONG_PRESS_MS);
}

/** A long press is the right button of those who have none. */
function longPress(place) {
  if (pressed === null || pressed.moved) return;
  stopFollowing();
  cancel();
  openMenuOn(place);
}

/** With nothing pressed the cursor says what could be grabbed. */
function point(event) {
  if (pressed !== null) return;
  const { mark, what } = under(placeOf(event), ground());
  const { cursor = '', tip } = mark;
  element.style.cursor = typeof cursor === 'string' ? cursor : cursor(what);
  setHovered(tip ? what : null);
}

function drag(event) {
  const place = placeOf(event);
  const { mark, gesture, start, moved } = pressed;
  if (!moved && Math.hypot(place.x - start.x, place.y - start.y) < CLICK_PX) return;
  if (!moved) clearTimeout(pressTimer);
  pressed.moved = true;
  const held = gesture.move(place);
  if (held) setGrabbed({ kind: mark.kind, ...held });
}

function up(event) {
  const held = grabbed();
  const { mark, what, gesture, start, moved } = release();
  if (moved) gesture.end?.(held);
  else mark.click?.(what, start);
  point(event);
}

/** Cancelled; by the right button, when it comes with a move. */
function cancel(event) {
  release().gesture.cancel?.();
  wasCancelled = event?.type === 'pointermove';
}

function release() {
  const ended = pressed;
  clearTimeout(pressTimer);
  pressed = null;
  setGrabbed(null);
  return ended;
}

function menu(event) {
  event.preventDefault();
  // The right button pressed during a drag cancelled it, and asks for no menu.
  if (pressed !== null || wasCancelled) return;
  // From the keyboard the menu belongs to what the playhead stands on.
  const fromKeys = event.target.closest?.('.playhead') && event.button !== 2;
  if (fromKeys) openMenuAtHead();
  else openMenuOn(placeOf(event));
}

/** The menu of what the playhead stands on. */
function openMenuAtHead() {
  const { left, bottom } = element.querySelector('.playhead .flag').getBoundingClientRect();
  const page = [left, bottom];
  if (partKeyAt()) openPartKeyMenu(partKeyAt(), page);
  else if (isKey(frame())) openKeyMenu(frame(), page);
  else if (segmentAt(frame())) openSegmentMenu(segmentAt(frame()), page);
  else openFramesMenu(frame(), page);
}

function openMenuOn(place) {
  setHovered(null);
  const { mark, what } = under(place, ground());
  mark.menu?.(what, place);
}

function wheel(event, scrollLanes) {
  event.preventDefault();
  const place = placeOf(event);
  const unit = event.deltaMode === 1 ? 16 : 1;
  if (place.ctrl) {
    zoomAt(place.x, Math.exp(-event.deltaY * unit * 0.003));
    return;
  }
  const sideways = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
  const { rows } = ground();
  const overLanes = place.y >= rows.lanes.y && place.y < rows.lanes.y + rows.lanes.room;
  if (!sideways && overLanes && rows.lanes.full > rows.lanes.room + 1) {
    scrollLanes(event.deltaY * unit);
    return;
  }
  scrollBy(((event.deltaX || event.deltaY) * unit) / pxPerFrame());
}

const STEPS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };

/** The playhead reached with Tab: arrows, Page keys, Home and End move it, Enter opens its menu. */
function onKey(event) {
  if (!event.target.closest?.('.playhead') || event.ctrlKey || event.altKey) return;
  const by = STEPS[event.key];
  stopPlaying();
  if (by !== undefined) goTo(frame() + (event.shiftKey ? 10 * by : by));
  else if (event.key === 'Home') goTo(0);
  else if (event.key === 'End') goTo(lastFrame());
  else if (event.key === 'Enter') openMenuAtHead();
  else return;
  event.preventDefault();
  event.stopPropagation();
}
