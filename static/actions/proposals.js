// What is shown until it is applied or discarded: new sizes, and a reduction to keyframes. Until then
// its keyframes are shown on the timeline only.

import { send } from '../store/link.js';
import { selectedPart } from '../store/parts.js';
import { server, ui } from '../store/state.js';
import { isSurface } from '../store/clip.js';
import { isRoot, isTracked } from './tracking.js';

let isPressed = false; // whether a button or a key is held, here

export const isPreview = () => Boolean(server.sizes_preview);

export const applySizes = () => send({ do: 'apply_sizes' });

/** Returns whether there was anything to discard. */
export function discardSizes() {
  if (!isPreview()) return false;
  lookBack(false);
  send({ do: 'discard_sizes' });
  return true;
}

/** The body as it is, as long as something is held. */
export function lookBack(on) {
  if (isPressed === on) return;
  isPressed = on;
  if (!on || isPreview()) send({ do: 'look_before', on });
}

/** Enter and B, while new sizes are shown. */
export function onPreviewKey(chord, event) {
  if (!isPreview() || ui.sheet || ui.chooser || (chord !== 'Enter' && chord !== 'B')) return false;
  event.preventDefault();
  if (event.repeat) return true;
  if (chord === 'Enter') applySizes();
  else lookBack(true);
  return true;
}

/** How many segments have to be tracked again, as a sentence. */
export function outdatedWords() {
  const { outdated } = server.sizes_preview;
  if (!outdated) return '';
  return `Apply makes ${outdated} ${outdated === 1 ? 'segment' : 'segments'} outdated.`;
}

/** What to begin with: one keyframe in so many frames, a tolerance in space, or in the picture. */
export const USUAL = { every: 20, cm: 2, px: 5 };

export const isReducing = () => Boolean(server.reduction);

/** Why there is nothing to reduce, or ''. */
export function whyNotReduce() {
  if (isSurface()) return 'Only the motion of a video is reduced';
  const isThere =
    (server.segments ?? []).some(isTracked) || server.keys?.drafts.length > 1 || server.settings?.imported;
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
