// The motion reduced to keyframes: begun, with another tolerance, applied or discarded. Until then its
// keyframes are shown on the timeline only.

import { selectedPart } from '../store/parts.js';
import { send } from '../store/link.js';
import { server, ui } from '../store/state.js';
import { isSurface } from '../store/subject.js';
import { isTracked } from './tracking.js';
import { isRoot } from './reasons.js';

/** What to begin with: one keyframe in so many frames, a tolerance in space, or in the picture. */
export const USUAL = { every: 20, cm: 2, px: 5 };

export const isReducing = () => Boolean(server.reduction);

/** Why there is nothing to reduce, or ''. */
export function whyNotReduce() {
  if (isSurface()) return 'Only the motion of a video is reduced';
  const isThere = (server.segments ?? []).some(isTracked) || server.keys?.drafts.length > 1 || server.settings?.imported;
  return isThere ? '' : 'Track, draft or import a motion first';
}

/** Between the in and the out point, where these are set. */
export function beginReduction() {
  const { first, last } = ui.span;
  send({ do: 'reduce', every: USUAL.every, ...(first === null ? {} : { first }), ...(last === null ? {} : { last }) });
}

/**
 * What is asked for next: as shown, but for what changed.
 * @param {Partial<{ every: number | null, cm: number | null, px: number | null, limbs: string[], replacing: boolean }>} changed
 */
export function reductionMessage(changed) {
  const { from, to, goal, cm, px, limbs, replacing } = server.reduction;
  return { do: 'reduce', first: from, last: to, every: goal, cm, px, limbs, replacing, ...changed };
}

/** The part whose limb may be reduced by itself, or null. */
export function limbToReduce() {
  const part = selectedPart();
  return part && !isRoot() ? part : null;
}

/** Returns whether there were keyframes to apply. */
export function applyReduction() {
  if (!isReducing() || server.reduction.busy) return false;
  send({ do: 'apply_reduction' });
  return true;
}

/** Returns whether there was anything to discard. */
export function discardReduction() {
  if (!isReducing()) return false;
  send({ do: 'discard_reduction' });
  return true;
}

/** Enter, while its keyframes wait. */
export function onReductionKey(chord, event) {
  if (!isReducing() || chord !== 'Enter') return false;
  event.preventDefault();
  if (!event.repeat) applyReduction();
  return true;
}
