// How the film is played: its speed, in a loop or not, from an in point to an out point, and the keys that
// shuttle it. Speed and loop are kept in the browser, the points for each session.

import { clampFrame, lastFrame } from '../store/clip.js';
import { inBrowser } from '../store/storage.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { shuttled } from '../views/clock.js';
import { frame } from './playhead.js';

export const SPEEDS = [0.1, 0.25, 0.5, 1, 2];

/** @typedef {{ first: number | null, last: number | null }} Span  Null: not set. */

/** @type {Span} */
const NO_SPAN = { first: null, last: null };
const MOST_SPANS = 100;
const KEPT = { speed: 'keypose.speed', loop: 'keypose.loop', spans: 'keypose.spans' };

ui.speed = SPEEDS.find((speed) => String(speed) === inBrowser.read(KEPT.speed)) ?? 1;
ui.loop = inBrowser.read(KEPT.loop) === 'yes';

export function mountPlaying() {
  watch(['file'], readSpan);
  watch(['u:playing'], () => !ui.playing && setUi('shuttle', 1));
}

// --- playing

export function togglePlaying() {
  setUi('shuttle', 1);
  setUi('playing', !ui.playing);
}

export function playBack() {
  setUi('shuttle', -1);
  setUi('playing', true);
}

/** J while it plays: slower, then backward and faster. */
export const playSlower = () => setUi('shuttle', shuttled(ui.shuttle, -1));

/** L while it plays. */
export const playFaster = () => setUi('shuttle', shuttled(ui.shuttle, 1));

export const stop = () => setUi('playing', false);

export const whyNotPlay = () => (lastFrame() === 0 ? 'There is only one frame' : '');

/** "0.25×", "−2×" while it is shuttled. */
export const rateWords = () => `${ui.speed * ui.shuttle}×`.replace('-', '−');

export const speedWords = (speed) => `${speed}×`;

export function chooseSpeed(speed) {
  inBrowser.write(KEPT.speed, speed);
  setUi('speed', speed);
}

export function toggleLoop() {
  setUi('loop', !ui.loop);
  inBrowser.write(KEPT.loop, ui.loop ? 'yes' : 'no');
}

// --- in and out

export const hasSpan = () => ui.span.first !== null || ui.span.last !== null;

/**
 * A span with one of its ends at a frame; the other end gives way where they would cross.
 * @param {Span} span
 * @param {'first' | 'last'} end
 * @returns {Span}
 */
function withEnd(span, end, at) {
  const other = end === 'first' ? 'last' : 'first';
  const stays = span[other] !== null && (end === 'first' ? at < span[other] : at > span[other]);
  return /** @type {Span} */ ({ [end]: at, [other]: stays ? span[other] : null });
}

/** While an end is dragged the other stays. @returns {Span} */
export function withEndDragged(span, end, to) {
  const at = clampFrame(to);
  if (end === 'first') return { ...span, first: Math.min(at, (span.last ?? lastFrame()) - 1) };
  return { ...span, last: Math.max(at, (span.first ?? 0) + 1) };
}

export const setIn = (at = frame()) => keepSpan(withEnd(ui.span, 'first', at));
export const setOut = (at = frame()) => keepSpan(withEnd(ui.span, 'last', at));
export const clearSpan = () => keepSpan(NO_SPAN);
export const clearEnd = (end) => keepSpan({ ...ui.span, [end]: null });
export const whyNotClear = () => (hasSpan() ? '' : 'Neither an in point nor an out point is set');

/** @param {Span} span */
export function keepSpan(span) {
  setUi('span', span);
  if (!server.file) return;
  const { id } = server.file;
  const others = Object.entries(keptSpans()).filter(([other]) => other !== id);
  const all = hasSpan() ? [...others, [id, span]] : others;
  inBrowser.write(KEPT.spans, JSON.stringify(Object.fromEntries(all.slice(-MOST_SPANS))));
}

let known = null;

function readSpan() {
  const id = server.file?.id ?? null;
  if (id === known) return;
  known = id;
  setUi('span', id === null ? NO_SPAN : readable(keptSpans()[id], lastFrame()));
}

/** What was kept, as far as it fits the film. @returns {Span} */
export function readable(kept, last) {
  const isFrame = (at) => Number.isInteger(at) && at >= 0 && at <= last;
  const first = isFrame(kept?.first) ? kept.first : null;
  const end = isFrame(kept?.last) && kept.last > (first ?? 0) ? kept.last : null;
  return first === null && end === null ? NO_SPAN : { first, last: end };
}

function keptSpans() {
  try {
    const kept = JSON.parse(inBrowser.read(KEPT.spans) ?? '{}');
    return kept !== null && typeof kept === 'object' ? kept : {};
  } catch {
    return {}; // not as this page writes them
  }
}
