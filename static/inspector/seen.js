// How well a part is seen, in words.

import { isTracked } from '../actions/tracking.js';
import { range } from '../controls/words.js';
import { partNamed } from '../store/parts.js';
import { server } from '../store/state.js';
import { isSurface, words } from '../store/subject.js';

const HIDDEN = 0.35;
const PARTLY = 0.65;

/** How well a part is seen at the present frame, as a sentence. */
export function seenHere(part) {
  if (!part.parent && !lane(part)) return 'Moves the whole body';
  const value = lane(part)?.[server.view.frame];
  if (value === undefined || value === null) return restWord(part);
  const percent = `${Math.round(value * 100)} %`;
  if (value < HIDDEN) return `Hidden here: ${percent}`;
  return value < PARTLY ? `Partly visible here: ${percent}` : `Clearly visible here: ${percent}`;
}

/** The runs of frames [first, last] in which the part is hidden. */
export function hiddenRuns(part) {
  const runs = [];
  (lane(part) ?? []).forEach((value, frame) => {
    if (value === null || value >= HIDDEN) return;
    const last = runs.at(-1);
    if (last && last[1] === frame - 1) last[1] = frame;
    else runs.push([frame, frame]);
  });
  return runs;
}

/** Whether a segment holds a frame, and its motion, stopped midway, has come so far. */
function reaches({ first, last, unreached }, frame) {
  const isBeyond = unreached && unreached[0] <= frame && frame <= unreached[1];
  return first <= frame && frame <= last && !isBeyond;
}

/** "7", or "7–9". */
export const framesOf = ([first, last]) => (first === last ? `${first}` : range(first, last));

function lane(part) {
  return server.lanes?.[part.name];
}

/** A part without motions of its own moves with the one it is a child of. */
function follows({ parent }) {
  const label = partNamed(parent)?.label.toLowerCase();
  return label ? `Moves with the ${label}` : 'Not tracked';
}

function restWord(part) {
  if (part.tracked.length === 0 && !isSurface()) return follows(part);
  const here = server.view.frame;
  const known = (server.segments ?? []).some((one) => reaches(one, here) && isTracked(one));
  if (!known) return `Not ${words().done} yet`;
  return isSurface() ? 'Fitted, not rated' : 'Tracked. Previews are not rated';
}
