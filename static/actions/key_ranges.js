// Ranges of frames with marks on them, such as keyframes: which are chosen by a click, which frames they
// have once moved or stretched. Everything here is a pure function of ascending lists of frames.

import { clamp } from '../controls/arithmetic.js';
import * as words from '../controls/words.js';

/** @typedef {number[]} Frames  Ascending, each once. */

const ascending = (frames) => [...new Set(frames)].sort((a, b) => a - b);

/** Those from one frame to another, in either order. @returns {Frames} */
export function between(marks, one, other) {
  const [first, last] = one < other ? [one, other] : [other, one];
  return marks.filter((at) => first <= at && at <= last);
}

/** With one of them chosen, or not any more. @returns {Frames} */
export const toggled = (chosen, at) => (chosen.includes(at) ? chosen.filter((one) => one !== at) : ascending([...chosen, at]));

/** @returns {Frames} */
export const joined = (some, others) => ascending([...some, ...others]);

/** Moved by as much, as far as the film reaches. @returns {Frames} */
export function shifted(frames, by, lastFrame) {
  const shift = clamp(Math.round(by), -frames[0], lastFrame - frames.at(-1));
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
export function stretched(frames, end, to, lastFrame) {
  const least = frames.length - 1;
  const [first, last] = end === 'last'
    ? [frames[0], clamp(Math.round(to), frames[0] + least, lastFrame)]
    : [clamp(Math.round(to), 0, frames.at(-1) - least), frames.at(-1)];
  const ratio = (last - first) / Math.max(1, frames.at(-1) - frames[0]);
  return apart(frames.map((at) => Math.round(first + (at - frames[0]) * ratio)), first, last);
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
export const listed = (frames) => words.joined(frames.length > 3 ? [...frames.slice(0, 2), `${frames.length - 2} more`] : frames);
