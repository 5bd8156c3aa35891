// Part keyframes: keyframes of some limbs alone, while the rest of the body stays with the tracker.

import { send } from '../store/link.js';
import { selectedPart } from '../store/parts.js';
import { server } from '../store/state.js';
import { isSurface } from '../store/subject.js';
import { draftFrames, frame, isKey, segmentAt } from './playhead.js';

/** All of them: [{frame, parts, limbs, words}], by frame. */
export const partKeys = () => server.keys?.parts ?? [];

export const partKeyAt = (at = frame()) => partKeys().find((key) => key.frame === at);

/** Shift K: what was posed here, else the selected limb, is this frame's part keyframe. */
export function keyLimb() {
  send({ do: 'key_parts', frame: frame() });
}

export function whyNotKeyLimb() {
  const at = frame();
  if (isSurface()) return 'Surfaces are fitted to the whole body';
  if (isKey(at)) return `Frame ${at} is a keyframe of the whole body`;
  const segment = segmentAt(at);
  if (!segment || segment.first === at || segment.last === at) return 'Go between two keyframes';
  const part = selectedPart();
  const hasLimb = part && part.parent !== null;
  return hasLimb || draftFrames().includes(at) ? '' : 'Select a limb, or move one';
}

/** The limb of a part stays with the tracker again. about: {frame, parts}. */
export const unkeyMessage = ({ frame: at, parts }) => ({ do: 'unkey_parts', frame: at, parts });
