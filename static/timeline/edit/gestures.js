// What the pointer and the keys do on the drawing, and the gesture that begins there.

import { perform } from '../../actions/actions.js';
import { partKeyAt } from '../../actions/parts.js';
import { frame, goTo, isKey, segmentAt, stopPlaying } from '../../actions/playhead.js';
import { visitOrOpen } from '../../actions/review.js';
import {
  chooseOnly, clearSelection, extendTo, isSelected, selectedKeys, toggleKey,
} from '../../actions/selection.js';
import { isZoomed, scrollBy } from '../../actions/window.js';
import { follow } from '../../controls/gesture.js';
import { clampFrame, isSurface, lastFrame } from '../../store/clip.js';
import { server, ui } from '../../store/state.js';
import { curveKeyNear } from '../draw/curve.js';
import { placeNear } from '../draw/drafts.js';
import { keyNear, partNear } from '../draw/keymarks.js';
import { laneAt } from '../draw/lanes.js';
import { grabOverview } from '../draw/overview.js';
import { pinAt, proposalOf } from '../draw/pins.js';
import { noteMarkAt, reviewPlaceNear, spanEndAt } from '../draw/rulermarks.js';
import { BAR, frameAt, GUTTER, OVERVIEW, pxPerFrame, RULER, x, zoomAt } from '../draw/scale.js';
import { barOf } from '../draw/segments.js';
import { gripNear } from '../draw/selection.js';
import { grabAngle, grabHead, grabKey, selectFrom } from './drags.js';
import {
  openFramesMenu, openKeyMenu, openNoteMenu, openPinMenu, openProposalMenu, openSegmentMenu,
  openSelectionMenu,
} from './menus.js';
import { acceptAt, grabNote, grabPin, grabProposal, grabSpanEnd, openSpanMenu } from './mark_drags.js';
import { setHovered } from './pointer.js';
import { grabBox, grabKeys, grabSelectionEnd } from './range_drags.js';

const CLICK_PX = 3;
const LONG_PRESS_MS = 500;

let element = null;
let ground = null;
let gesture = null;
let start = null;
let moved = false;
let pressTimer = 0;
let stopFollowing = () => {};
let wasCancelled = false;

/** Listen on the drawing; `ground()` gives its rows, lanes and scroll. */
export function listenOn(drawing, groundOf, scrollLanes) {
  element = drawing;
  ground = groundOf;
  drawing.addEventListener('pointerdown', down);
  drawing.addEventListener('pointermove', point);
  drawing.addEventListener('pointerleave', () => gesture === null && setHovered(null));
  drawing.addEventListener('contextmenu', menu);
  drawing.addEventListener('dblclick', (event) => {
    const what = under(placeOf(event));
    if (what.kind === 'proposal') acceptAt(what);
    if (what.kind === 'note') perform('note', what.frame);
    if (what.kind === 'key' && partKeyAt(what.frame)) perform('keyWhole', what.frame);
  });
  drawing.addEventListener('wheel', (event) => wheel(event, scrollLanes), { passive: false });
  // A click takes the focus away from no view and gives it to nothing here.
  drawing.addEventListener('mousedown', (event) => event.preventDefault());
}

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

/** What is under a place: {kind, ...}; "ground" is the row of keyframes, "frames" everywhere else. */
function under(place) {
  const { rows, lanes, scroll } = ground();
  const isInKeys = place.y >= rows.keys.y && place.y < rows.keys.y + rows.keys.h;
  const grip = isInKeys ? gripNear(place.x) : null;
  if (grip !== null) return { kind: 'grip', end: grip };
  const spanEnd = spanEndAt(place);
  if (spanEnd !== null) return { kind: 'spanend', end: spanEnd };
  // A box over the first keyframe begins beside it.
  if (place.x < GUTTER) return { kind: isInKeys ? 'beside' : 'gutter' };
  const strip = isZoomed() && place.y > RULER - 2 && place.y < RULER + OVERVIEW + 2;
  if (strip) return { kind: 'overview' };
  const note = noteMarkAt(place);
  if (note !== null) return { kind: 'note', frame: note };
  const review = reviewPlaceNear(place.x, place.y);
  if (review !== null) return { kind: 'review', place: review };
  if (isInKeys) return inKeys(place, rows);
  const pin = pinAt(rows.pins, place);
  if (pin !== null) return pin;
  const lane = laneAt(rows, lanes, place.y, scroll);
  if (lane !== null) return { kind: 'lane', lane };
  const inCurve = rows.curve !== null && place.y >= rows.curve.y;
  if (inCurve && ui.chart === 'score' && !isSurface()) return { kind: 'chart' };
  const key = inCurve ? curveKeyNear(rows.curve, place.x, place.y) : null;
  return key === null ? { kind: 'frames' } : { kind: 'curvekey', frame: key };
}

function inKeys(place, rows) {
  const key = keyNear(place.x) ?? partNear(place.x);
  if (key !== null) return { kind: 'key', frame: key };
  const confirm = placeNear(place.x);
  if (confirm !== null) return { kind: 'place', frame: confirm.frame };
  if (Math.abs(place.y - rows.keys.middle) > BAR.half + 3) return { kind: 'ground' };
  const segment = (server.segments ?? []).find((s) => {
    const { from, to } = barOf(s);
    return place.x >= from - 1 && place.x <= to + 1;
  });
  return segment ? { kind: 'segment', segment } : { kind: 'ground' };
}

/** A click on a keyframe goes there; with Shift it extends the selection, with Ctrl it toggles the keyframe. */
function clickKey(at, place) {
  if (place.ctrl) return toggleKey(at);
  if (place.shift) return extendTo(at);
  chooseOnly(at);
  return goTo(at);
}

const isAmongSelected = (at) => isSelected(at) && selectedKeys().length > 1;

const grabKeyAt = (at, place) => {
  const click = () => clickKey(at, place);
  if (isAmongSelected(at)) return grabKeys(at, place, click);
  const alone = grabKey(at, place, click);
  const end = () => {
    clearSelection();
    alone.end();
  };
  return { ...alone, end };
};

/** A click on the row goes there and lets go of the selection, then does what else it does here. */
function clickGround(place, more = () => {}) {
  clearSelection();
  stopPlaying();
  goTo(frameAt(place.x));
  more();
}

function begin(what, place) {
  switch (what.kind) {
    case 'overview':
      return grabOverview(place.x);
    case 'key':
      return grabKeyAt(what.frame, place);
    case 'note':
      return grabNote(what.frame, place);
    case 'grip':
      return grabSelectionEnd(what.end, place);
    case 'spanend':
      return grabSpanEnd(what.end, place);
    case 'beside':
      return grabBox(place, () => {});
    case 'ground':
      return grabBox(place, () => clickGround(place));
    case 'place':
      return grabHead({ ...place, x: x(what.frame) });
    case 'review':
      return grabHead({ ...place, x: x(what.place.frame) }, () => visitOrOpen(what.place.id));
    case 'pin':
      return grabPin(what, place);
    case 'proposal':
      return grabProposal(what, place);
    case 'curvekey':
      return grabAngle(what.frame, ground().rows.curve, place);
    case 'segment':
      return grabBox(place, () => clickGround(place, () => openSegmentMenu(what.segment, place.page)));
    case 'lane':
      return grabHead(place, () => selectFrom(what.lane, frame()));
    case 'frames':
      return grabHead(place);
    default:
      return null;
  }
}

function down(event) {
  wasCancelled = false;
  if (event.button !== 0) return;
  document.activeElement?.blur?.();
  const place = placeOf(event);
  const what = under(place);
  stopFollowing();
  gesture = begin(what, place);
  if (gesture === null) return;
  start = place;
  moved = false;
  stopFollowing = follow(element, event, { move: drag, end: up, cancel, holdsKeys: () => Boolean(gesture.edits) });
  if (event.pointerType === 'touch') pressTimer = setTimeout(() => press(what, place), LONG_PRESS_MS);
}

/** A long press is the right button of those who have none. */
function press(what, place) {
  if (gesture === null || moved) return;
  stopFollowing();
  cancel();
  openMenuOn(what, place);
}

/** With nothing pressed the cursor says what could be grabbed. */
function point(event) {
  if (gesture === null) pointAt(under(placeOf(event)));
}

function drag(event) {
  const place = placeOf(event);
  if (!moved && Math.hypot(place.x - start.x, place.y - start.y) < CLICK_PX) return;
  if (!moved) clearTimeout(pressTimer);
  moved = true;
  gesture.move(place);
}

function up(event) {
  const ended = gesture;
  drop();
  if (moved) ended.end();
  else (ended.click ?? ended.end)();
  pointAt(under(placeOf(event)));
}

/** Cancelled; by the right button, when it comes with a move. */
function cancel(event) {
  const ended = gesture;
  drop();
  ended.cancel();
  wasCancelled = event?.type === 'pointermove';
}

function drop() {
  clearTimeout(pressTimer);
  gesture = null;
}

const CURSORS = {
  key: 'grab', note: 'grab', pin: 'grab', overview: 'grab', grip: 'ew-resize', spanend: 'ew-resize', curvekey: 'ns-resize',
  segment: 'pointer', place: 'pointer', proposal: 'pointer',
};

function pointAt(what) {
  element.style.cursor = (what.kind === 'pin' && what.end !== 'middle' ? 'ew-resize' : CURSORS[what.kind]) ?? '';
  if (what.kind === 'segment') setHovered({ kind: 'segment', first: what.segment.first });
  else if (['key', 'grip', 'curvekey', 'place', 'pin', 'proposal', 'note'].includes(what.kind)) setHovered(what);
  else setHovered(null);
}

function menu(event) {
  event.preventDefault();
  // The right button pressed during a drag cancelled it, and asks for no menu.
  if (gesture !== null || wasCancelled) return;
  // From the keyboard the menu belongs to what the playhead stands on.
  const fromKeys = event.target.closest?.('.playhead') && event.button !== 2;
  if (fromKeys) openMenuAtHead();
  else openMenuOn(under(placeOf(event)), placeOf(event));
}

/** The menu of the key or the segment the playhead stands on. */
export function openMenuAtHead() {
  const { left, bottom } = element.querySelector('.playhead .flag').getBoundingClientRect();
  const page = [left, bottom];
  if (isKey(frame()) || partKeyAt()) openKeyMenu(frame(), page);
  else if (segmentAt(frame())) openSegmentMenu(segmentAt(frame()), page);
  else openFramesMenu(frame(), page);
}

const WHEREVER = ['frames', 'lane', 'chart'];

function openMenuOn(what, place) {
  setHovered(null);
  if (what.kind === 'segment') openSegmentMenu(what.segment, place.page, clampFrame(frameAt(place.x)));
  if (what.kind === 'note') openNoteMenu(what.frame, place.page);
  if (WHEREVER.includes(what.kind)) openFramesMenu(clampFrame(frameAt(place.x)), place.page);
  if (what.kind === 'grip' || (what.kind === 'key' && isAmongSelected(what.frame))) openSelectionMenu(place.page);
  else if (what.kind === 'key' || what.kind === 'curvekey') openKeyMenu(what.frame, place.page);
  if (what.kind === 'spanend') openSpanMenu(what.end, place.page);
  if (what.kind === 'pin') openPinMenu(what.index, place.page);
  if (what.kind === 'proposal') openProposalMenu(proposalOf(what), place.page);
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
export function headKeys(drawing) {
  drawing.addEventListener('keydown', (event) => {
    if (!event.target.closest?.('.playhead') || event.ctrlKey || event.altKey) return;
    if (!moveByKey(event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

function moveByKey(event) {
  const by = STEPS[event.key];
  stopPlaying();
  if (by !== undefined) goTo(frame() + (event.shiftKey ? 10 * by : by));
  else if (event.key === 'Home') goTo(0);
  else if (event.key === 'End') goTo(lastFrame());
  else if (event.key === 'Enter') openMenuAtHead();
  else return false;
  return true;
}
