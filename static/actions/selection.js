// The keyframes that are selected on the timeline: choosing them, moving and stretching them.
// Everything here is a pure function of ascending lists of frames. What is kept are frames; those at
// which no keyframe stands any more do not count.

import { clamp } from '../controls/arithmetic.js';
import * as words from '../controls/words.js';
import { count } from '../controls/words.js';
import { lastFrame } from '../store/clip.js';
import { isCaughtUp } from '../store/edits.js';
import { newStroke, send } from '../store/link.js';
import { server, setUi, ui, watch } from '../store/state.js';
import { deleteKey, isDraftAlone, sayDeleted, whyNotDelete } from './keying.js';
import { partKeys } from './parts.js';
import { frame, keyFrames } from './playhead.js';

/** @typedef {number[]} Frames  Ascending, each once. */

const ascending = (frames) => [...new Set(frames)].sort((a, b) => a - b);

/** Those from one frame to another, in either order. @returns {Frames} */
export function between(marks, one, other) {
  const [first, last] = one < other ? [one, other] : [other, one];
  return marks.filter((at) => first <= at && at <= last);
}

/** With one of them chosen, or not any more. @returns {Frames} */
export const toggled = (chosen, at) =>
  chosen.includes(at) ? chosen.filter((one) => one !== at) : ascending([...chosen, at]);

/** @returns {Frames} */
export const joined = (some, others) => ascending([...some, ...others]);

/** Moved by as much, as far as the film reaches. @returns {Frames} */
export function shifted(frames, by, filmEnd) {
  const shift = clamp(Math.round(by), -frames[0], filmEnd - frames.at(-1));
  return frames.map((at) => at + shift);
}

/**
 * Stretched so that its last frame, or with `end` "first" its first one, comes to lie at `to`, the
 * other end staying: times scale about that. Frames stay in order, each on its own; both ends stay
 * within the film.
 * @param {Frames} frames
 * @param {'first' | 'last'} end
 * @returns {Frames}
 */
export function stretched(frames, end, to, filmEnd) {
  const least = frames.length - 1;
  const [first, last] =
    end === 'last'
      ? [frames[0], clamp(Math.round(to), frames[0] + least, filmEnd)]
      : [clamp(Math.round(to), 0, frames.at(-1) - least), frames.at(-1)];
  const ratio = (last - first) / Math.max(1, frames.at(-1) - frames[0]);
  return apart(
    frames.map((at) => Math.round(first + (at - frames[0]) * ratio)),
    first,
    last,
  );
}

/** Ascending frames pushed apart where some fell together, between their ends. */
function apart(frames, first, last) {
  const there = [...frames];
  for (let i = 1; i < there.length; i += 1) there[i] = Math.max(there[i], there[i - 1] + 1);
  there[0] = first;
  there[there.length - 1] = last;
  for (let i = there.length - 2; i > 0; i -= 1) there[i] = Math.min(there[i], there[i + 1] - 1);
  return there;
}

/** The frames among `to` that marks stand at which are not among the moved. @returns {Frames} */
export function met(marks, moved, to, isCopy = false) {
  const gone = new Set(isCopy ? [] : moved);
  const stay = new Set(marks.filter((at) => !gone.has(at)));
  return to.filter((at) => stay.has(at));
}

/** "12 and 24", "12, 24 and 3 more". */
export const listed = (frames) =>
  words.joined(frames.length > 3 ? [...frames.slice(0, 2), `${frames.length - 2} more`] : frames);

/** @type {number[]} */
const NONE = [];
ui.timeKeys = NONE;

/** Where a range that Shift extends begins. @type {number | null} */
let anchor = null;

/** The frames that marks stand at which can be selected, ascending. */
export const marks = () => keyFrames();

/** Frames at which nothing can be put: those of keyframes of limbs, too. */
export const occupied = () => [...marks(), ...partKeys().map(({ frame: at }) => at)];

const isMark = (at) => marks().includes(at);

/** Undone, a move gives back what was selected before it. @type {{ from: number[], to: number[] } | null} */
let moved = null;

let known = { kept: NONE, keys: NONE, chosen: NONE };

/** The frames of the selected keyframes, ascending. @returns {number[]} */
export function selectedKeys() {
  const [kept, keys] = [ui.timeKeys ?? NONE, marks()];
  if (kept !== known.kept || keys !== known.keys) {
    const there = new Set(keys);
    const chosen = kept.filter((at) => there.has(at));
    known = { kept, keys, chosen: chosen.length ? chosen : NONE };
  }
  return known.chosen;
}

export const isSelected = (at) => selectedKeys().includes(at);

export function selectKeys(frames) {
  setUi('timeKeys', frames.length ? frames : NONE);
}

/** Whether any was selected. */
export function clearSelection() {
  const had = selectedKeys().length > 0;
  selectKeys(NONE);
  return had;
}

export const selectAll = () => selectKeys([...marks()]);

export const whyNotSelectAll = () => (marks().length ? '' : 'There is no keyframe yet');

/** A keyframe was clicked without a key held: from here on a range begins here. */
export function chooseOnly(at) {
  anchor = at;
  selectKeys(NONE);
}

/** With Ctrl one more or one less; the one that was clicked before counts as the first. */
export function toggleKey(at) {
  const before = selectedKeys();
  const first =
    before.length === 0 && anchor !== null && anchor === frame() && isMark(anchor) && anchor !== at ? [anchor] : [];
  anchor = at;
  selectKeys(toggled(joined(before, first), at));
}

/** The keyframe under the playhead, one more or one less. */
export const selectHere = () => selectKeys(toggled(selectedKeys(), frame()));

export const whyNotSelect = () => (isMark(frame()) ? '' : `Frame ${frame()} is not a keyframe`);

/** With Shift all from the one clicked before, or from the playhead, to this one. */
export function extendTo(at) {
  const from = anchor !== null && isMark(anchor) ? anchor : frame();
  selectKeys(between(marks(), from, at));
}

/** Those in a box, beside what was selected before it. */
export const selectBetween = (first, last, before = NONE) => selectKeys(joined(before, between(marks(), first, last)));

// --- what is done to all of them

/** Why they cannot stand at these frames, or ''. */
export function whyNotAt(frames, to, isCopy = false) {
  const taken = met(occupied(), frames, to, isCopy);
  if (!taken.length) return '';
  return taken.length === 1
    ? `Frame ${taken[0]} is already a keyframe`
    : `Frames ${listed(taken)} are already keyframes`;
}

/** They stand at these frames from now on, or are copied to them, and stay selected. */
export function retime(frames, to, isCopy = false) {
  if (frames.every((at, i) => at === to[i])) return;
  send({ do: 'retime_keys', frames, to, copy_them: isCopy });
  moved = { from: frames, to };
  selectKeys(to);
}

/** Why neither the selected keyframes can be deleted nor, without any, the one at this frame; or ''. */
export const whyNotDeleteAny = (at) => (at === undefined && selectedKeys().length ? '' : whyNotDelete(at));

/** Delete the selected keyframes; without any, or where one is named, that one. */
export function deleteAny(at) {
  const frames = selectedKeys();
  if (at !== undefined || !frames.length) return deleteKey(at);
  sayDeleted(send({ do: 'delete_keys', frames }), `${count(frames.length, 'keyframe')} deleted.`);
  return selectKeys(NONE);
}

export function deleteLabel(at) {
  if (at === undefined && selectedKeys().length > 1) return `Delete ${selectedKeys().length} keyframes`;
  const isOfSelected = at === undefined && selectedKeys().length > 0;
  return !isOfSelected && isDraftAlone(at ?? frame()) ? 'Delete draft' : 'Delete keyframe';
}

// --- a key that stays down moves them as one step of undo

/** @type {{ stroke: string, from: number[], to: number[] } | null} */
let nudging = null;

export function whyNotNudge(by) {
  const frames = selectedKeys();
  if (!frames.length) return 'Select keyframes first: drag a box over them';
  const to = shifted(frames, by, lastFrame());
  if (String(to) === String(frames)) return `The selection reaches the ${by < 0 ? 'first' : 'last'} frame`;
  return whyNotAt(frames, to);
}

/** Move them by some frames; each step is measured from where they stood when the key went down. */
export function nudge(by) {
  const now = ui.timeKeys;
  const to = shifted(now, by, lastFrame());
  if (nudging?.to !== now) {
    endNudge();
    nudging = { stroke: newStroke('keys'), from: now, to };
  }
  nudging.to = to;
  moved = { from: nudging.from, to };
  send({ do: 'retime_keys', frames: nudging.from, to, stroke: nudging.stroke });
  selectKeys(to);
}

function endNudge() {
  if (nudging) send({ do: 'end_stroke', stroke: nudging.stroke });
  nudging = null;
}

export function mountSelection() {
  addEventListener('keyup', endNudge);
  addEventListener('blur', endNudge);
  watch(['keys', 'file'], forgetGone);
}

let file = null;

/** A keyframe made later where one was deleted is not selected. */
function forgetGone() {
  const now = server.file?.path ?? null;
  if (now !== file) anchor = null;
  if (now !== file) selectKeys(NONE);
  else if (isCaughtUp() && ui.timeKeys.length !== selectedKeys().length) selectKeys(whatIsLeft());
  file = now;
}

function whatIsLeft() {
  const isUndone = moved !== null && ui.timeKeys === moved.to && moved.from.every(isMark);
  return isUndone ? moved.from : selectedKeys();
}
