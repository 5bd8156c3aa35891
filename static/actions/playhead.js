// The playhead: the frame all tabs look at, moving it, and where one wants to go next. It shows its own
// frame at once; the server's answer takes over once it has applied the last move.

import { server, setUi, ui } from '../store/state.js';
import { send } from '../store/link.js';
import { paced } from '../controls/gesture.js';
import { bodyAhead, poseMessage } from './bodies.js';
import { clampFrame, lastFrame } from '../store/clip.js';

/** Where this tab has sent the playhead: {frame, n}, n null until it is sent. */
let wanted = null;
let stopping = false;

const sendSoon = paced(sendFrame);

function sendFrame(target) {
  wanted = { frame: target, n: send({ do: 'go', frame: target }) };
}

/** The frame the playhead stands on. */
export function frame() {
  if (wanted !== null && wanted.n !== null && (server.done ?? 0) >= wanted.n) wanted = null;
  return wanted === null ? clampFrame(server.view?.frame ?? 0) : wanted.frame;
}

/** Move the playhead. The server receives it before any edit that follows. */
export function goTo(target) {
  glideTo(target);
  if (!stopping) sendSoon.flush();
}

/** Move it as part of a drag: the server receives it once per animation frame, newest wins. */
export function glideTo(target) {
  const to = clampFrame(target);
  if (to === frame()) return;
  wanted = { frame: to, n: null };
  setUi('timeHead', to);
  sendSoon(to);
}

/** A drag has ended: send where. */
export function settle() {
  sendSoon.flush();
}

/** Stop playing: the playhead is about to be moved by hand. */
export function stopPlaying() {
  if (!ui.playing) return;
  setUi('playing', false);
  // Playing ends with the next animation frame, and sends where it ended: a move comes after that.
  stopping = true;
  requestAnimationFrame(() => (stopping = false));
}

export function keyFrames() {
  return server.keys?.frames ?? [];
}

/** Frames that are posed and not keyframes yet. */
export function draftFrames() {
  return server.keys?.drafts ?? [];
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
  stopPlaying();
  goTo(frame() + n);
}

export function toFirst() {
  stopPlaying();
  goTo(0);
}

export function toLast() {
  stopPlaying();
  goTo(lastFrame());
}

export function keyBeside(direction) {
  const keys = keyFrames();
  const at = frame();
  return direction < 0 ? keys.findLast((key) => key < at) : keys.find((key) => key > at);
}

/** To the previous (-1) or next (+1) keyframe; stays where there is none. */
export function toKey(direction) {
  const at = frame();
  const keys = [...keyFrames(), ...(server.keys?.parts ?? []).map((key) => key.frame)].sort((a, b) => a - b);
  const key = direction < 0 ? keys.findLast((one) => one < at) : keys.find((one) => one > at);
  stopPlaying();
  if (key !== undefined) goTo(key);
}

/** To the middle of the interval between two keys; the ends of the clip stand in for missing ones. */
export function middle() {
  const keys = keyFrames();
  const at = frame();
  const first = keys.findLast((key) => key <= at) ?? 0;
  const last = keys.find((key) => key > at) ?? lastFrame();
  stopPlaying();
  if (last > first) goTo(Math.floor((first + last) / 2));
}

/** The places of a draft that are still to be confirmed, in the order of their frames. */
export const placesToConfirm = () => server.draft?.proposals ?? [];

/** The first of them after the playhead, then from the start; undefined where there is none. */
export function placeAhead() {
  const places = placesToConfirm();
  return places.find((place) => place.frame > frame()) ?? places[0];
}

/** The frame to key next, or null: with no key yet it is the one that is looked at. */
export function suggestedFrame() {
  const place = placeAhead();
  if (place) return place.frame;
  const { frame: to = null, kind } = server.suggest ?? {};
  return to === null && kind === 'pose' && keyFrames().length === 0 ? frame() : to;
}

/** To the frame to key next, or to the body to go on with. */
export function next() {
  const body = bodyAhead();
  const to = body ? (body.places[0] ?? null) : suggestedFrame();
  stopPlaying();
  if (body) send(poseMessage(body.id));
  if (to !== null) goTo(to);
}

const PROBLEMS = ['check', 'lost', 'outdated', 'none'];

/** The segments that are not good, or those of one state. */
export function problems(state = null) {
  const states = state === null ? PROBLEMS : [state];
  return (server.segments ?? []).filter((segment) => states.includes(segment.state));
}

/** To the next problem after this frame; then from the start. */
export function nextProblem(state = null) {
  const places = problems(state)
    .map(({ go, first, last }) => go ?? Math.floor((first + last) / 2))
    .sort((a, b) => a - b);
  if (places.length === 0) return;
  stopPlaying();
  goTo(places.find((place) => place > frame()) ?? places[0]);
}
