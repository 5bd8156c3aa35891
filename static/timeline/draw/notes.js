// Notes at the foot of the ruler: a filled mark where something is written, a hollow one for a flag.

import { nothing, svg } from '../../vendor/lit-html/lit-html.js';
import { allNotes } from '../../actions/notes.js';
import { nearest } from './keymarks.js';
import { RULER, visible, x } from './scale.js';

const HALF = 3.5;
const HIGH = 8;
const REACH_PX = 7;

/** Standing on the line below the ruler, its point down. */
export const noteMark = (at, half = HALF, high = HIGH) => {
  const foot = RULER - 1;
  return `M${(at - half).toFixed(1)} ${foot - high}h${2 * half}v${high - half}l${-half} ${half}l${-half} ${-half}z`;
};

export function drawNotes(without = null) {
  const { first, last } = visible();
  const seen = allNotes().filter((note) => note.frame >= first - 1 && note.frame <= last + 1 && note.frame !== without);
  if (!seen.length) return nothing;
  const marks = (notes) => notes.map((note) => noteMark(x(note.frame))).join('');
  return svg`<path class="note" d=${marks(seen.filter(({ text }) => text))} />
    <path class="note bare" d=${marks(seen.filter(({ text }) => !text))} />`;
}

/** The frame of the note at a place, or null. */
export function noteMarkAt({ x: px, y }) {
  if (y < RULER - HIGH - 3 || y > RULER + 1) return null;
  return nearest(allNotes().map((note) => note.frame), px, REACH_PX);
}
