// What the picture tells about a part, in words.

import { server } from '../store/state.js';
import { isSurface, words } from '../store/subject.js';

const HIDDEN = 0.35;
const PARTLY = 0.65;
const JUDGED = new Set(['good', 'check', 'lost']);

/** How well a part is seen at the present frame, as a sentence. */
export function seenHere(part) {
  if (!part.parent && !lane(part)) return 'Moves the whole body';
  const value = lane(part)?.[server.view.frame];
  if (value === undefined || value === null) return restWord(part);
  const percent = `${Math.round(value * 100)} %`;
  if (value < HIDDEN) return `Hidden here: ${percent}`;
  return value < PARTLY ? `Seen partly here: ${percent}` : `Seen well here: ${percent}`;
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
export function reaches({ first, last, unreached }, frame) {
  const isBeyond = unreached && unreached[0] <= frame && frame <= unreached[1];
  return first <= frame && frame <= last && !isBeyond;
}

export function range([first, last]) {
  return first === last ? `${first}` : `${first}–${last}`;
}

function lane(part) {
  return server.lanes?.[part.name];
}

function restWord(part) {
  if (part.tracked.length === 0 && !isSurface()) return 'Rides along, not tracked';
  const here = server.view.frame;
  const known = (server.segments ?? []).some((one) => reaches(one, here) && JUDGED.has(one.state));
  if (!known) return `Not ${words().done} yet`;
  return isSurface() ? 'Fitted, not judged' : 'Tracked, not judged in a preview';
}
