// The playhead: the frame all tabs look at, moving it, and where one wants to go next. It shows its own
// frame at once; the server's answer takes over as soon as it has heard of the last move.

import { server, setUi, ui } from '../../store/state.js';
import { send } from '../../store/link.js';
import { paced } from '../../controls/gesture.js';
import { clampFrame, lastFrame } from '../draw/scale.js';

/** Where this tab has sent the playhead: {frame, n}, n null until it is told. */
let wanted = null;
let stopping = false;

const tellSoon = paced(tell);

function tell(target) {
  wanted = { frame: target, n: send({ do: 'go', frame: target }) };
}

/** The frame the playhead stands on. */
export function frame() {
  if (wanted !== null && wanted.n !== null && (server.done ?? 0) >= wanted.n) wanted = null;
  return wanted === null ? clampFrame(server.view?.frame ?? 0) : wanted.frame;
}

/** Move the playhead. The server hears of it before any edit that follows. */
export function goTo(target) {
  glideTo(target);
  if (!stopping) tellSoon.flush();
}

/** Move it as part of a drag: the server hears of it once per animation frame, newest wins. */
export function glideTo(target) {
  const to = clampFrame(target);
  if (to === frame()) return;
  wanted = { frame: to, n: null };
  setUi('timeHead', to);
  tellSoon(to);
}

/** A drag has ended: tell where. */
export function settle() {
  tellSoon.flush();
}

/** Stop playing: whoever takes the playhead in hand wants it to stay. */
export function hold() {
  if (!ui.playing) return;
  setUi('playing', false);
  // Playing ends with the next animation frame, and tells where it ended: a move comes after that.
  stopping = true;
  requestAnimationFrame(() => (stopping = false));
}

export function keyFrames() {
  return server.keys?.frames ?? [];
}

export function isKey(at) {
  return keyFrames().includes(at);
}

/** The keys around a frame, [first, last]; on a key, the keys before and after it. */
export function around(at) {
  const keys = keyFrames();
  if (keys.length === 0) return null;
  const before = keys.findLast((key) => key < at);
  const after = keys.find((key) => key > at);
  if (isKey(at)) return [before ?? at, after ?? at];
  return before === undefined || after === undefined ? null : [before, after];
}

/** The segment a frame lies in; on a key the one that begins there, on the last key the last. */
export function segmentAt(at) {
  const segments = server.segments ?? [];
  return segments.find((s) => s.first <= at && at < s.last) ?? segments.find((s) => s.last === at);
}

export function step(n) {
  hold();
  goTo(frame() + n);
}

export function toFirst() {
  hold();
  goTo(0);
}

export function toLast() {
  hold();
  goTo(lastFrame());
}

export function keyBeside(direction) {
  const keys = keyFrames();
  const at = frame();
  return direction < 0 ? keys.findLast((key) => key < at) : keys.find((key) => key > at);
}

/** To the previous (-1) or next (+1) keyframe; stays where there is none. */
export function toKey(direction) {
  const key = keyBeside(direction);
  hold();
  if (key !== undefined) goTo(key);
}

/** To the middle of the interval between two keys; the ends of the clip stand in for missing ones. */
export function middle() {
  const keys = keyFrames();
  const at = frame();
  const first = keys.findLast((key) => key <= at) ?? 0;
  const last = keys.find((key) => key > at) ?? lastFrame();
  hold();
  if (last > first) goTo(Math.floor((first + last) / 2));
}

/** The frame to key next, or null: with no key yet it is the one that is looked at. */
export function suggestedFrame() {
  const { frame: to = null, kind } = server.suggest ?? {};
  return to === null && kind === 'pose' && keyFrames().length === 0 ? frame() : to;
}

/** To the frame to key next. */
export function next() {
  const to = suggestedFrame();
  hold();
  if (to !== null) goTo(to);
}

const PROBLEMS = ['check', 'lost', 'outdated', 'none'];

/** To the next segment that is not good, or of one state, after this frame; then from the start. */
export function nextProblem(state = null) {
  const states = state === null ? PROBLEMS : [state];
  const places = (server.segments ?? [])
    .filter((segment) => states.includes(segment.state))
    .map(({ go, first, last }) => go ?? Math.floor((first + last) / 2))
    .sort((a, b) => a - b);
  if (places.length === 0) return;
  hold();
  goTo(places.find((place) => place > frame()) ?? places[0]);
}

export function togglePlaying() {
  setUi('playing', !ui.playing);
}

const STEPS = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageDown: -10, PageUp: 10 };

/** The playhead reached with Tab: arrows, Page keys, Home and End move it, Enter opens its menu. */
export function headKeys(drawing, openMenu) {
  drawing.addEventListener('keydown', (event) => {
    if (!event.target.closest?.('.playhead') || event.ctrlKey || event.altKey) return;
    if (!pressed(event, openMenu)) return;
    event.preventDefault();
    event.stopPropagation();
  });
}

function pressed(event, openMenu) {
  const by = STEPS[event.key];
  hold();
  if (by !== undefined) goTo(frame() + (event.shiftKey ? 10 * by : by));
  else if (event.key === 'Home') goTo(0);
  else if (event.key === 'End') goTo(lastFrame());
  else if (event.key === 'Enter') openMenu(flagOf(event.target));
  else return false;
  return true;
}

/** Where the menu of the playhead stands. */
function flagOf(head) {
  const { left, bottom } = head.querySelector('.flag').getBoundingClientRect();
  return [left, bottom];
}
