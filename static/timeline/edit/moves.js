// Where one wants to go next: keys, middles of intervals, the frame to key, the next problem.

import { server, ui, setUi } from '../../store/state.js';
import { lastFrame } from '../draw/scale.js';
import { frame, goTo, hold } from './head.js';

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
  const wanted = state === null ? PROBLEMS : [state];
  const places = (server.segments ?? [])
    .filter((segment) => wanted.includes(segment.state))
    .map(({ go, first, last }) => go ?? Math.floor((first + last) / 2))
    .sort((a, b) => a - b);
  if (places.length === 0) return;
  hold();
  goTo(places.find((place) => place > frame()) ?? places[0]);
}

export function togglePlaying() {
  setUi('playing', !ui.playing);
}
